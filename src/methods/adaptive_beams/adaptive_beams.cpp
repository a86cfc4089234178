#include "methods/adaptive_beams/adaptive_beams.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "methods/adaptive_beams/beam_renderer.h"
#include "methods/adaptive_beams/bounded_beams.h"
#include "methods/adaptive_beams/light_lattices.h"
#include "methods/adaptive_beams/make_beams.h"
#include "methods/adaptive_beams/refinement.h"

namespace dapple::methods {

using adaptive_beams::BeamRenderer;
using adaptive_beams::BeamSet;
using adaptive_beams::BeamSums;
using adaptive_beams::Shading;
using adaptive_beams::VolumeKind;

namespace {

/// Views of a lamp that is surrounded.
constexpr double kLampFaces = 6;

/// E of a layer that was drawn together with its S.
struct KeptIrradiance {
    int sample;
    int branch;
    std::vector<glm::vec3> irradiance;
};

bool any_primary(const view::ReceiverLayer& layer) {
    return std::any_of(layer.flags.begin(), layer.flags.end(), adaptive_beams::seen_directly);
}

}  // namespace

struct AdaptiveBeams::State {
    std::vector<BeamSet> beams;
    std::optional<BeamRenderer> renderer;  ///< once a device is known
    const view::ReceiverLayer* expected = nullptr;
    std::vector<KeptIrradiance> kept;
};

AdaptiveBeams::AdaptiveBeams() : state_(std::make_unique<State>()) {}
AdaptiveBeams::~AdaptiveBeams() = default;

Support AdaptiveBeams::supports_surface(const scene::FrameState& state) const {
    std::string reason = "E of receivers that the camera sees neither through nor by water, mirrors or glass";
    if (state.caustics.adaptive_beams.paper_faithful) reason += "; at the samples' points";
    return {Support::Degree::partly, std::move(reason)};
}

Support AdaptiveBeams::supports_volume(const scene::FrameState&) const {
    return {Support::Degree::partly,
            "where the camera looks through neither water's surface, mirrors nor glass"};
}

std::size_t AdaptiveBeams::bytes(const scene::FrameState& state, std::size_t pixels) const {
    // Seven pictures, five buffers of their size and the sums of a layer, of up to four layers kept. Beams at
    // worst: all cells of the grid split at every level, for each body, each part or face of a light and
    // both events, in three colours where the water parts them; on up to three legs where glass sends light
    // on. Of one view at a time there are its texels and its rays with their paths.
    constexpr double a_pixel = 12 * sizeof(glm::vec4) + 6 * sizeof(glm::vec3);
    constexpr double a_beam = 532, a_ray = 1200;
    // Bounded media: columns of the rows that are drawn at a time, and of the rays of all beams. Bricks are
    // in what grids take.
    const auto grids = static_cast<std::size_t>(
        std::count_if(state.media.begin(), state.media.end(),
                      [](const scene::Medium& m) { return m.type == scene::MediumType::grid; }));
    const double rows = state.media.empty() ? 0 : 0x1p27;
    const double a_column = static_cast<double>(grids > 0 ? adaptive_beams::least_column_bytes(grids) : 0);
    const double budget = static_cast<double>(grids > 0 ? adaptive_beams::kLightColumnBytes : 0);
    const scene::AdaptiveBeamsParameters& parameters = state.caustics.adaptive_beams;
    const double side = static_cast<double>(parameters.grid) * static_cast<double>(1 << parameters.levels);
    const double coarse = 2 * static_cast<double>(parameters.grid) * parameters.grid;
    const double triangles =
        std::min(2 * side * side, std::max(coarse, static_cast<double>(adaptive_beams::kMostTriangles)));
    double bodies = state.water ? 1 : 0, views = 0;
    for (const scene::Object& object : state.objects) bodies += object.material.glass ? 1 : 0;
    for (const scene::Light& light : state.lights)
        views += light.type == scene::LightType::sun ? parameters.sun_samples : kLampFaces;
    const double legs = scene::has_glass(state) ? 3 : 1;
    const double colors = state.water && state.water->dispersion != 0 ? 3 : 1;
    const double texels = 48 * std::min(4 * side * side, 2048.0 * 2048);
    const double beams = bodies * views * 2 * colors * legs * triangles;
    return static_cast<std::size_t>(std::min(0x1p61, a_pixel * static_cast<double>(pixels) + texels +
                                                         a_ray * 2 * triangles + beams * a_beam +
                                                         std::max(budget, beams * a_column) + rows));
}

void AdaptiveBeams::begin(FrameContext& context) {
    State& s = *state_;
    s.kept.clear();
    s.expected = nullptr;
    s.beams = adaptive_beams::make_beams(context);
    if (!s.renderer) s.renderer.emplace(context.device);
    s.renderer->begin(
        context.scene, s.beams, VolumeKind::six_triangles,
        context.scene.state.caustics.adaptive_beams.paper_faithful ? Shading::paper : Shading::exact,
        context.stats);
}

void AdaptiveBeams::expect(const view::ReceiverLayer& layer) {
    state_->expected = &layer;
}

void AdaptiveBeams::irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                               std::span<LayerResult> results) {
    State& s = *state_;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const view::ReceiverLayer& layer = layers[i];
        const auto kept = std::find_if(s.kept.begin(), s.kept.end(), [&](const KeptIrradiance& k) {
            return k.sample == layer.sample && k.branch == layer.branch;
        });
        std::vector<glm::vec3> values;
        if (kept != s.kept.end()) {
            values = std::move(kept->irradiance);
            s.kept.erase(kept);
        } else if (any_primary(layer)) {
            values = s.renderer->render(nullptr, &layer, context.stats).irradiance;
        } else {
            continue;
        }
        for (std::size_t pixel = 0; pixel < layer.pixels(); ++pixel) {
            if (!adaptive_beams::seen_directly(layer.flags[pixel])) continue;
            results[i].irradiance[pixel] = values[pixel];
            results[i].covered[pixel] = 1;
        }
    }
}

void AdaptiveBeams::in_scatter(FrameContext& context, const view::SegmentLayer& layer,
                               std::span<glm::vec3> radiance) {
    State& s = *state_;
    const view::ReceiverLayer* receivers = std::exchange(s.expected, nullptr);
    if (receivers && !any_primary(*receivers)) receivers = nullptr;
    if (std::none_of(layer.primary.begin(), layer.primary.end(), [](auto p) { return p != 0; })) return;
    BeamSums sums = s.renderer->render(&layer, receivers, context.stats);
    for (std::size_t pixel = 0; pixel + 1 < layer.first.size(); ++pixel) {
        for (std::uint32_t k = layer.first[pixel]; k < layer.first[pixel + 1]; ++k) {
            if (!layer.primary[k]) continue;
            radiance[k] = sums.scattered[pixel];
            break;
        }
    }
    if (receivers) s.kept.push_back({receivers->sample, receivers->branch, std::move(sums.irradiance)});
}

}  // namespace dapple::methods
