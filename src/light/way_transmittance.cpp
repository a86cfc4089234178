#include "light/way_transmittance.h"

#include <limits>

namespace dapple::light {

WayTransmittance::WayTransmittance(const scene::FrameScene& scene, const media::Media& media,
                                   const BeamMesh& mesh)
    : media_(media),
      extinction_(scene.state.water->extinction()),
      from_below_(mesh.from_below),
      in_water_(mesh.in_water()),
      onward_only_(mesh.mirrored()),
      bounded_(media.bounded(mesh.from_below) || media.bounded(mesh.in_water())) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
    sun_ = light.type == scene::LightType::sun;
    sun_direction_ = light.direction;
    light_position_ = glm::vec3(light.position - scene.origin);
}

glm::vec3 WayTransmittance::of(glm::vec3 surface, glm::vec3 point, float way) const {
    if (!bounded_) {
        float in_water = in_water_ ? way : 0.0f;
        if (from_below_ && !onward_only_) in_water += glm::length(surface - light_position_);
        return glm::exp(-extinction_ * in_water);
    }
    const glm::dvec3 from(surface), onward = glm::dvec3(point) - from;
    glm::dvec3 back = -sun_direction_;
    double before = std::numeric_limits<double>::infinity();
    if (!sun_) {
        back = glm::dvec3(light_position_) - from;
        before = glm::length(back);
        back /= before;
    }
    const double after = glm::length(onward);
    glm::dvec3 depth(0);
    if (!onward_only_) depth = media_.optical_depth(from, back, before, from_below_);
    if (after > 0) depth += media_.optical_depth(from, onward / after, after, in_water_);
    return glm::vec3(glm::exp(-depth));
}

}  // namespace dapple::light
