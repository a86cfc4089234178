#include "methods/reference/progress_file.h"

#include <cstring>
#include <filesystem>
#include <span>
#include <type_traits>
#include <vector>

#include "base/checked_file.h"
#include "base/error.h"
#include "base/hash.h"

namespace dapple::reference {
namespace {

/// Changes whenever the meaning of the file, or of the passes that it counts, does.
constexpr char kHeader[] = "dapple reference progress 3\n";
constexpr std::size_t kHashBytes = 32;

class Writer {
public:
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        put_bytes(std::as_bytes(std::span(&value, 1)));
    }
    void put_bytes(std::span<const std::byte> data) { bytes.insert(bytes.end(), data.begin(), data.end()); }

    std::vector<std::byte> bytes;
};

/// Reads in order; `good` turns false where the data end too early.
class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    template <class T>
    T get() {
        T value{};
        get_into(std::span(&value, 1));
        return value;
    }
    template <class T>
    void get_into(std::span<T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        good = good && bytes_.size() >= values.size_bytes();
        if (!good) return;
        std::memcpy(values.data(), bytes_.data(), values.size_bytes());
        bytes_ = bytes_.subspan(values.size_bytes());
    }
    std::size_t left() const { return bytes_.size(); }

    bool good = true;

private:
    std::span<const std::byte> bytes_;
};

std::string text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Progress read_progress(const std::string& path, const std::string& job) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return {};
    std::vector<std::byte> bytes;
    try {
        bytes = read_whole_file(path);
    } catch (const Error&) {
        return {};
    }
    const std::string head = kHeader + content_hash(job);
    if (bytes.size() < head.size() + kHashBytes) return {};
    const std::span<const std::byte> all(bytes);
    const auto body = all.first(bytes.size() - kHashBytes);
    if (text_of(all.last(kHashBytes)) != content_hash(body.data(), body.size()) ||
        text_of(body.first(head.size())) != head)
        return {};
    Reader reader(body.subspan(head.size()));
    Progress progress;
    while (reader.good && reader.left() > 0) {
        const auto quantity = reader.get<Quantity>();
        const auto sample = reader.get<int>();
        const auto branch = reader.get<int>();
        RoundEstimate estimate;
        estimate.strata = reader.get<std::uint64_t>();
        estimate.passes = reader.get<std::uint64_t>();
        estimate.rays = reader.get<std::uint64_t>();
        estimate.done = reader.get<std::uint8_t>() != 0;
        estimate.extinguished = reader.get<std::uint8_t>() != 0;
        const auto pixels = reader.get<std::uint64_t>();
        if (!reader.good || pixels > reader.left() / (2 * sizeof(glm::dvec3))) return {};
        estimate.mean.resize(pixels);
        estimate.deviation.resize(pixels);
        reader.get_into(std::span(estimate.mean));
        reader.get_into(std::span(estimate.deviation));
        progress[{quantity, sample, branch}] = std::move(estimate);
    }
    return reader.good ? progress : Progress{};
}

void write_progress(const std::string& path, const std::string& job, const Progress& progress) {
    Writer writer;
    const std::string head = kHeader + content_hash(job);
    writer.put_bytes(std::as_bytes(std::span(head)));
    for (const auto& [layer, estimate] : progress) {
        writer.put(std::get<0>(layer));
        writer.put(std::get<1>(layer));
        writer.put(std::get<2>(layer));
        writer.put(estimate.strata);
        writer.put(estimate.passes);
        writer.put(estimate.rays);
        writer.put(static_cast<std::uint8_t>(estimate.done));
        writer.put(static_cast<std::uint8_t>(estimate.extinguished));
        writer.put(static_cast<std::uint64_t>(estimate.mean.size()));
        writer.put_bytes(std::as_bytes(std::span(estimate.mean)));
        writer.put_bytes(std::as_bytes(std::span(estimate.deviation)));
    }
    const std::string hash = content_hash(writer.bytes.data(), writer.bytes.size());
    writer.put_bytes(std::as_bytes(std::span(hash)));
    write_file_atomically(path, writer.bytes);
}

}  // namespace dapple::reference
