#pragma once
#include <glm/glm.hpp>

#include "methods/photon_splatting/kernel.h"
#include "methods/photon_splatting/photon_grid.h"
#include "scene/frame_state.h"

namespace dapple::methods {

/// Two sides of the parallelogram, on the tangent plane, that a photon lights.
struct Footprint {
    glm::vec3 first{0};  ///< m
    glm::vec3 second{0};
    float gain = 1;                  ///< times the photon's power
    bool without_neighbors = false;  ///< where it needed some: it is alone on its sheet of the water
};

/// One a name, each in a file of its own. They keep flux: what a photon carries does not hang on its
/// footprint, but for the gain of the last.
Footprint difference_footprint(const PhotonGrid& grid, const PhotonHit& hit);
Footprint fixed_footprint(const PhotonGrid& grid, const PhotonHit& hit);
Footprint differential_footprint(const PhotonGrid& grid, const PhotonHit& hit);
Footprint point_footprint(const PhotonGrid& grid, const PhotonHit& hit);
// As their papers have them.
Footprint paper_difference_footprint(const PhotonGrid& grid, const PhotonHit& hit);
Footprint paper_fixed_footprint(const PhotonGrid& grid, const PhotonHit& hit);
Footprint paper_differential_footprint(const PhotonGrid& grid, const PhotonHit& hit);
Footprint paper_point_footprint(const PhotonGrid& grid, const PhotonHit& hit);

/// What is made of a photon in a method's run.
struct SplatStyle {
    Footprint (*footprint)(const PhotonGrid&, const PhotonHit&) = difference_footprint;
    KernelStyle kernel;
    /// The footprint is a cell of the photons' lattice, of which a short one is taken: a sliver would fall
    /// between pixels.
    bool reduced = true;
    bool disc = true;              ///< widened by the sun's disc
    bool every_face = true;        ///< splatted on the planes that neighbours landed on, too
    bool paper_power = false;      ///< see PhotonPower
    bool paper_receivers = false;  ///< receivers are told by depth, not by position, normal and medium
};
SplatStyle splat_style(const scene::Caustics& caustics);

}  // namespace dapple::methods
