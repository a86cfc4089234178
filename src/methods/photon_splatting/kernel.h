#pragma once
#include <glm/glm.hpp>

#include "methods/photon_splatting/lattice.h"

namespace dapple::methods {

/// What decides how far a photon's kernel is widened, on the tangent plane of its landing point.
struct KernelMetric {
    /// Cells of vectors of the plane, m: the parts of pixels that samples stand for (SamplePlace).
    Vectors2 cell_from_first{all(1.0f), all(0.0f)}, cell_from_second{all(0.0f), all(1.0f)};
    Metric beam;           ///< squared lengths across the beam of vectors on the plane
    Floats disc_radius{};  ///< m across the beam, of the image of the sun's disc

    Vectors2 cells(Vectors2 v) const { return v.x * cell_from_first + v.y * cell_from_second; }
};

/// The metric in which the lattice is reduced: that of the cell and the disc together, in any unit.
Metric reduction_metric(const KernelMetric& metric);

/// What a kernel is before it is widened, on vectors that span a lattice of photons.
enum class KernelShape {
    tent,  ///< sums to one over the lattice and reproduces linear functions
    box,   ///< a parallelogram of even brightness; sums to one over the lattice
};
struct KernelStyle {
    KernelShape shape = KernelShape::tent;
    float scale = 1;      ///< of its size: blur for gaps. A sum of one over the lattice needs a whole number.
    bool widened = true;  ///< by cell and disc; else, for boxes, seen at the samples' points as a raster does
};

/// A kernel on the plane: profile(a, box_a) * profile(b, box_b) at the point a first + b second, |a|, |b| <=
/// 1, with integral 1 over (a, b). Each profile is a tent or a box convolved with a box. Sums of one and what
/// is reproduced stay under convolution with anything, so this box may have any width.
struct PlaneKernel {
    Vectors2 first;  ///< m, half-extents of the support
    Vectors2 second;
    Floats box_first;  ///< half-width of the box, in units of the support; the shape's own is 1 - that
    Floats box_second;
};

/// Widens the shape on a lattice basis by a cell's box, so that the samples of pixels, at the middles of
/// their cells, hold all its flux together, and by the sun's disc, as a box of the same variance. Tents of a
/// whole scale, whose sum over the lattice holds the flux already, are widened by less than the cell beyond
/// spacings of one cell, and by nothing beyond two. Collapsed vectors are replaced by a hundredth of a cell
/// across the other one, so the kernel is always finite and keeps its integral; not so where it is not
/// widened.
PlaneKernel widened_kernel(const LatticeBasis& basis, const KernelMetric& metric,
                           const KernelStyle& style = {});

}  // namespace dapple::methods
