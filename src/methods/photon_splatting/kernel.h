#pragma once
#include <glm/glm.hpp>

#include "methods/photon_splatting/lattice.h"

namespace dapple::methods {

/// What decides how far a photon's kernel is widened, on the tangent plane of its landing point.
struct KernelMetric {
    glm::mat2 pixel_from_plane{1};  ///< pixels a m
    glm::mat2 beam_gram{1};         ///< squared lengths across the beam of vectors on the plane
    float disc_radius = 0;          ///< m across the beam, of the image of the sun's disc
};

/// The metric in which the lattice is reduced: that of the pixel and the disc together.
glm::mat2 reduction_metric(const KernelMetric& metric);

/// A kernel on the plane: profile(a, box_a) * profile(b, box_b) at the point a first + b second, |a|, |b| <=
/// 1, with integral 1 over (a, b). Each profile is the lattice's tent convolved with a box: tents on a
/// lattice sum to one and reproduce linear functions, and keep both under convolution with anything, so the
/// box may have any width.
struct PlaneKernel {
    glm::vec2 first;  ///< m, half-extents of the support
    glm::vec2 second;
    float box_first;  ///< half-width of the box, in units of the support; the tent's is 1 - that
    float box_second;
};

/// Widens the tent on a lattice basis. By a pixel's box where the spacing is a pixel or less, by less up to
/// spacings of two pixels, by nothing beyond; the sun's disc by a box of the disc's variance. Collapsed
/// vectors are replaced by a hundredth of a pixel across the other one, so the kernel is always finite and
/// keeps its integral.
PlaneKernel widened_kernel(const LatticeBasis& basis, const KernelMetric& metric);

}  // namespace dapple::methods
