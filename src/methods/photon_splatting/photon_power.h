#pragma once
#include <cstddef>
#include <glm/glm.hpp>

#include "light/way_transmittance.h"
#include "media/media.h"
#include "methods/photon_splatting/photon_grid.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// What photons carry where they land.
class PhotonPower {
public:
    /// `paper`: dimmed as in Kougianos and Moustakas 2021, equations 12 to 15: a ramp over the distance for
    /// the media, a power law for Fresnel's equations.
    PhotonPower(const scene::FrameScene& scene, const media::Media& media, const PhotonGrid& grid,
                bool paper);

    /// W, a channel.
    Vectors3 at(const Photons& photons, const PhotonHits& hits) const;

private:
    Vectors3 share(const Photons& photons, const PhotonHits& hits) const;
    Floats paper_share(const Photons& photons, const PhotonHits& hits) const;

    const PhotonGrid& grid_;
    light::WayTransmittance ways_;
    bool paper_;
    glm::vec3 color_;
};

}  // namespace dapple::methods
