#pragma once
#include <ImfIO.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include <Iex.h>

/// OpenEXR's streams on memory: files go through our own checked layer, whole. Only for exr.cpp.
namespace dapple::image {

class MemoryReader final : public Imf::IStream {
public:
    MemoryReader(std::span<const std::byte> bytes, const std::string& name)
        : Imf::IStream(name.c_str()), bytes_(bytes) {}

    bool read(char target[], int count) override {
        const auto wanted = static_cast<std::size_t>(count);
        if (count < 0 || wanted > bytes_.size() - position_) throw Iex::InputExc("the file ends too early");
        std::memcpy(target, bytes_.data() + position_, wanted);
        position_ += wanted;
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override {
        if (position > bytes_.size()) throw Iex::InputExc("a block lies beyond the end of the file");
        position_ = static_cast<std::size_t>(position);
    }

private:
    std::span<const std::byte> bytes_;
    std::size_t position_ = 0;
};

class MemoryWriter final : public Imf::OStream {
public:
    explicit MemoryWriter(std::vector<std::byte>& bytes) : Imf::OStream("memory"), bytes_(bytes) {}

    void write(const char source[], int count) override {
        const auto size = static_cast<std::size_t>(count);
        if (position_ + size > bytes_.size()) bytes_.resize(position_ + size);
        std::memcpy(bytes_.data() + position_, source, size);
        position_ += size;
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = static_cast<std::size_t>(position); }

private:
    std::vector<std::byte>& bytes_;
    std::size_t position_ = 0;
};

}  // namespace dapple::image
