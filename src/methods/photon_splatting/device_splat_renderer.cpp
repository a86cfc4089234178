#include <algorithm>
#include <bit>
#include <optional>

#include "base/parallel.h"
#include "layout/splat.h"
#include "methods/device_raster.h"
#include "methods/photon_splatting/receiver_code.h"
#include "methods/photon_splatting/sample_place.h"
#include "methods/photon_splatting/splat_renderer.h"
#include "spirv/photon_splatting_box_1_frag.h"
#include "spirv/photon_splatting_box_4_frag.h"
#include "spirv/photon_splatting_paper_1_frag.h"
#include "spirv/photon_splatting_paper_4_frag.h"
#include "spirv/photon_splatting_splat_point_vert.h"
#include "spirv/photon_splatting_splat_quad_vert.h"
#include "spirv/photon_splatting_tent_1_frag.h"
#include "spirv/photon_splatting_tent_4_frag.h"

namespace dapple::methods {
namespace {

using layout::Splat;
using layout::SplatPush;
static_assert(sizeof(Splat) == 96);
static_assert(sizeof(SplatPush) == 24);

constexpr std::size_t kTile = 1 << 14;

void write_receivers(const view::ReceiverLayer& layer, const SamplePlace& place,
                     std::span<glm::vec4> texels) {
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t flags = layer.flags[i];
            const std::uint32_t code =
                is_splatted(flags) ? receiver_code(layer.shading_normal[i], (flags & view::kInWater) != 0)
                                   : 0;
            texels[i] = code == 0 ? glm::vec4(0) : glm::vec4(place.of(layer, i), std::bit_cast<float>(code));
        }
    });
}

void read_result(const view::ReceiverLayer& layer, std::span<const glm::vec4> texels, LayerResult& result) {
    result.irradiance.resize(layer.pixels());
    result.covered.resize(layer.pixels());
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            result.covered[i] = is_splatted(layer.flags[i]) ? 1 : 0;
            result.irradiance[i] = result.covered[i] != 0 ? glm::vec3(texels[i]) : glm::vec3(0);
        }
    });
}

/// What draws one or four layers at once.
struct Pipelines {
    using Spirv = std::span<const std::uint32_t>;
    Pipelines(gpu::Device& device, Spirv one, Spirv four)
        : points_1(device, "splats", photon_splatting_splat_point_vert, one,
                   additive<SplatPush>(gpu::Topology::points, 1, 1)),
          points_4(device, "splats of four layers", photon_splatting_splat_point_vert, four,
                   additive<SplatPush>(gpu::Topology::points, 4, 1)),
          quads_1(device, "large splats", photon_splatting_splat_quad_vert, one,
                  additive<SplatPush>(gpu::Topology::triangles, 1, 1)),
          quads_4(device, "large splats of four layers", photon_splatting_splat_quad_vert, four,
                  additive<SplatPush>(gpu::Topology::triangles, 4, 1)) {}
    gpu::RasterPipeline points_1, points_4, quads_1, quads_4;
};

/// What one layer needs on the device while it is drawn.
struct LayerImages {
    LayerImages(gpu::Device& device, int width, int height)
        : staging(device, "layer",
                  static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * sizeof(glm::vec4)),
          receivers(device, "receivers", width, height, gpu::Format::rgba32f),
          irradiance(device, "irradiance", width, height, gpu::Format::rgba32f) {}
    gpu::Buffer staging;  // receivers on the way in, irradiance on the way out
    gpu::Image receivers;
    gpu::Image irradiance;
};

/// See device_splat_renderer().
class DeviceSplatRenderer final : public SplatRenderer {
public:
    DeviceSplatRenderer(gpu::Device& device, std::size_t largest_buffer)
        : device_(device), splats_(device, "splats", largest_buffer) {}

