#include "judge/bench_scattered.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "judge/text.h"
#include "rays/ray_scene.h"
#include "render/frame_scene_builder.h"
#include "view/camera_paths.h"

namespace dapple::judge {
namespace {

/// What no method could keep. (Light "lost to wave shadow" falls on the wave that throws the shadow.)
constexpr std::array<std::string_view, 6> kNatural = {
    "lost to wave shadow, W",         "lost to media before the surface, W",
    "lost to absorption in glass, W", "lost to total reflection, W",
    "lost outside cones, W",          "lost beyond the scene, W"};
constexpr const char* kAllLight = "light on specular surfaces, W";

std::string change(double share) {
    return formatted("%+.2f %%", 100 * share);
}

/// The share of the light that the method loses by its own fault; 0 where the stats do not tell.
double lost_share(const std::map<std::string, double>& counts) {
    const auto all = counts.find(kAllLight);
    return all == counts.end() || all->second <= 0 ? 0 : lost_by_method(counts) / all->second;
}

}  // namespace

std::string to_string(Verdict verdict) {
    switch (verdict) {
        case Verdict::holds:
            return "holds";
        case Verdict::named:
            return "named";
        case Verdict::fails:
            break;
    }
    return "fails";
}

double lost_by_method(const std::map<std::string, double>& counts) {
    double lost = 0;
    for (const auto& [name, amount] : counts)
        if (name.starts_with("lost ") && std::ranges::find(kNatural, name) == kNatural.end()) lost += amount;
    return lost;
}

std::vector<bool> seen_straight(const scene::FrameState& state) {
    render::FrameSceneBuilder builder;
    const scene::FrameScene scene = builder.build(state);
    const rays::RayScene rays(scene);
    const scene::Clip& clip = state.clip;
    std::vector<bool> straight(static_cast<std::size_t>(clip.width) * static_cast<std::size_t>(clip.height),
                               true);
    for (int sample = 0; sample < clip.samples; ++sample) {
        for (int branch = 0; branch < view::kBranches; ++branch) {
            view::LayerCounts counts;
            view::SegmentLayer segments;
            view::trace_layer(scene, rays, {.sample = sample, .branch = branch}, counts, &segments);
            for (std::size_t pixel = 0; pixel < straight.size(); ++pixel)
                for (std::size_t i = segments.first[pixel]; i < segments.first[pixel + 1]; ++i)
                    if (segments.primary[i] == 0) straight[pixel] = false;
        }
    }
    // The reference's pixel is an area: beside a pixel that is not straight some of it may not be either.
    std::vector<bool> inside = straight;
    const auto index = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(clip.width) +
               static_cast<std::size_t>(x);
    };
    for (int y = 0; y < clip.height; ++y) {
        for (int x = 0; x < clip.width; ++x) {
            for (int k = 0; k < 9; ++k) {
                const int px = std::clamp(x + k % 3 - 1, 0, clip.width - 1);
                const int py = std::clamp(y + k / 3 - 1, 0, clip.height - 1);
                if (!straight[index(px, py)]) inside[index(x, y)] = false;
            }
        }
    }
    return inside;
}

ScatteredVerdict judge_scattered(const ErrorJudge& judge, const run::OutputPaths& run,
                                 const ScatteredEvidence& evidence) {
    const ClipErrors errors = judge.judge(run).errors;
    const double tolerance = kEnergyTolerance + 3 * evidence.reference_error;
    ScatteredVerdict verdict;
    verdict.energy = errors.energy;
    verdict.l1 = errors.l1;
    verdict.reason =
        "S " + change(errors.energy) + " of ±" + percent(tolerance) + " %, L1 " + percent(errors.l1) + " %";
    if (std::abs(errors.energy) <= tolerance) {
        verdict.verdict = Verdict::holds;
        return verdict;
    }
    const double lost = lost_share(evidence.counts);
    if (errors.energy < 0 && -errors.energy <= tolerance + lost) {
        verdict.verdict = Verdict::named;
        verdict.reason += "; lost by name: " + percent(lost) + " % of the light";
        return verdict;
    }
    if (!evidence.plan.empty()) {
        const ClipErrors there = judge.judge(run, evidence.answered).errors;
        // Pixels that see the same rays err together, there as everywhere.
        const double alone = judge.noise().rmse.value_or(0) / std::sqrt(judge.noise().pixels);
        const double together = alone > 0 ? std::max(1.0, evidence.reference_error / alone) : 1;
        const double allowed = kEnergyTolerance + 3 * together * there.bias_error;
        verdict.reason += ", where it answers (" + percent(there.compared) + " % of pixels) " +
                          change(there.bias) + " of ±" + percent(allowed) + " %";
        if (errors.energy < 0 && std::abs(there.bias) <= allowed) {
            verdict.verdict = Verdict::named;
            verdict.reason += "; the plan says: " + evidence.plan;
            return verdict;
        }
    }
    verdict.reason += ": nothing says why";
    return verdict;
}

}  // namespace dapple::judge
