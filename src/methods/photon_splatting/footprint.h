#pragma once
#include <glm/glm.hpp>

#include "methods/photon_splatting/kernel.h"
#include "methods/photon_splatting/photon_grid.h"
#include "scene/frame_state.h"

namespace dapple::methods {

/// Two sides of the parallelograms, on the tangent planes, that eight photons light.
struct Footprints {
    Vectors3 first;  ///< m
    Vectors3 second;
    Floats gain = all(1.0f);    ///< times the photon's power
    Flags without_neighbors{};  ///< where it needed some: it is alone on its sheet of the water
};

/// One a name, each in a file of its own. They keep flux: what a photon carries does not hang on its
/// footprint, but for the gain of the last.
Footprints difference_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits);
Footprints fixed_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits);
Footprints differential_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits);
Footprints point_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits);
// As their papers have them.
Footprints paper_difference_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits);
Footprints paper_fixed_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits);
Footprints paper_differential_footprint(const PhotonGrid& grid, const Photons& photons,
                                        const PhotonHits& hits);
Footprints paper_point_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits);

/// What is made of a photon in a method's run.
struct SplatStyle {
    Footprints (*footprint)(const PhotonGrid&, const Photons&, const PhotonHits&) = difference_footprint;
    KernelStyle kernel;
    /// The footprint is a cell of the photons' lattice, of which a short one is taken: a sliver would fall
    /// between samples.
    bool reduced = true;
    bool disc = true;              ///< widened by the sun's disc
    bool every_face = true;        ///< splatted on the planes that neighbours landed on, too
    bool paper_power = false;      ///< see PhotonPower
    bool paper_receivers = false;  ///< receivers are told by depth, not by position, normal and medium
};
SplatStyle splat_style(const scene::Caustics& caustics);

}  // namespace dapple::methods