    void clear() override { splats_.clear(); }
    void add(const Splats& splats) override { splats_.add(splats.points, splats.quads); }
    std::size_t points() const override { return splats_.points(); }
    std::size_t quads() const override { return splats_.quads(); }
    void render(const scene::FrameScene& scene, const SplatStyle& style,
                std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                FrameStats& stats) override;

private:
    const Pipelines& pipelines(const SplatStyle& style);
    void draw(gpu::PassList& passes, const SplatStyle& style, const SplatPush& push,
              std::vector<LayerImages>& images);

    gpu::Device& device_;
    std::optional<Pipelines> tents_, boxes_, paper_;
    DevicePrimitives<Splat> splats_;
};

/// Made when first asked for: a run has one style.
const Pipelines& DeviceSplatRenderer::pipelines(const SplatStyle& style) {
    if (style.paper_receivers) {
        if (!paper_) paper_.emplace(device_, photon_splatting_paper_1_frag, photon_splatting_paper_4_frag);
        return *paper_;
    }
    if (style.kernel.shape == KernelShape::box) {
        if (!boxes_) boxes_.emplace(device_, photon_splatting_box_1_frag, photon_splatting_box_4_frag);
        return *boxes_;
    }
    if (!tents_) tents_.emplace(device_, photon_splatting_tent_1_frag, photon_splatting_tent_4_frag);
    return *tents_;
}

void DeviceSplatRenderer::draw(gpu::PassList& passes, const SplatStyle& style, const SplatPush& push,
                               std::vector<LayerImages>& images) {
    const bool four = images.size() == 4;
    const Pipelines& with = pipelines(style);
    gpu::Targets targets;
    std::vector<const gpu::Image*> receivers;
    for (LayerImages& layer : images) {
        passes.copy("splatting", layer.staging, layer.receivers);
        targets.colors.push_back(&layer.irradiance);
        receivers.push_back(&layer.receivers);
    }
    splats_.draw(passes, "splatting", four ? with.points_4 : with.points_1,
                 four ? with.quads_4 : with.quads_1, receivers, push, std::move(targets));
    for (LayerImages& layer : images) passes.copy("splatting", layer.irradiance, layer.staging);
}

void DeviceSplatRenderer::render(const scene::FrameScene& scene, const SplatStyle& style,
                                 std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                                 FrameStats& stats) {
    const SplatPush push = splat_push(scene);
    const bool nothing = points() + quads() == 0;
    for (std::size_t next = 0; next < layers.size();) {
        const std::size_t batch = layers.size() - next >= 4 && !nothing ? 4 : 1;
        const std::span<const view::ReceiverLayer> part = layers.subspan(next, batch);
        const std::span<LayerResult> out = results.subspan(next, batch);
        next += batch;
        if (nothing) {
            read_result(part[0], std::vector<glm::vec4>(part[0].pixels(), glm::vec4(0)), out[0]);
            continue;
        }
        std::vector<LayerImages> images;
        images.reserve(batch);
        {
            const ScopedPass pass(stats, "splatting");
            for (const view::ReceiverLayer& layer : part) {
                images.emplace_back(device_, layer.width, layer.height);
                const SamplePlace place(layer.sample, scene.state.clip.samples, style.kernel.widened);
                write_receivers(layer, place, images.back().staging.as<glm::vec4>());
            }
        }
        gpu::PassList passes(device_);
        draw(passes, style, push, images);
        passes.run(stats);
        const ScopedPass pass(stats, "splatting");
        for (std::size_t i = 0; i < batch; ++i)
            read_result(part[i], images[i].staging.as<glm::vec4>(), out[i]);
    }
}

}  // namespace

std::unique_ptr<SplatRenderer> device_splat_renderer(gpu::Device& device, std::size_t largest_buffer) {
    return std::make_unique<DeviceSplatRenderer>(device, largest_buffer);
}
std::unique_ptr<SplatRenderer> device_splat_renderer(gpu::Device& device) {
    return device_splat_renderer(device, static_cast<std::size_t>(device.largest_storage_range()));
}

}  // namespace dapple::methods
