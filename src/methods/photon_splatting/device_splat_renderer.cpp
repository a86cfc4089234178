#include "methods/photon_splatting/splat_renderer.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "base/lanes.h"
#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "layout/splat.h"
#include "methods/photon_splatting/receiver_code.h"
#include "methods/photon_splatting/sample_place.h"
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
constexpr std::uint32_t kVerticesPerQuad = 6;

gpu::RasterDescription additive(gpu::Topology topology, std::uint32_t layers) {
    gpu::RasterDescription description;
    description.interface = {.storage_buffers = 1, .sampled_images = layers, .push_bytes = sizeof(SplatPush)};
    description.topology = topology;
    description.blend = gpu::Blend::add;
    description.color_formats.assign(layers, gpu::Format::rgba32f);
    return description;
}

/// Whether the method answers for this receiver: the camera sees it directly.
bool is_covered(std::uint32_t flags) {
    return (flags & view::kReceiver) != 0 && (flags & view::kBehindSpecular) == 0;
}

void write_receivers(const view::ReceiverLayer& layer, const SamplePlace& place,
                     std::span<glm::vec4> texels) {
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t flags = layer.flags[i];
            const std::uint32_t code =
                is_covered(flags) ? receiver_code(layer.shading_normal[i], (flags & view::kInWater) != 0) : 0;
            texels[i] = code == 0 ? glm::vec4(0) : glm::vec4(place.of(layer, i), std::bit_cast<float>(code));
        }
    });
}

void read_result(const view::ReceiverLayer& layer, std::span<const glm::vec4> texels, LayerResult& result) {
    result.irradiance.resize(layer.pixels());
    result.covered.resize(layer.pixels());
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            result.covered[i] = is_covered(layer.flags[i]) ? 1 : 0;
            result.irradiance[i] = result.covered[i] != 0 ? glm::vec3(texels[i]) : glm::vec3(0);
        }
    });
}

SplatPush splat_push(const scene::FrameScene& scene) {
    const scene::Camera& camera = scene.state.camera;
    const bool perspective = camera.projection == scene::Projection::perspective;
    SplatPush push;
    push.picture = glm::vec2(scene.state.clip.width, scene.state.clip.height);
    push.camera = glm::vec3(perspective ? camera.position - scene.origin
                                        : glm::normalize(camera.position - camera.target));
    push.perspective = perspective ? 1 : 0;
    return push;
}

/// What draws one or four layers at once.
struct Pipelines {
    using Spirv = std::span<const std::uint32_t>;
    Pipelines(gpu::Device& device, Spirv one, Spirv four)
        : points_1(device, "splats", photon_splatting_splat_point_vert, one,
                   additive(gpu::Topology::points, 1)),
          points_4(device, "splats of four layers", photon_splatting_splat_point_vert, four,
                   additive(gpu::Topology::points, 4)),
          quads_1(device, "large splats", photon_splatting_splat_quad_vert, one,
                  additive(gpu::Topology::triangles, 1)),
          quads_4(device, "large splats of four layers", photon_splatting_splat_quad_vert, four,
                  additive(gpu::Topology::triangles, 4)) {}
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

/// Copies to where nobody will look soon, past the caches: these need not fetch first what is written over.
void stream(std::span<const Splat> from, Splat* to) {
    const auto* source = reinterpret_cast<const float*>(from.data());
    auto* target = reinterpret_cast<float*>(to);
    if (reinterpret_cast<std::uintptr_t>(to) % sizeof(__m256) != 0) {
        std::copy(from.begin(), from.end(), to);
        return;
    }
    for (std::size_t i = 0; i < from.size_bytes() / sizeof(float); i += lanes::kLanes<float>)
        _mm256_stream_ps(target + i, _mm256_loadu_ps(source + i));
    _mm_sfence();
}

/// Splats on the device, in buffers that a storage binding takes.
class SplatList {
public:
    SplatList(gpu::Device& device, std::size_t largest_buffer)
        : device_(device), most_(std::max<std::size_t>(1, largest_buffer / sizeof(Splat))) {}

    /// Keeps the buffers that were used, since memory that is there already costs nothing to write to.
    void clear() {
        std::erase_if(chunks_, [](const Chunk& chunk) { return chunk.count == 0; });
        for (Chunk& chunk : chunks_) chunk.count = 0;
        size_ = 0;
    }
    std::size_t size() const { return size_; }

