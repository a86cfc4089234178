#pragma once
#include <glm/glm.hpp>

#include "methods/photon_splatting/lattice.h"
#include "methods/photon_splatting/photon_grid.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// How far apart photons of one place of the water land that points of one part of an area light send, or,
/// behind mirrors, of the sun's disc: what the middle sends is spread as far, so that few parts leave no
/// images of their own. To first order, by the differential of the ray whose light moves and whose place on
/// the water does not; on a mirror it meets another place, whose normal is another.
class EmitterBlur {
public:
    EmitterBlur(const scene::FrameScene& scene, const PhotonGrid& grid);

    /// Whether the light is a part of an area light, or a sun with a disc whose light a mirror has sent on:
    /// straight from the water the disc's image is as round as the disc, but for the slant.
    bool any() const { return any_; }
    /// Inverses of the covariances, 1/m^2, on the hits' planes, in coordinates along their unit vectors
    /// `right` and `up`. Covariances are never singular.
    Metric inverse_covariance(const Photons& photons, const PhotonHits& hits, Vectors3 right,
                              Vectors3 up) const;

private:
    const PhotonGrid& grid_;
    bool any_;
    /// Covariance u u^T + v v^T: as scene::EmitterPart; of the disc, that of its unit directions.
    glm::vec3 spread_u_, spread_v_;
};

}  // namespace dapple::methods
