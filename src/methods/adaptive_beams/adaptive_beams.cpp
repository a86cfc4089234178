#include "methods/adaptive_beams/adaptive_beams.h"

#include "methods/adaptive_beams/make_beams.h"

namespace dapple::methods {

struct AdaptiveBeams::State {
    std::vector<adaptive_beams::BeamSet> beams;
};

AdaptiveBeams::AdaptiveBeams() : state_(std::make_unique<State>()) {}
AdaptiveBeams::~AdaptiveBeams() = default;

Support AdaptiveBeams::supports_surface(const scene::FrameState&) const {
    return {Support::Degree::no, "nothing is drawn"};
}

Support AdaptiveBeams::supports_volume(const scene::FrameState&) const {
    return {Support::Degree::no, "nothing is drawn"};
}

std::size_t AdaptiveBeams::bytes(const scene::FrameState&, std::size_t) const {
    return 0;
}

void AdaptiveBeams::begin(FrameContext& context) {
    state_->beams = adaptive_beams::make_beams(context);
}

void AdaptiveBeams::irradiance(FrameContext&, std::span<const view::ReceiverLayer>, std::span<LayerResult>) {}

void AdaptiveBeams::in_scatter(FrameContext&, const view::SegmentLayer&, std::span<glm::vec3>) {}

}  // namespace dapple::methods
