#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/stats.h"
#include "gpu/pipeline.h"
#include "gpu/resource.h"

namespace dapple::gpu {

/// What a pass binds, in the order of its pipeline's Interface. Storage buffers that it writes are listed in
/// `writes` too, so that barriers follow from the declaration.
struct Bindings {
    std::vector<const Buffer*> buffers{};
    std::vector<const Image*> images{};
    std::vector<const Buffer*> writes{};
    std::vector<std::byte> push{};

    template <class T>
    void set_push(const T& value) {
        const auto bytes = std::as_bytes(std::span<const T, 1>(&value, 1));
        push.assign(bytes.begin(), bytes.end());
    }
};

struct Draw {
    std::uint32_t vertices = 0;  ///< or indices, with an index buffer (32 bit)
    const Buffer* index_buffer = nullptr;
};

/// A rectangle of a 2-D image.
struct Texels {
    int left = 0, top = 0, columns = 0, rows = 0;
};

struct Targets {
    std::vector<const Image*> colors{};
    const Image* depth = nullptr;
    bool clear = true;  ///< colours to 0, depth to 1; else their contents are kept
};

/// Passes in the order of submission; each has a name, declares what it reads and writes (barriers follow),
/// and gets a pair of timestamps. Wrong bindings and targets throw std::logic_error with a sentence; a
/// storage buffer larger than Device::largest_storage_range throws Error(device). Buffers, images and
/// pipelines may be moved, but not destroyed, before run(), which submits all, waits, reports pass times to
/// `stats`, and empties the list.
class PassList {
public:
    explicit PassList(Device& device);
    ~PassList();
    void compute(std::string_view name, const ComputePipeline& pipeline, Bindings bindings,
                 std::array<std::uint32_t, 3> groups);
    void draw(std::string_view name, const RasterPipeline& pipeline, Bindings bindings, Targets targets,
              Draw draw);
    /// Tightly packed rows, in the image's own format.
    void copy(std::string_view name, const Image& from, const Buffer& to);
    void copy(std::string_view name, const Buffer& from, const Image& to);
    void copy(std::string_view name, const Image& from, const Texels& texels, const Buffer& to);
    /// The wall and CPU time of the whole run is shared out to the passes in proportion to their device time.
    /// The first run of a pipeline includes its compilation by the driver.
    void run(FrameStats& stats);  // throws Error(device)

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::gpu
