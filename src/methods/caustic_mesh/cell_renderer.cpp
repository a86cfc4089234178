#include "methods/caustic_mesh/cell_renderer.h"

#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "layout/mesh_cell.h"
#include "methods/caustic_mesh/picture_map.h"
#include "spirv/caustic_mesh_cell_1_frag.h"
#include "spirv/caustic_mesh_cell_4_frag.h"
#include "spirv/caustic_mesh_cell_point_vert.h"
#include "spirv/caustic_mesh_cell_quad_vert.h"
#include "view/camera.h"

namespace dapple::methods::caustic_mesh {
namespace {

using layout::MeshCell;
using layout::MeshPush;
static_assert(sizeof(MeshCell) == 156);
static_assert(sizeof(MeshPush) == 120);

constexpr std::size_t kTile = 1 << 14;
constexpr std::uint32_t kVerticesPerQuad = 6;
constexpr float kPoint = 1e-3f;  // pixels: width of a filter that is as good as none

gpu::RasterDescription additive(gpu::Topology topology, std::uint32_t layers) {
    gpu::RasterDescription description;
    description.interface = {
        .storage_buffers = 1, .sampled_images = 2 * layers, .push_bytes = sizeof(MeshPush)};
    description.topology = topology;
    description.blend = gpu::Blend::add;
    description.color_formats.assign(layers, gpu::Format::rgba32f);
    return description;
}

/// Whether the method answers for this receiver: the camera sees it directly, in the air or in the water.
bool is_covered(std::uint32_t flags) {
    return (flags & view::kReceiver) != 0 && (flags & (view::kBehindSpecular | view::kInGlass)) == 0;
}

void write_receivers(const view::ReceiverLayer& layer, std::span<glm::vec4> positions,
                     std::span<glm::vec4> normals) {
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t flags = layer.flags[i];
            positions[i] = normals[i] = glm::vec4(0);
            if (!is_covered(flags)) continue;
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
            result.covered[i] = is_covered(layer.flags[i]) ? 1 : 0;
            if (result.covered[i] != 0 && !texels.empty()) result.irradiance[i] = glm::vec3(texels[i]);
        }
    });
}

/// Middle of the filter from the sample's point, and its size, pixels.
glm::vec4 filter_of(int sample, int samples, bool at_point) {
    if (at_point) return {0, 0, kPoint, kPoint};
    const view::Camera::SampleCell cell = view::Camera::sample_cell(sample, samples);
    const glm::dvec2 middle = cell.corner + 0.5 * cell.size - view::Camera::sample_offset(sample, samples);
    return {glm::vec2(middle), glm::vec2(cell.size)};
}

std::size_t cells_in(const std::vector<gpu::Buffer>& buffers) {
    std::size_t total = 0;
    for (const gpu::Buffer& buffer : buffers) total += buffer.bytes() / sizeof(MeshCell);
    return total;
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

}  // namespace

struct CellRenderer::State {
    State(gpu::Device& d, std::uint64_t largest)
        : device(d),
          largest_buffer(std::min(largest, d.largest_storage_range())),
          points_1(d, "mesh cells", caustic_mesh_cell_point_vert, caustic_mesh_cell_1_frag,
                   additive(gpu::Topology::points, 1)),
          points_4(d, "mesh cells of four layers", caustic_mesh_cell_point_vert, caustic_mesh_cell_4_frag,
                   additive(gpu::Topology::points, 4)),
          quads_1(d, "large mesh cells", caustic_mesh_cell_quad_vert, caustic_mesh_cell_1_frag,
                  additive(gpu::Topology::triangles, 1)),
          quads_4(d, "large mesh cells of four layers", caustic_mesh_cell_quad_vert, caustic_mesh_cell_4_frag,
                  additive(gpu::Topology::triangles, 4)) {}

