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

/// S of all segments, then what the pixels receive of them.
std::vector<glm::dvec3> values_of(const view::SegmentLayer& layer, std::vector<glm::dvec3> radiance) {
    const std::size_t segments = radiance.size();
    radiance.resize(segments + layer.first.size() - 1, glm::dvec3(0));
    for (std::size_t pixel = 0; pixel + 1 < layer.first.size(); ++pixel) {
        for (std::size_t i = layer.first[pixel]; i < layer.first[pixel + 1]; ++i)
            radiance[segments + pixel] += glm::dvec3(layer.throughput[i]) * radiance[i];
    }
    return radiance;
}

std::vector<DataLayer> variances(const RoundEstimate& estimate, std::size_t segments) {
    std::vector<DataLayer> data;
    const std::size_t pixels = estimate.mean.size() - segments;
    for (const char* name : {"S.variance.R", "S.variance.G", "S.variance.B"})
        data.push_back({name, std::vector<float>(pixels, 0)});
    for (std::size_t i = 0; i < pixels; ++i) {
        const glm::vec3 variance(estimate.variance(segments + i));
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
    const std::size_t segments = layer.segments();
    state.in_scatter_data.clear();
    RoundEstimate& estimate = state.progress[{reference::Quantity::in_scatter, layer.sample, layer.branch}];
    const std::size_t values = segments + layer.first.size() - 1;
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
                estimate.end_round(segments, result->rays / std::max<std::size_t>(1, state.tracer.sources()),
                                   reference::kInScatterExponent, wanted);
            state.save_at_times(context.checkpoint);
        }
        state.save(context.checkpoint);
    }
    if (segments == 0) return;
    count_most(context.stats, "reference volume standard error", estimate.relative_error(segments));
    for (std::size_t i = 0; i < segments; ++i) radiance[i] = glm::vec3(estimate.mean[i]);
    state.in_scatter_data = variances(estimate, segments);
}

std::vector<DataLayer> Reference::in_scatter_data() {
    return std::move(state_->in_scatter_data);
}

}  // namespace dapple::methods
