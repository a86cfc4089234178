#include "methods/adaptive_beams/make_beams.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "light/beam_axes.h"
#include "methods/adaptive_beams/beam_pieces.h"
#include "methods/adaptive_beams/beam_sets.h"
#include "methods/adaptive_beams/refinement.h"

namespace dapple::methods::adaptive_beams {
namespace {

/// Chains of one light at one body: one refinement serves both events.
struct ChainPair {
    int light = 0;
    int body = light::kWater;
    unsigned events = 0;  // bit light::Event
};

std::vector<ChainPair> pairs_of(const std::vector<light::Chain>& chains) {
    std::vector<ChainPair> pairs;
    for (const light::Chain& chain : chains) {
        auto found = std::find_if(pairs.begin(), pairs.end(), [&](const ChainPair& pair) {
            return pair.light == chain.light && pair.body == chain.object;
        });
        if (found == pairs.end()) found = pairs.insert(pairs.end(), {chain.light, chain.object, 0});
        found->events |= 1u << static_cast<unsigned>(chain.event);
    }
    return pairs;
}

/// Channels that are traced together.
struct Band {
    const char* name;
    glm::dvec3 mask;
    double index_shift;  // of the water
    unsigned events;     // bit light::Event
};

/// As light::water_beams has them: what the water mirrors first is of one kind for all channels; all else
/// goes through the water, or may.
std::vector<Band> bands_of(const scene::FrameState& state, const ChainPair& pair) {
    const double dispersion = state.water ? state.water->dispersion : 0;
    constexpr unsigned kReflection = 1u << static_cast<unsigned>(light::Event::reflection);
    const unsigned together =
        dispersion == 0 ? pair.events : (pair.body == light::kWater ? pair.events & kReflection : 0);
    const unsigned parted = pair.events & ~together;
    std::vector<Band> bands;
    if (together != 0) bands.push_back({"", {1, 1, 1}, 0, together});
    if (parted != 0) {
        bands.push_back({" red", {1, 0, 0}, -0.5 * dispersion, parted});
        bands.push_back({" green", {0, 1, 0}, 0, parted});
        bands.push_back({" blue", {0, 0, 1}, 0.5 * dispersion, parted});
    }
    return bands;
}

/// "sun > ball:TT > water:T"; where the lamp is in the ball, "lamp > ball:T" and "lamp > ball:RT".
std::string name_of(const scene::FrameState& state, light::Chain chain, bool from_inside,
                    const LegBeams& legs) {
    std::string name = chain_name(state, chain);
    if (chain.object != light::kWater && (chain.event == light::Event::reflection) == from_inside)
        name += 'T';
    for (const int surface : legs.surfaces) {
        // Named as at the beginning of a chain, less the light.
        const light::Chain later{chain.light, light::Event::transmission,
                                 surface == kEndsAtWater ? light::kWater : surface};
        const std::string full = chain_name(state, later);
        name += full.substr(full.rfind(" > "));
        if (surface != kEndsAtWater) name += 'T';
    }
    return name;
}

class Maker {
public:
    explicit Maker(FrameContext& context)
        : context_(context),
          oracle_(context.device),
          media_(context.scene),
          views_(context.scene),
          settings_(context.scene.state.caustics.adaptive_beams) {}

    std::vector<BeamSet> make() {
        const scene::FrameState& state = context_.scene.state;
        for (const ChainPair& pair : pairs_of(context_.chains)) {
            const scene::Light& light = state.lights[static_cast<std::size_t>(pair.light)];
            std::vector<glm::dvec3> directions = {light.direction};
            if (light.type == scene::LightType::sun)
                directions = light::sun_directions(light, settings_.sun_samples);
            const double share = 1 / static_cast<double>(directions.size());
            for (std::size_t i = 0; i < directions.size(); ++i)
                for (const LightView& view : views_.of(pair.light, directions[i], share, pair.body))
                    for (const Band& band : bands_of(state, pair))
                        take_view(pair, view.in_channels(band.mask), band,
                                  (directions.size() > 1 ? ' ' + std::to_string(i + 1) : "") + band.name);
        }
        count();
        return std::move(sets_);
    }

private:
    void take_view(const ChainPair& pair, const LightView& view, const Band& band, const std::string& part) {
        const PathTracer tracer(context_.scene, context_.rays, media_, view, pair.body, band.events,
                                band.index_shift);
        RefinedGrid refined = refine(context_.scene, tracer, pair.body, settings_.grid, settings_.levels,
                                     &oracle_, context_.stats);
        const ScopedPass pass(context_.stats, "beams");
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (const ProjectedGrid::Triangle& t : refined.grid.triangles()) triangles.push_back(t.vertices);
        for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
            if ((band.events >> static_cast<unsigned>(event) & 1) == 0) continue;
            // Rays of cuts need follow that event only.
            const PathTracer one(context_.scene, context_.rays, media_, view, pair.body,
                                 1u << static_cast<unsigned>(event), band.index_shift);
            const BeamHarvest harvest = cut_into_beams(one, view, event, triangles, settings_.paper_faithful,
                                                       refined.rays, refined.entry);
            for (std::size_t i = 0; i < kCauses; ++i) losses_[i] += harvest.losses[i];
            incident_ += harvest.incident;
            for (const LegBeams& legs : harvest.legs)
                append_sets(legs, event, refined.rays, pair.light,
                            name_of(context_.scene.state, {pair.light, event, pair.body},
                                    tracer.lamp_inside() >= 0, legs) +
                                part,
                            sets_, losses_);
        }
    }

    void count() {
        const auto mean = [](const glm::dvec3& v) { return (v.x + v.y + v.z) / 3; };
        for (std::size_t i = 0; i < kCauses; ++i)
            if (mean(losses_[i]) > 0)
                context_.stats.count(loss_name(static_cast<Cause>(i)), mean(losses_[i]));
        double beams = 0;
        for (const BeamSet& set : sets_) beams += static_cast<double>(set.triangles.size());
        context_.stats.count("beams", beams);
        context_.stats.count("light on specular surfaces, W", mean(incident_));
    }

    FrameContext& context_;
    OraclePass oracle_;
    media::Media media_;
    LightViews views_;
    const scene::AdaptiveBeamsParameters& settings_;
    std::vector<BeamSet> sets_;
    Losses losses_{};
    glm::dvec3 incident_{0};
};

}  // namespace

std::vector<BeamSet> make_beams(FrameContext& context) {
    return Maker(context).make();
}

}  // namespace dapple::methods::adaptive_beams
