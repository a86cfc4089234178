#include <cmath>
#include <optional>

#include "methods/reference/camera_segments.h"
#include "methods/reference/reference_state.h"
#include "methods/reference/volume_pass.h"
#include "view/camera_paths.h"

namespace dapple::methods {

using reference::CameraSegments;
using reference::LightPass;
using reference::RoundEstimate;

namespace {

/// S of all segments, the sum over all pixels, whose errors go together where they see the same rays, and
/// what each pixel receives.
std::vector<glm::dvec3> values_of(const view::SegmentLayer& layer, std::vector<glm::dvec3> radiance) {
    const std::size_t sum = radiance.size(), first = sum + 1;
    radiance.resize(first + layer.first.size() - 1, glm::dvec3(0));
    for (std::size_t pixel = 0; pixel + 1 < layer.first.size(); ++pixel) {
        for (std::size_t i = layer.first[pixel]; i < layer.first[pixel + 1]; ++i)
            radiance[first + pixel] += glm::dvec3(layer.throughput[i]) * radiance[i];
        radiance[sum] += radiance[first + pixel];
    }
    return radiance;
}

/// Of the pixels, whose values begin at `first`.
std::vector<DataLayer> variances(const RoundEstimate& estimate, std::size_t first) {
    std::vector<DataLayer> data;
    const std::size_t pixels = estimate.mean.size() - first;
    for (const char* name : {"S.variance.R", "S.variance.G", "S.variance.B"})
        data.push_back({name, std::vector<float>(pixels, 0)});
    for (std::size_t i = 0; i < pixels; ++i) {
        const glm::vec3 variance(estimate.variance(first + i));
        for (int channel = 0; channel < 3; ++channel)
            data[static_cast<std::size_t>(channel)].values[i] = variance[channel];
    }
    return data;
}

}  // namespace

Support Reference::supports_volume(const scene::FrameState& state) const {
    if (state.camera.projection == scene::Projection::perspective) {
        return {Support::Degree::yes,
                "brute force: light traced to a standard error; unbiased where the camera looks straight "
                "into a medium, by fine beams of sub-pixel paths behind the water, glass and mirrors"};
    }
    return {Support::Degree::yes,
            "brute force: light traced to a standard error, by fine beams of sub-pixel paths"};
}

void Reference::in_scatter(FrameContext& context, const view::SegmentLayer& layer,
                           std::span<glm::vec3> radiance) {
    State& state = *state_;
    const std::size_t segments = layer.segments(), first_pixel = segments + 1;
    state.in_scatter_data.clear();
    RoundEstimate& estimate = state.progress[{reference::Quantity::in_scatter, layer.sample, layer.branch}];
    const std::size_t values = first_pixel + layer.first.size() - 1;
    if (estimate.mean.size() != values) {
        estimate = {};
        estimate.start(kFirstVolumeStrata, values);
    }
    if (!estimate.done && segments > 0) {
        std::optional<CameraSegments> camera;
        {
            const ScopedPass pass(context.stats, "reference camera segments");
            if (context.checkpoint.stop()) state.interrupt(context.checkpoint);
            camera.emplace(context.scene, context.rays, layer);
        }
        const ScopedPass pass(context.stats, "reference volume light");
        const reference::VolumeJob job{context.scene, context.rays, state.tracer, *camera,
                                       context.checkpoint.stop};
        const std::vector<reference::SourceWeights> weights = reference::source_weights(job);
        if (weights.size() < state.tracer.sources()) state.interrupt(context.checkpoint);
        std::vector<glm::dvec3> found;
        scene::ReferenceParameters wanted = context.scene.state.caustics.reference;
        wanted.standard_error *= std::sqrt(context.scene.state.clip.samples);
        const int layer_number = view::kBranches * layer.sample + layer.branch;
        const auto first_pass = reference::kPasses * static_cast<std::uint64_t>(layer_number);
        while (!estimate.done) {
            const LightPass light_pass{first_pass + estimate.passes,
                                       static_cast<std::size_t>(estimate.strata)};
            const auto result = reference::run_volume_pass(job, light_pass, weights, found);
            if (!result) state.interrupt(context.checkpoint);
            estimate.extinguished |= result->extinguished;
            context.stats.count("reference volume passes", 1);
            context.stats.count("reference volume rays", static_cast<double>(result->rays));
            estimate.add_pass(values_of(layer, std::move(found)));
            if (estimate.passes == reference::kPasses)
                estimate.end_round(first_pixel,
                                   result->rays / std::max<std::size_t>(1, state.tracer.sources()),
                                   reference::kInScatterExponent, wanted);
            state.save_at_times(context.checkpoint);
        }
        state.save(context.checkpoint);
    }
    if (segments == 0) return;
    count_most(context.stats, "reference volume standard error", estimate.relative_error(first_pixel));
    state.add_scattered(estimate.mean[segments], estimate.variance(segments));
    context.stats.count(
        "reference volume standard error of all light",
        state.scattered_error() - context.stats.counted("reference volume standard error of all light"));
    for (std::size_t i = 0; i < segments; ++i) radiance[i] = glm::vec3(estimate.mean[i]);
    state.in_scatter_data = variances(estimate, first_pixel);
}

std::vector<DataLayer> Reference::in_scatter_data() {
    return std::move(state_->in_scatter_data);
}

}  // namespace dapple::methods
