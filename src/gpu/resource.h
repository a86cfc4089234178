#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "gpu/device.h"

namespace dapple::gpu {

/// Where a buffer's memory should lie; a matter of speed only.
enum class BufferMemory {
    host,    ///< cached for the host: for what it reads back
    device,  ///< the device's own where the host can write into it: for what it only fills, in order
};

/// A storage, vertex, index and indirect buffer that the host reads and writes through one lasting mapping of
/// host-visible, coherent memory. Every Vulkan device has such memory, so there is one path; where it lies
/// across a bus it is correct and slow. The host may touch it whenever no PassList::run is under way. New
/// contents are undefined. Move-only owner; freed with the object, which must outlive the PassList::run that
/// uses it. Throws Error(device) where memory ends.
class Buffer {
public:
    Buffer(Device& device, std::string_view name, std::size_t bytes,
           BufferMemory memory = BufferMemory::host);
    ~Buffer();
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) noexcept;
    std::size_t bytes() const;  ///< as asked for; may be 0
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

enum class Format { rgba32f, rg32f, r32f, r16f, r32u, depth32f };

/// Texels along the axes of a 3-D image.
struct Extent {
    int width, height, depth;
};

/// A 2-D image that passes render into or read, or a 3-D image that they only read; copied to and from
/// buffers by passes. New contents are undefined: clear at the first draw, or copy into it. Throws
/// Error(device) for sizes that the device does not take.
class Image {
public:
    Image(Device& device, std::string_view name, int width, int height, Format format);
    /// 3-D: shaders sample it with linear filtering (uniform sampler3D), beyond its faces as at them. r16f
    /// only: not every device filters others.
    Image(Device& device, std::string_view name, Extent size);
    ~Image();
    Image(Image&&) noexcept;
    Image& operator=(Image&&) noexcept;
    int width() const;
    int height() const;
    int depth() const;  ///< 1: a 2-D image
    Format format() const;

    struct State;
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace dapple::gpu
