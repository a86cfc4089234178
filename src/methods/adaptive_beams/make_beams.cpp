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

/// "sun > ball:TT > water:T"
std::string name_of(const scene::FrameState& state, light::Chain chain, const LegBeams& legs) {
    std::string name = chain_name(state, chain);
    if (chain.object != light::kWater && chain.event == light::Event::transmission) name += 'T';
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
                for (const LightView& view :
                     light_views(context_.scene, pair.light, directions[i], share, pair.body))
                    take_view(pair, view, directions.size() > 1 ? ' ' + std::to_string(i + 1) : "");
        }
        count();
        return std::move(sets_);
    }

private:
    void take_view(const ChainPair& pair, const LightView& view, const std::string& part) {
        const PathTracer tracer(context_.scene, context_.rays, media_, view, pair.body, pair.events);
        RefinedGrid refined = refine(context_.scene, tracer, pair.body, settings_.grid, settings_.levels,
                                     &oracle_, context_.stats);
        const ScopedPass pass(context_.stats, "beams");
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (const ProjectedGrid::Triangle& t : refined.grid.triangles()) triangles.push_back(t.vertices);
        for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
            if ((pair.events >> static_cast<unsigned>(event) & 1) == 0) continue;
            // Rays of cuts need follow that event only.
            const PathTracer one(context_.scene, context_.rays, media_, view, pair.body,
                                 1u << static_cast<unsigned>(event));
            const BeamHarvest harvest =
                cut_into_beams(one, view, event, triangles, settings_.paper_faithful, refined.rays);
            for (std::size_t i = 0; i < kCauses; ++i) losses_[i] += harvest.losses[i];
            incident_ += harvest.incident;
            for (const LegBeams& legs : harvest.legs)
                append_sets(legs, event, refined.rays, pair.light,
                            name_of(context_.scene.state, {pair.light, event, pair.body}, legs) + part, sets_,
                            losses_);
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
