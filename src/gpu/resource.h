#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "gpu/device.h"

namespace dapple::gpu {

/// A storage, vertex and index buffer that the host reads and writes through one lasting mapping (on devices
/// without such memory: through a staging copy around each pass list). Move-only owner; freed with the
/// object, which must outlive the PassList::run that uses it.
class Buffer {
public:
    Buffer(Device& device, std::string_view name, std::size_t bytes);
    ~Buffer();
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) noexcept;
    std::size_t bytes() const;
    template <class T>
    std::span<T> as() {
        return {static_cast<T*>(data()), bytes() / sizeof(T)};
    }
    void* data();

    struct State;
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

enum class Format { rgba32f, rg32f, r32f, r32u, depth32f };

/// A 2-D image that passes render into or read; copied to and from buffers by passes.
class Image {
public:
    Image(Device& device, std::string_view name, int width, int height, Format format);
    ~Image();
    Image(Image&&) noexcept;
    Image& operator=(Image&&) noexcept;
    int width() const;
    int height() const;
    Format format() const;

    struct State;
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace dapple::gpu
