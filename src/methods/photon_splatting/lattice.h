#pragma once
#include <array>
#include <glm/glm.hpp>

#include "methods/photon_splatting/lane_vectors.h"

namespace dapple::methods {

/// Two vectors that span the lattice of a photon and its neighbours, on the tangent plane of its landing
/// point.
struct LatticeBasis {
    Vectors2 first;  ///< m, coordinates in an orthonormal basis of the plane
    Vectors2 second;
    Floats weight = all(1.0f);  ///< share of the photon's flux
};

/// Scalar products of the plane: symmetric, positive.
struct Metric {
    Floats xx = all(1.0f), xy{}, yy = all(1.0f);
    Floats product(Vectors2 a, Vectors2 b) const {
        return a.x * (xx * b.x + xy * b.y) + a.y * (xy * b.x + yy * b.y);
    }
};

/// Short bases of the lattice in the metric: integer combinations of the given vectors with determinant +-1,
/// so kernels on them still sum to one over the lattice. Where two or three bases are about equally short the
/// photon's flux is shared between them, by shares that depend smoothly on the lattice: neighbouring photons
/// of a slowly varying lattice then never change kernels abruptly, which would show as a line. Bases that are
/// not needed have weight 0 and come last: of eight photons most need one, whichever pair it is.
using ReducedLattice = std::array<LatticeBasis, 3>;
ReducedLattice reduce_lattice(Vectors2 first, Vectors2 second, const Metric& metric);

}  // namespace dapple::methods
