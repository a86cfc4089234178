#pragma once
#include <array>
#include <glm/glm.hpp>

namespace dapple::methods {

/// Two vectors that span the lattice of a photon and its neighbours, on the tangent plane of its landing
/// point.
struct LatticeBasis {
    glm::vec2 first{1, 0};  ///< m, coordinates in an orthonormal basis of the plane
    glm::vec2 second{0, 1};
    float weight = 1;  ///< share of the photon's flux
};

/// Short bases of the lattice in the metric: integer combinations of the given vectors with determinant +-1,
/// so kernels on them still sum to one over the lattice. Where two or three bases are about equally short the
/// photon's flux is shared between them, by shares that depend smoothly on the lattice: neighbouring photons
/// of a slowly varying lattice then never change kernels abruptly, which would show as a line.
struct ReducedLattice {
    std::array<LatticeBasis, 3> bases;  ///< those past `count` mean nothing
    int count = 1;
};
ReducedLattice reduce_lattice(glm::vec2 first, glm::vec2 second, const glm::mat2& metric);

}  // namespace dapple::methods
