#pragma once
#include <cstdint>
#include <vector>

#include "light/beam_flux.h"
#include "light/steepness_map.h"
#include "rays/ray_scene.h"

namespace dapple::light {

/// The share of each triangle of the water that no other wave hides from the light; 1 for triangles that do
/// not face it. A grid need be asked only where some triangle faces away from the light
/// (FluxSurvey::faces_away): where all face it, the light's projection of the grid is one to one and nothing
/// hides anything.
/// A triangle whose corners are all lit, or all hidden, is so as a whole; others are sampled at the centres
/// of 16 equal parts.
std::vector<float> visible_shares(const scene::FrameScene& scene, const rays::RayScene& rays,
                                  const WaterLight& light);

/// Flux of the sheet's beams that meets the water again, by how many of a triangle's three rays do.
/// Only rays that may, by `steepness`, are traced. `crossings`: what is known of the rays, a vertex, shared
/// by the sheets of one direction and channel; empty before the first.
template <class Real>
double second_crossing(const scene::FrameScene& scene, const rays::RayScene& rays, const WaterLight& light,
                       const BeamSheet<Real>& sheet, const SteepnessMap& steepness,
                       std::vector<std::uint8_t>& crossings);

}  // namespace dapple::light
