#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "gpu/resource.h"

namespace dapple::gpu {

/// Bindings are set 0, numbered from 0: first `storage_buffers` storage buffers, then `sampled_images` images
/// read by texelFetch (uniform sampler2D; 3-D images: sampler3D, filtered). Push constants are one block of
/// `push_bytes` (at most 128), the same for all stages. Blocks are `layout(scalar)`. Vertex and fragment
/// shaders declare their storage buffers `readonly`: writing from them is a feature that not every device
/// has, and none is needed here.
struct Interface {
    std::uint32_t storage_buffers = 0;
    std::uint32_t sampled_images = 0;
    std::uint32_t push_bytes = 0;
};

class ComputePipeline {
public:
    ComputePipeline(Device& device, std::string_view name, std::span<const std::uint32_t> spirv,
                    Interface interface);
    ~ComputePipeline();
    ComputePipeline(ComputePipeline&&) noexcept;
    ComputePipeline& operator=(ComputePipeline&&) noexcept;
    struct State;
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

enum class Topology { points, triangles };
enum class Blend { none, add };
/// Faces that are not drawn: a face is front where its corners are counter-clockwise in the picture.
enum class Cull { none, front };

/// Vertices are pulled from storage buffers by gl_VertexIndex; an index buffer is optional at the draw. The
/// viewport is the whole target: clip space (-1, -1) is the top left corner of pixel (0, 0), y points down.
/// Points are squares of gl_PointSize pixels (up to Device::largest_point_size).
/// Primitives blend in their order.
struct RasterDescription {
    Interface interface {};
    Topology topology = Topology::triangles;
    Blend blend = Blend::none;
    Cull cull = Cull::none;
    std::vector<Format> color_formats{};
    bool depth_test = false;  ///< less-or-equal against a depth32f attachment cleared to 1
};

class RasterPipeline {
public:
    RasterPipeline(Device& device, std::string_view name, std::span<const std::uint32_t> vertex_spirv,
                   std::span<const std::uint32_t> fragment_spirv, const RasterDescription& description);
    ~RasterPipeline();
    RasterPipeline(RasterPipeline&&) noexcept;
    RasterPipeline& operator=(RasterPipeline&&) noexcept;
    struct State;
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace dapple::gpu
