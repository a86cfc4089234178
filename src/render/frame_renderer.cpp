#include "render/frame_renderer.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>

#include "base/parallel.h"
#include "media/media.h"
#include "methods/registry.h"
#include "ocean/lamp_mesh.h"
#include "ocean/water_surface.h"
#include "rays/ray_scene.h"
#include "render/albedo.h"
#include "render/buffer_scale.h"
#include "render/film.h"
#include "render/frame_scene_builder.h"
#include "render/irradiance_pass.h"
#include "render/plan.h"
#include "render/segment_lattice.h"
#include "render/settle.h"
#include "render/shading.h"
#include "render/volumetric_light.h"
#include "scene/area_light.h"
#include "view/camera_paths.h"
#include "view/segment_recorder.h"

namespace dapple::render {
namespace {

/// Layers that are traced before the method sees them: a method may serve them at one go.
constexpr int kLargestBatch = 4;
constexpr std::size_t kBatchPixels = std::size_t{1} << 22;

constexpr std::size_t kSeenAtOnce = 4096;  ///< pixels

/// Memory of a receiver layer and its shading, a pixel.
constexpr std::size_t kLayerBytes = 6 * sizeof(glm::vec3) + 2 * sizeof(std::uint32_t) + sizeof(glm::vec2) +
                                    2 * sizeof(float) + 5 * sizeof(glm::vec3) + 1;

/// A segment, as it is recorded and as the layer keeps it, and what is found for it; segments a pixel where
/// the camera sees through the water's surface.
constexpr std::size_t kSegmentBytes =
    view::SegmentRecorder::bytes_a_piece() + 9 * sizeof(glm::vec3) + 2 * sizeof(float) + 2;
constexpr std::size_t kSegmentsAPixel = 2;

/// Of the water: positions and normals in double, and what is needed beside them while they are made; indices
/// and Embree's tree (141 MB for 2.1 M triangles, measured).
constexpr std::size_t kWaterVertexBytes = 2 * sizeof(glm::dvec3);
constexpr std::size_t kWaterMakingBytes = 8 * sizeof(double);
constexpr std::size_t kWaterTriangleBytes = sizeof(glm::uvec3) + 70;

std::size_t pixels(const scene::Clip& clip) {
    return static_cast<std::size_t>(clip.width) * static_cast<std::size_t>(clip.height);
}

int batch_size(const scene::Clip& clip) {
    const std::size_t fitting =
        std::max<std::size_t>(1, kBatchPixels / std::max<std::size_t>(1, pixels(clip)));
    return std::min({static_cast<int>(std::min<std::size_t>(fitting, kLargestBatch)), clip.samples});
}

bool any_direct_receiver(const view::ReceiverLayer& layer) {
    return std::any_of(layer.flags.begin(), layer.flags.end(), [](std::uint32_t flags) {
        return (flags & (view::kReceiver | view::kBehindSpecular)) == view::kReceiver;
    });
}

/// From the state alone, before grids are read.
bool may_scatter(const scene::FrameState& state) {
    return !state.media.empty() || (state.water && state.water->scattering != glm::dvec3(0));
}

/// A layer on its way to the film.
struct TracedLayer {
    view::ReceiverLayer receivers;
    view::ReceiverLayer buffer;  ///< receivers that E is found for; without pixels where that is for all
    /// What media scatter towards the pixels, W/m^2/sr; empty without a volume pass.
    std::vector<glm::vec3> volume_direct, volume_caustics;
    std::vector<methods::DataLayer> volume_data;
};

/// Of a layer and of its buffer: which other branches pixels have.
struct Splits {
    std::vector<std::uint8_t> receivers, buffer;
};

Splits take_splits(TracedLayer& layer) {
    return {std::move(layer.receivers.splits), std::move(layer.buffer.splits)};
}

/// What pixels receive of what their segments scatter.
std::vector<glm::vec3> seen(const view::SegmentLayer& layer, const std::vector<glm::vec3>& radiance) {
    std::vector<glm::vec3> pixels(layer.first.size() - 1, glm::vec3(0));
    parallel_for(pixels.size(), kSeenAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t pixel = begin; pixel < end; ++pixel) {
            for (std::uint32_t i = layer.first[pixel]; i < layer.first[pixel + 1]; ++i)
                pixels[pixel] += layer.throughput[i] * radiance[i];
        }
    });
    return pixels;
}