    /// Appends the bands one after another.
    void add(const std::vector<LargeVector<Splat>>& bands) {
        struct Piece {
            std::span<const Splat> from;
            Splat* to;
        };
        std::vector<Piece> pieces;
        std::size_t left = 0;  // of these bands
        for (const LargeVector<Splat>& band : bands) left += band.size();
        for (const LargeVector<Splat>& band : bands) {
            std::span<const Splat> rest = band;
            while (!rest.empty()) {
                Chunk& chunk = with_room(left);
                const std::size_t count = std::min(rest.size(), chunk.room() - chunk.count);
                pieces.push_back({rest.first(count), chunk.buffer.as<Splat>().data() + chunk.count});
                chunk.count += count;
                size_ += count;
                left -= count;
                rest = rest.subspan(count);
            }
        }
        parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) stream(pieces[i].from, pieces[i].to);
        });
    }

    /// `draw(buffer, count)` for each.
    template <class DrawBuffer>
    void each(DrawBuffer&& draw) const {
        for (const Chunk& chunk : chunks_)
            if (chunk.count > 0) draw(chunk.buffer, static_cast<std::uint32_t>(chunk.count));
    }

private:
    struct Chunk {
        gpu::Buffer buffer;
        std::size_t count;
        std::size_t room() const { return buffer.bytes() / sizeof(Splat); }
    };

    /// The first buffer that is not full, or a new one: a draw each, so they grow to the largest that there
    /// is.
    Chunk& with_room(std::size_t wanted) {
        for (Chunk& chunk : chunks_)
            if (chunk.count < chunk.room()) return chunk;
        const std::size_t room = std::min(most_, std::max(wanted, size_));
        return chunks_.emplace_back(
            Chunk{gpu::Buffer(device_, "splats", room * sizeof(Splat), gpu::BufferMemory::device), 0});
    }

    gpu::Device& device_;
    std::size_t most_;  // splats in a buffer
    std::size_t size_ = 0;
    std::vector<Chunk> chunks_;
};

}  // namespace

struct SplatRenderer::State {
    State(gpu::Device& d, std::size_t largest_buffer)
        : device(d), points(d, largest_buffer), quads(d, largest_buffer) {}

    /// Made when first asked for: a run has one style.
    const Pipelines& pipelines(const SplatStyle& style) {
        if (style.paper_receivers) {
            if (!paper) paper.emplace(device, photon_splatting_paper_1_frag, photon_splatting_paper_4_frag);
            return *paper;
        }
        if (style.kernel.shape == KernelShape::box) {
            if (!boxes) boxes.emplace(device, photon_splatting_box_1_frag, photon_splatting_box_4_frag);
            return *boxes;
        }
        if (!tents) tents.emplace(device, photon_splatting_tent_1_frag, photon_splatting_tent_4_frag);
        return *tents;
    }

    void draw(gpu::PassList& passes, const SplatStyle& style, const SplatPush& push,
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
        const auto add = [&](const gpu::RasterPipeline& pipeline, const gpu::Buffer& buffer,
                             std::uint32_t vertices) {
            gpu::Bindings bindings{.buffers = {&buffer}, .images = receivers, .writes = {}, .push = {}};
            bindings.set_push(push);
            passes.draw("splatting", pipeline, std::move(bindings), targets, {.vertices = vertices});
            targets.clear = false;
        };
        points.each([&](const gpu::Buffer& buffer, std::uint32_t count) {
            add(four ? with.points_4 : with.points_1, buffer, count);
        });
        quads.each([&](const gpu::Buffer& buffer, std::uint32_t count) {
            add(four ? with.quads_4 : with.quads_1, buffer, kVerticesPerQuad * count);
        });
        for (LayerImages& layer : images) passes.copy("splatting", layer.irradiance, layer.staging);
    }

    gpu::Device& device;
    std::optional<Pipelines> tents, boxes, paper;
    SplatList points, quads;
};

SplatRenderer::SplatRenderer(gpu::Device& device)
    : SplatRenderer(device, static_cast<std::size_t>(device.largest_storage_range())) {}
SplatRenderer::SplatRenderer(gpu::Device& device, std::size_t largest_buffer)
    : state_(std::make_unique<State>(device, largest_buffer)) {}
SplatRenderer::~SplatRenderer() = default;

void SplatRenderer::clear() {
    state_->points.clear();
    state_->quads.clear();
}

void SplatRenderer::add(const Splats& splats) {
    state_->points.add(splats.points);
    state_->quads.add(splats.quads);
}

std::size_t SplatRenderer::points() const {
    return state_->points.size();
}
std::size_t SplatRenderer::quads() const {
    return state_->quads.size();
}

void SplatRenderer::render(const scene::FrameScene& scene, const SplatStyle& style,
                           std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                           FrameStats& stats) {
    const SplatPush push = splat_push(scene);
    const bool nothing = state_->points.size() + state_->quads.size() == 0;
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
                images.emplace_back(state_->device, layer.width, layer.height);
                const SamplePlace place(layer.sample, scene.state.clip.samples, style.kernel.widened);
                write_receivers(layer, place, images.back().staging.as<glm::vec4>());
            }
        }
        gpu::PassList passes(state_->device);
        state_->draw(passes, style, push, images);
        passes.run(stats);
        const ScopedPass pass(stats, "splatting");
        for (std::size_t i = 0; i < batch; ++i)
            read_result(part[i], images[i].staging.as<glm::vec4>(), out[i]);
    }
}

}  // namespace dapple::methods
