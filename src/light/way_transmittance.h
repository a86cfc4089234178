#pragma once
#include <glm/glm.hpp>

#include "light/beam_mesh.h"
#include "media/media.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// What the media on both sides of the water leave of the light of a beam mesh, along each ray's own way. The
/// scene and the media must outlive it.
class WayTransmittance {
public:
    WayTransmittance(const scene::FrameScene& scene, const media::Media& media, const BeamMesh& mesh);

    /// Share of the light, a channel, that reaches the water at `surface` (of a mirrored mesh: of what leaves
    /// the mirror there) and from there, `way` m on, a `point`; both m, relative to FrameScene::origin.
    glm::vec3 of(glm::vec3 surface, glm::vec3 point, float way) const;

    /// Whether nothing but the water lies on the ways: then only their lengths in it count, each channel's
    /// share being e^(-extinction length).
    bool only_water() const { return !bounded_; }
    glm::vec3 extinction() const { return extinction_; }  ///< 1/m, of the water

private:
    const media::Media& media_;
    glm::vec3 extinction_, light_position_;
    glm::dvec3 sun_direction_;
    bool sun_, from_below_, in_water_;
    bool onward_only_;  // the mesh's tints have the way before
    bool bounded_;      // some medium but the water may lie on the ways
};

}  // namespace dapple::light