methods::LayerResult not_covered(std::size_t count) {
    return {std::vector<glm::vec3>(count, glm::vec3(0)), std::vector<std::uint8_t>(count, 0)};
}

/// What outlives a frame: caches and the methods with their pipelines.
struct Kept {
    gpu::Device& device;
    FrameSceneBuilder builder;
    std::map<std::string, std::unique_ptr<methods::CausticMethod>> methods;

    methods::CausticMethod& method(const std::string& name) {
        std::unique_ptr<methods::CausticMethod>& known = methods[name];
        if (!known) known = methods::make_method(name);
        return *known;
    }
};

/// The passes of one frame, in their order.
class FramePasses {
public:
    FramePasses(Kept& kept, const scene::FrameState& state, FrameStats& stats,
                const methods::Checkpoint& checkpoint)
        : kept_(kept),
          stats_(stats),
          method_(kept.method(state.caustics.method)),
          scene_(build_scene(state)),
          plan_(make_plan(scene_, method_)),
          media_(scene_),
          rays_(build_rays()),
          buffer_scene_(plan_.buffer_scale == 1 ? std::nullopt
                                                : std::optional(at_scale(scene_, plan_.buffer_scale))),
          context_{
              buffer_scene_ ? *buffer_scene_ : scene_, rays_, kept.device, stats, plan_.chains, checkpoint},
          irradiance_(method_, context_, scene_, plan_.buffer_scale),
          film_(state.clip.width, state.clip.height, state.clip.samples, state.sky, plan_.volume) {}

    RenderedFrame run() {
        if (!plan_.chains.empty()) method_.begin(context_);
        const int samples = scene_.state.clip.samples;
        const int batch = batch_size(scene_.state.clip);
        for (int first = 0; first < samples; first += batch) {
            render_batch(first, std::min(batch, samples - first));
        }
        RenderedFrame frame;
        const ScopedPass pass(stats_, "film");
        frame.linear = film_.finish(frame.non_finite);
        frame.plan = std::move(plan_.lines);
        return frame;
    }

private:
    scene::FrameScene build_scene(const scene::FrameState& state) {
        const ScopedPass pass(stats_, "scene");
        scene::FrameScene scene = kept_.builder.build(state);
        if (scene.water)
            stats_.count("water triangles", static_cast<double>(scene.water->mesh.triangles.size()));
        return scene;
    }

    rays::RayScene build_rays() {
        const ScopedPass pass(stats_, "ray scene");
        return rays::RayScene(scene_);
    }

    /// Samples [first, first + count): their first branches at one go, then the other branches of those that
    /// split.
    void render_batch(int first, int count) {
        std::vector<TracedLayer> layers;
        std::vector<Splits> splits;
        for (int i = 0; i < count; ++i) {
            layers.push_back(trace({first + i, 0}, {}));
            splits.push_back(take_splits(layers.back()));
        }
        render_layers(std::move(layers));
        for (int i = 0; i < count; ++i) {
            const Splits& refracted = splits[static_cast<std::size_t>(i)];
            render_branch(first + i, 2, refracted, view::kSplitsAgain);
            const Splits reflected = render_branch(first + i, 1, refracted, view::kSplits);
            render_branch(first + i, 3, reflected, view::kSplitsAgain);
        }
    }

    /// Of the pixels whose path splits so in another branch; the splits of this one.
    Splits render_branch(int sample, int branch, const Splits& splits, view::PathSplits split) {
        if (std::none_of(splits.receivers.begin(), splits.receivers.end(),
                         [&](std::uint8_t s) { return (s & split) != 0; }))
            return {};
        view::LayerRequest request{sample, branch};
        request.only = split;
        request.splits = splits.receivers;
        std::vector<TracedLayer> layers;
        layers.push_back(trace(request, splits.buffer));
        Splits found = take_splits(layers.front());
        render_layers(std::move(layers));
        return found;
    }

