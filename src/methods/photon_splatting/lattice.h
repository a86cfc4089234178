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

/// The shortest basis of the lattice in the metric (Lagrange and Gauss): integer combinations of the given
/// vectors with determinant +-1, so kernels on it still sum to one over the lattice. Where two bases are
/// about equally short the photon's flux is shared between both, the shares passing smoothly from one to the
/// other: neighbouring photons of a slowly varying lattice then never change kernels abruptly, which would
/// show as a line. `count` is 1 or 2.
struct ReducedLattice {
    std::array<LatticeBasis, 2> bases;
    int count = 1;
};
ReducedLattice reduce_lattice(glm::vec2 first, glm::vec2 second, const glm::mat2& metric);

}  // namespace dapple::methods