    /// Packs the bands one after another into buffers that fit a storage binding; a band may span several.
    void pack(const std::vector<std::vector<MeshCell>>& bands, std::vector<gpu::Buffer>& buffers) {
        const std::size_t most = largest_buffer / sizeof(MeshCell);
        std::vector<std::size_t> first{0};  // of each band among all
        for (const std::vector<MeshCell>& band : bands) first.push_back(first.back() + band.size());
        for (std::size_t start = 0; start < first.back(); start += most) {
            const std::size_t count = std::min(most, first.back() - start);
            gpu::Buffer buffer(device, "mesh cells", count * sizeof(MeshCell), gpu::BufferMemory::device);
            const std::span<MeshCell> cells = buffer.as<MeshCell>();
            parallel_for(bands.size(), 1, [&](std::size_t from, std::size_t to) {
                for (std::size_t b = from; b < to; ++b) {
                    const std::size_t begin = std::max(first[b], start),
                                      end = std::min(first[b + 1], start + count);
                    if (begin < end)
                        std::copy_n(bands[b].begin() + static_cast<std::ptrdiff_t>(begin - first[b]),
                                    end - begin, cells.begin() + static_cast<std::ptrdiff_t>(begin - start));
                }
            });
            buffers.push_back(std::move(buffer));
        }
    }

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
        const auto add = [&](const gpu::RasterPipeline& pipeline, gpu::Buffer& buffer,
                             std::uint32_t vertices) {
            gpu::Bindings bindings{.buffers = {&buffer}, .images = receivers, .writes = {}, .push = {}};
            bindings.set_push(push);
            const std::size_t cells = buffer.bytes() / sizeof(MeshCell);
            passes.draw("mesh raster", pipeline, std::move(bindings), targets,
                        {.vertices = vertices * static_cast<std::uint32_t>(cells)});
            targets.clear = false;
        };
        for (gpu::Buffer& buffer : points) add(four ? points_4 : points_1, buffer, 1);
        for (gpu::Buffer& buffer : quads) add(four ? quads_4 : quads_1, buffer, kVerticesPerQuad);
        for (LayerImages& layer : images) passes.copy("mesh raster", layer.irradiance, layer.positions_in);
    }

    gpu::Device& device;
    std::uint64_t largest_buffer;  // bytes
    gpu::RasterPipeline points_1, points_4, quads_1, quads_4;
    std::vector<gpu::Buffer> points, quads;
};

CellRenderer::CellRenderer(gpu::Device& device, std::uint64_t largest_buffer)
    : state_(std::make_unique<State>(device, largest_buffer)) {}
CellRenderer::~CellRenderer() = default;

void CellRenderer::clear() {
    state_->points.clear();
    state_->quads.clear();
}

void CellRenderer::add(const Cells& cells) {
    state_->pack(cells.points, state_->points);
    state_->pack(cells.quads, state_->quads);
}

std::size_t CellRenderer::points() const {
    return cells_in(state_->points);
}
std::size_t CellRenderer::buffers() const {
    return state_->points.size() + state_->quads.size();
}
std::size_t CellRenderer::quads() const {
    return cells_in(state_->quads);
}

void CellRenderer::render(const scene::FrameScene& scene, bool at_point,
                          std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                          FrameStats& stats) {
    const bool nothing = state_->points.empty() && state_->quads.empty();
    const PictureMap picture(scene);
    for (std::size_t next = 0; next < layers.size();) {
        const std::size_t batch = layers.size() - next >= 4 && !nothing ? 4 : 1;
        const std::span<const view::ReceiverLayer> part = layers.subspan(next, batch);
        const std::span<LayerResult> out = results.subspan(next, batch);
        next += batch;
        if (nothing) {
            read_result(part[0], {}, out[0]);
            continue;
        }
        MeshPush push;
        push.row_x = picture.rows()[0];
        push.row_y = picture.rows()[1];
        push.row_w = picture.rows()[2];
        push.picture = glm::vec2(part[0].width, part[0].height);
        std::vector<LayerImages> images;
        images.reserve(batch);
        {
            const ScopedPass pass(stats, "mesh raster");
            const std::array<glm::vec4*, 4> filters{&push.filter_0, &push.filter_1, &push.filter_2,
                                                    &push.filter_3};
            for (std::size_t i = 0; i < batch; ++i) {
                const view::ReceiverLayer& layer = part[i];
                *filters[i] = filter_of(layer.sample, scene.state.clip.samples, at_point);
                images.emplace_back(state_->device, layer.width, layer.height);
                write_receivers(layer, images.back().positions_in.as<glm::vec4>(),
                                images.back().normals_in.as<glm::vec4>());
            }
        }
        gpu::PassList passes(state_->device);
        state_->draw(passes, push, images);
        passes.run(stats);
        const ScopedPass pass(stats, "mesh raster");
        for (std::size_t i = 0; i < batch; ++i)
            read_result(part[i], images[i].positions_in.as<const glm::vec4>(), out[i]);
    }
}

}  // namespace dapple::methods::caustic_mesh