    /// `buffer_splits`: as the request's, of the buffer. The segments of the layer are gone when it returns:
    /// they take more room than its receivers.
    TracedLayer trace(const view::LayerRequest& request, std::span<const std::uint8_t> buffer_splits) {
        TracedLayer layer;
        view::LayerCounts counts;
        view::SegmentLayer segments;
        {
            const ScopedPass pass(stats_, "camera paths");
            layer.receivers =
                view::trace_layer(scene_, rays_, request, counts, plan_.volume ? &segments : nullptr);
        }
        stats_.count("camera paths", static_cast<double>(counts.paths));
        stats_.count("dropped splits", static_cast<double>(counts.dropped_splits));
        stats_.count("longest chain hits", static_cast<double>(counts.longest_chain_hits));
        if (buffer_scene_ && plan_.caustics) {
            const ScopedPass pass(stats_, "camera paths");
            view::LayerRequest of_buffer = request;
            of_buffer.splits = buffer_splits;
            view::LayerCounts buffer_counts;
            layer.buffer = view::trace_layer(*buffer_scene_, rays_, of_buffer, buffer_counts);
            stats_.count("camera paths", static_cast<double>(buffer_counts.paths));
        }
        if (!plan_.volume) return layer;
        stats_.count("camera segments", static_cast<double>(segments.segments()));
        if (plan_.caustics && plan_.volume_caustics) method_.expect(layer.receivers);
        const AskSegments ask = [&](const view::SegmentLayer& asked) { return scattered(asked); };
        const SegmentRadiance radiance =
            plan_.half_volume ? at_half_resolution(segments, ask) : ask(segments);
        layer.volume_direct = seen(segments, radiance.direct);
        layer.volume_caustics = seen(segments, radiance.caustics);
        // At half resolution the method has something to say of some pixels only.
        if (plan_.volume_caustics && !plan_.half_volume && request.sample == 0 && request.branch == 0)
            layer.volume_data = method_.in_scatter_data();
        return layer;
    }

    SegmentRadiance scattered(const view::SegmentLayer& segments) {
        stats_.count("camera segments asked for", static_cast<double>(segments.segments()));
        SegmentRadiance radiance;
        radiance.direct.assign(segments.segments(), glm::vec3(0));
        radiance.caustics = radiance.direct;
        if (plan_.volume_caustics) method_.in_scatter(context_, segments, radiance.caustics);
        if (plan_.volume_direct) {
            const ScopedPass pass(stats_, "volumetric direct light");
            add_volumetric_direct_light(scene_, media_, rays_, segments, radiance.direct);
        }
        return radiance;
    }

    void render_layers(std::vector<TracedLayer> traced) {
        std::vector<view::ReceiverLayer> layers, buffers;
        layers.reserve(traced.size());
        buffers.reserve(traced.size());
        for (TracedLayer& layer : traced) {
            layers.push_back(std::move(layer.receivers));
            buffers.push_back(std::move(layer.buffer));
        }
        std::vector<methods::LayerResult> results;
        results.reserve(layers.size());
        for (const view::ReceiverLayer& layer : layers) results.push_back(not_covered(layer.pixels()));
        const bool served = method_.serves_behind_specular() ||
                            std::any_of(layers.begin(), layers.end(), any_direct_receiver);
        if (plan_.caustics && served) irradiance_.run(layers, buffers, results);
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const ScopedPass pass(stats_, "shading");
            LayerShading shading;
            shading.caustics = std::move(results[i]);
            const std::vector<glm::vec3> dark(layers[i].pixels(), glm::vec3(0));
            shading.albedo = find_albedo(scene_, layers[i], kept_.builder.textures());
            shading.direct = plan_.direct_light ? direct_irradiance(scene_, media_, rays_, layers[i]) : dark;
            shading.sky = plan_.sky_light ? sky_irradiance(scene_, layers[i]) : dark;
            shading.flat_water =
                plan_.flat_water_stand_in
                    ? flat_water_irradiance(scene_, media_, rays_, layers[i], shading.caustics.covered)
                    : dark;
            shading.volume_direct = std::move(traced[i].volume_direct);
            shading.volume_caustics = std::move(traced[i].volume_caustics);
            shading.volume_data = std::move(traced[i].volume_data);
            film_.add(layers[i], std::move(shading), scene_.origin);
        }
    }

    Kept& kept_;
    FrameStats& stats_;
    methods::CausticMethod& method_;
    scene::FrameScene scene_;
    Plan plan_;
    media::Media media_;
    rays::RayScene rays_;
    std::optional<scene::FrameScene> buffer_scene_;  ///< that E is found in, where it is not scene_
    methods::FrameContext context_;
    IrradiancePass irradiance_;
    Film film_;
};

}  // namespace

