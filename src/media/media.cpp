#include "media/media.h"

#include <cmath>
#include <numbers>

namespace dapple::media {

struct Media::State {
    std::vector<Component> components;
};

Media::Media(const scene::FrameScene& scene) : state_(std::make_unique<State>()) {
    Component water;
    if (scene.state.water) {
        water.extinction = scene.state.water->extinction();
        water.scattering = scene.state.water->scattering;
        water.phase = &scene.state.water->phase;
    }
    state_->components.push_back(water);
}
Media::~Media() = default;

const std::vector<Component>& Media::components() const {
    return state_->components;
}
bool Media::bounded(bool) const {
    return false;
}
bool Media::scatters(bool in_water) const {
    return in_water && state_->components[0].scattering != glm::dvec3(0);
}
bool Media::may_meet(const glm::dvec3&, const glm::dvec3&, double, bool) const {
    return false;
}
glm::dvec3 Media::optical_depth(const glm::dvec3&, const glm::dvec3&, double length, bool in_water) const {
    return in_water ? length * state_->components[0].extinction : glm::dvec3(0);
}
double Media::density(std::size_t component, const glm::dvec3&, bool in_water) const {
    return component == 0 && in_water ? 1 : 0;
}
DensityProfile Media::profile(const glm::dvec3&, const glm::dvec3&, double length, bool in_water) const {
    const float density = in_water ? 1 : 0;
    return {1, {0, length}, {density, density}, {0, density * length}, {density, density}};
}
double Media::phase(std::size_t, double) const {
    return 0.25 / std::numbers::pi;
}

}  // namespace dapple::media
