#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "layout/mesh_cell.h"
#include "methods/caustic_mesh/cell_renderer.h"
#include "methods/device_raster.h"
#include "spirv/caustic_mesh_cell_1_frag.h"
#include "spirv/caustic_mesh_cell_4_frag.h"
#include "spirv/caustic_mesh_cell_point_vert.h"
#include "spirv/caustic_mesh_cell_quad_vert.h"

namespace dapple::methods::caustic_mesh {
namespace {

using layout::MeshCell;
using layout::MeshPush;
static_assert(sizeof(MeshCell) == 156);
static_assert(sizeof(MeshPush) == 120);

constexpr std::size_t kTile = 1 << 14;

void write_receivers(const view::ReceiverLayer& layer, std::span<glm::vec4> positions,
                     std::span<glm::vec4> normals) {
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t flags = layer.flags[i];
            positions[i] = normals[i] = glm::vec4(0);
            if (!is_lit_by_cells(flags)) continue;
            positions[i] = glm::vec4(layer.position[i], (flags & view::kInWater) != 0 ? 2.0f : 1.0f);
            normals[i] = glm::vec4(layer.shading_normal[i], 0);
        }
    });
}

void read_result(const view::ReceiverLayer& layer, std::span<const glm::vec4> texels, LayerResult& result) {
    result.irradiance.assign(layer.pixels(), glm::vec3(0));
    result.covered.resize(layer.pixels());
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            result.covered[i] = is_lit_by_cells(layer.flags[i]) ? 1 : 0;
            if (result.covered[i] != 0 && !texels.empty()) result.irradiance[i] = glm::vec3(texels[i]);
        }
    });
}

/// What one layer needs on the device while it is drawn.
struct LayerImages {
    LayerImages(gpu::Device& device, int width, int height)
        : positions_in(device, "positions", bytes(width, height)),
          normals_in(device, "normals", bytes(width, height)),
          positions(device, "positions", width, height, gpu::Format::rgba32f),
          normals(device, "normals", width, height, gpu::Format::rgba32f),
          irradiance(device, "irradiance", width, height, gpu::Format::rgba32f) {}
    static std::size_t bytes(int width, int height) {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * sizeof(glm::vec4);
    }
    gpu::Buffer positions_in, normals_in;  // irradiance comes out in the first
    gpu::Image positions, normals, irradiance;
};

/// See device_cell_renderer().
class DeviceCellRenderer final : public CellRenderer {
public:
    DeviceCellRenderer(gpu::Device& device, std::uint64_t largest)
        : device_(device),
          points_1_(device, "mesh cells", caustic_mesh_cell_point_vert, caustic_mesh_cell_1_frag,
                    additive<MeshPush>(gpu::Topology::points, 1, 2)),
          points_4_(device, "mesh cells of four layers", caustic_mesh_cell_point_vert,
                    caustic_mesh_cell_4_frag, additive<MeshPush>(gpu::Topology::points, 4, 2)),
          quads_1_(device, "large mesh cells", caustic_mesh_cell_quad_vert, caustic_mesh_cell_1_frag,
                   additive<MeshPush>(gpu::Topology::triangles, 1, 2)),
          quads_4_(device, "large mesh cells of four layers", caustic_mesh_cell_quad_vert,
                   caustic_mesh_cell_4_frag, additive<MeshPush>(gpu::Topology::triangles, 4, 2)),
          cells_(device, "mesh cells", largest) {}

    void clear() override { cells_.clear(); }
    void add(const Cells& cells) override { cells_.add(cells.points, cells.quads); }
    std::size_t points() const override { return cells_.points(); }
    std::size_t quads() const override { return cells_.quads(); }
    void render(const scene::FrameScene& scene, bool at_point, std::span<const view::ReceiverLayer> layers,
                std::span<LayerResult> results, FrameStats& stats) override;

private:
    void draw(gpu::PassList& passes, const MeshPush& push, std::vector<LayerImages>& images) {
        const bool four = images.size() == 4;
        gpu::Targets targets;
        std::vector<const gpu::Image*> receivers;
        for (LayerImages& layer : images) {
            passes.copy("mesh raster", layer.positions_in, layer.positions);
            passes.copy("mesh raster", layer.normals_in, layer.normals);
            targets.colors.push_back(&layer.irradiance);
            receivers.push_back(&layer.positions);
            receivers.push_back(&layer.normals);
        }
        cells_.draw(passes, "mesh raster", four ? points_4_ : points_1_, four ? quads_4_ : quads_1_,
                    receivers, push, std::move(targets));
        for (LayerImages& layer : images) passes.copy("mesh raster", layer.irradiance, layer.positions_in);
    }

    gpu::Device& device_;
    gpu::RasterPipeline points_1_, points_4_, quads_1_, quads_4_;
    DevicePrimitives<MeshCell> cells_;
};

void DeviceCellRenderer::render(const scene::FrameScene& scene, bool at_point,
                                std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                                FrameStats& stats) {
    const bool nothing = points() + quads() == 0;
    for (std::size_t next = 0; next < layers.size();) {
        const std::size_t batch = layers.size() - next >= 4 && !nothing ? 4 : 1;
        const std::span<const view::ReceiverLayer> part = layers.subspan(next, batch);
        const std::span<LayerResult> out = results.subspan(next, batch);
        next += batch;
        if (nothing) {
            read_result(part[0], {}, out[0]);
            continue;
        }
        MeshPush push = mesh_push(scene);
        std::vector<LayerImages> images;
        images.reserve(batch);
        {
            const ScopedPass pass(stats, "mesh raster");
            const std::array<glm::vec4*, 4> filters{&push.filter_0, &push.filter_1, &push.filter_2,
                                                    &push.filter_3};
            for (std::size_t i = 0; i < batch; ++i) {
                const view::ReceiverLayer& layer = part[i];
                *filters[i] = filter_of(layer.sample, scene.state.clip.samples, at_point);
                images.emplace_back(device_, layer.width, layer.height);
                write_receivers(layer, images.back().positions_in.as<glm::vec4>(),
                                images.back().normals_in.as<glm::vec4>());
            }
        }
        gpu::PassList passes(device_);
        draw(passes, push, images);
        passes.run(stats);
        const ScopedPass pass(stats, "mesh raster");
        for (std::size_t i = 0; i < batch; ++i)
            read_result(part[i], images[i].positions_in.as<const glm::vec4>(), out[i]);
    }
}

}  // namespace

std::unique_ptr<CellRenderer> device_cell_renderer(gpu::Device& device, std::uint64_t largest_buffer) {
    return std::make_unique<DeviceCellRenderer>(device, largest_buffer);
}

}  // namespace dapple::methods::caustic_mesh