struct FrameRenderer::State {
    Kept kept;
    std::optional<std::size_t> most_bytes;

    /// All of a frame but its grids.
    std::size_t other_bytes(const scene::FrameState& given);

    /// What the other parts of the frame leave is for grids.
    void share_memory(const scene::FrameState& state) {
        if (!most_bytes) return;
        const std::size_t others = other_bytes(state);
        kept.builder.limit_grids(*most_bytes > others ? *most_bytes - others : 0);
    }
};

FrameRenderer::FrameRenderer(gpu::Device& device) : state_(new State{{device, {}, {}}, {}}) {}
FrameRenderer::~FrameRenderer() = default;

std::vector<PlanLine> FrameRenderer::plan(const scene::FrameState& state) {
    state_->share_memory(state);
    return make_plan(state_->kept.builder.build(state), state_->kept.method(state.caustics.method)).lines;
}

RenderedFrame FrameRenderer::render(const scene::FrameState& state, FrameStats& stats,
                                    const methods::Checkpoint& checkpoint) {
    state_->share_memory(state);
    return FramePasses(state_->kept, state, stats, checkpoint).run();
}

SettledCaustics FrameRenderer::settle(const SettleRequest& request) {
    state_->share_memory(request.pilots.front());
    SettleRequest with_memory = request;
    with_memory.memory = [this](const scene::FrameState& state) { return bytes(state); };
    return render::settle(with_memory, state_->kept.builder,
                          state_->kept.method(request.pilots.front().caustics.method), state_->kept.device);
}

void FrameRenderer::limit_memory(std::size_t most_bytes) {
    state_->most_bytes = most_bytes;
}

std::size_t FrameRenderer::bytes(const scene::FrameState& state) const {
    return state_->other_bytes(state) + state_->kept.builder.grid_bytes(state);
}

std::size_t FrameRenderer::State::other_bytes(const scene::FrameState& given) {
    const scene::FrameState state = ocean::with_mesh_for_lamps(scene::with_emitter_parts(given));
    // In double: a picture of absurd size must not wrap around to a small number.
    const double count = static_cast<double>(state.clip.width) * static_cast<double>(state.clip.height);
    const bool volume = may_scatter(state);
    // Beside layers of the buffer there is one of the receivers that it does not serve.
    const double side = pixels_a_side(state.caustics.buffer_scale);
    const double buffer = side > 1 ? kLayerBytes * (1 + 1 / (side * side)) : 0;
    const double a_layer = static_cast<double>(kLayerBytes + (volume ? 2 * sizeof(glm::vec3) : 0)) + buffer;
    // Layers are gone when the film's sums become the picture.
    const double layers = static_cast<double>(batch_size(state.clip)) * a_layer +
                          static_cast<double>(volume ? kSegmentsAPixel * kSegmentBytes : 0);
    const double a_pixel = static_cast<double>(Film::sum_bytes_per_pixel(volume)) +
                           std::max(layers, static_cast<double>(Film::picture_bytes_per_pixel(volume)));
    constexpr double largest = 0x1p62;
    if (count * a_pixel > largest) return static_cast<std::size_t>(largest);
    const methods::CausticMethod& method = kept.method(state.caustics.method);
    const std::size_t rendering = static_cast<std::size_t>(count * a_pixel) +
                                  method.bytes(state, static_cast<std::size_t>(count)) +
                                  method.bytes_on(kept.device.info().type, state);
    if (!state.water || state.water->surface.type == scene::WaterSurfaceType::mesh_sequence) return rendering;
    const ocean::MeshCounts mesh = ocean::mesh_counts(*state.water);
    return mesh.vertices * kWaterVertexBytes + mesh.triangles * kWaterTriangleBytes +
           std::max(rendering, mesh.vertices * kWaterMakingBytes + mesh.spectrum_bytes);
}

}  // namespace dapple::render
