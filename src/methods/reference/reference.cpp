#include "methods/reference/reference.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "methods/reference/camera_segments.h"
#include "methods/reference/light_pass.h"
#include "methods/reference/reference_state.h"
#include "methods/reference/volume_pass.h"

namespace dapple::methods {

using reference::LayerCells;
using reference::LightPass;
using reference::RoundEstimate;

namespace {

/// What the bits of the estimates depend on beside the state itself, which the file's name stands for.
std::string job_text(const FrameContext& context, reference::ReferenceOptions options) {
    const scene::FrameState& state = context.scene.state;
    std::ostringstream text;
    text << std::hexfloat << state.frame << ' ' << state.clip.seed << ' ' << state.clip.width << ' '
         << state.clip.height << ' ' << state.clip.samples << ' ' << state.caustics.reference.standard_error
         << ' ' << state.caustics.reference.most_rays << ' ' << options.second_crossings << ' '
         << options.mirrors << ' ' << options.first_strata;
    for (const light::Chain& chain : context.chains)
        text << ' ' << chain.light << ' ' << static_cast<int>(chain.event) << ' ' << chain.object;
    return text.str();
}

LayerResult result_of(const RoundEstimate& estimate, const LayerCells& layer, bool with_data) {
    const std::size_t pixels = layer.paths.size();
    LayerResult result{std::vector<glm::vec3>(pixels, glm::vec3(0)), std::vector<std::uint8_t>(pixels, 0)};
    if (with_data) {
        for (const char* name : {"E.variance.R", "E.variance.G", "E.variance.B"})
            result.data.push_back({name, std::vector<float>(pixels, 0)});
    }
    for (std::size_t i = 0; i < pixels; ++i) {
        if (layer.paths[i] == 0) continue;
        result.covered[i] = 1;
        result.irradiance[i] = glm::vec3(estimate.mean[i]);
        if (!with_data) continue;
        const glm::vec3 variance(estimate.variance(i));
        for (int channel = 0; channel < 3; ++channel)
            result.data[static_cast<std::size_t>(channel)].values[i] = variance[channel];
    }
    return result;
}

}  // namespace

Reference::Reference(reference::ReferenceOptions options) : options_(options) {}
Reference::~Reference() = default;

Support Reference::supports_surface(const scene::FrameState&) const {
    return {Support::Degree::yes,
            "brute force: light traced to a standard error, any chain of water, glass and mirrors, any "
            "receiver"};
}

std::size_t Reference::bytes(const scene::FrameState& state, std::size_t pixels) const {
    constexpr double kPaths = double{reference::kPathsAcross} * reference::kPathsAcross;
    // While cells are made: the paths' ends, sorted in place. After that, of each of up to four layers at a
    // time: a pixel and up to four cells a path, and the estimate.
    const double layers = std::min(4, state.clip.samples);
    const double a_pixel = kPaths * (sizeof(reference::PathEnd) + layers * 4 * (1 + 4)) +
                           layers * (4 * sizeof(glm::dvec3) + sizeof(std::uint16_t)) +
                           2.0 * state.clip.samples * 2 * sizeof(glm::dvec3);
    constexpr double kDeposits = 64 * 2048 * 2 * 32;
    constexpr double kMost = 0x1p61;
    const double water = state.water ? reference::surface_bytes(*state.water) : 0;
    const bool scatters = (state.water && state.water->scattering != glm::dvec3(0)) || !state.media.empty();
    double volume = 0;
    if (scatters) {
        // The mean and its deviations of all layers, and two passes: of segments, and of pixels after them.
        constexpr double kSegments = reference::CameraSegments::kSegmentsAPixel;
        const double count = static_cast<double>(pixels);
        volume = reference::CameraSegments::bytes(pixels) +
                 std::max(double{reference::kWaitingBytes}, count * kSegments * sizeof(glm::dvec3)) +
                 count * (kSegments + 1) * sizeof(glm::dvec3) * (2 * 2.0 * state.clip.samples + 2);
    }
    return static_cast<std::size_t>(
        std::min(kMost, static_cast<double>(pixels) * a_pixel + layers * kDeposits + water + volume));
}

void Reference::begin(FrameContext& context) {
    const ScopedPass pass(context.stats, "reference set-up");
    state_ = std::make_unique<State>(context, options_);
    state_->job = job_text(context, options_);
    if (!context.checkpoint.file.empty())
        state_->progress = reference::read_progress(context.checkpoint.file, state_->job);
    state_->saved_at = wall_seconds();
}

void Reference::irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                           std::span<LayerResult> results) {
    State& state = *state_;
    std::vector<LayerCells> cells;
    std::vector<RoundEstimate*> estimates;
    {
        const ScopedPass pass(context.stats, "reference camera paths");
        for (const view::ReceiverLayer& layer : layers) {
            if (context.checkpoint.stop()) state.interrupt(context.checkpoint);
            cells.push_back(reference::layer_cells(context.scene, context.rays, state.charts, layer));
            RoundEstimate& estimate =
                state.progress[{reference::Quantity::irradiance, layer.sample, layer.branch}];
            if (estimate.mean.size() != layer.pixels()) {
                estimate = {};
                estimate.start(options_.first_strata, layer.pixels());
            }
            estimates.push_back(&estimate);
        }
    }
    const ScopedPass pass(context.stats, "reference light");
    std::vector<std::vector<glm::dvec3>> irradiance;
    bool traced = false;
    for (;; traced = true) {
        // The next pass that some layer wants, for all layers that want the same.
        std::optional<std::pair<std::uint64_t, std::uint64_t>> next;
        for (const RoundEstimate* estimate : estimates) {
            const std::pair wanted(estimate->strata, estimate->passes);
            if (!estimate->done && (!next || wanted < *next)) next = wanted;
        }
        if (!next) break;
        std::vector<std::size_t> served;
        std::vector<const LayerCells*> served_cells;
        for (std::size_t l = 0; l < layers.size(); ++l) {
            if (estimates[l]->done || std::pair(estimates[l]->strata, estimates[l]->passes) != *next)
                continue;
            served.push_back(l);
            served_cells.push_back(&cells[l]);
        }
        const LightPass light_pass{next->second, static_cast<std::size_t>(next->first)};
        const auto pass_result =
            reference::run_pass(state.tracer, light_pass, served_cells, context.checkpoint.stop, irradiance);
        if (!pass_result) state.interrupt(context.checkpoint);
        const std::size_t rays = pass_result->rays / std::max<std::size_t>(1, state.tracer.sources());
        context.stats.count("reference passes", 1);
        context.stats.count("reference rays", static_cast<double>(pass_result->rays));
        state.add_account(pass_result->account);
        for (std::size_t i = 0; i < served.size(); ++i) {
            RoundEstimate& estimate = *estimates[served[i]];
            estimate.add_pass(irradiance[i]);
            if (estimate.passes == reference::kPasses)
                estimate.end_round(0, rays, reference::kIrradianceExponent,
                                   context.scene.state.caustics.reference);
        }
        state.save_at_times(context.checkpoint);
    }
    if (traced) state.save(context.checkpoint);
    state.count_losses(context.stats);
    for (std::size_t l = 0; l < layers.size(); ++l) {
        count_most(context.stats, "reference standard error", estimates[l]->relative_error(0));
        results[l] = result_of(*estimates[l], cells[l], layers[l].sample == 0 && layers[l].branch == 0);
    }
}

}  // namespace dapple::methods
