#pragma once
#include <array>
#include <cstddef>
#include <glm/glm.hpp>

#include "light/beam_mesh.h"
#include "light/landing.h"
#include "methods/photon_splatting/photon_grid.h"

namespace dapple::methods {

/// Receivers within this share of the kernel's half-extent of the tangent plane are on the same surface: the
/// sagitta of a kernel as large as half the radius of curvature.
inline constexpr float kPlaneTolerance = 0.25f;

/// A tangent plane that a photon is splatted on.
struct LandedFace {
    float depth = 0;      ///< m along the mesh's axis, where the photon's ray meets it
    glm::vec3 normal{0};  ///< unit, against the ray
};
struct LandedFaces {
    std::array<LandedFace, 5> faces;
    std::size_t count = 0;
};

/// Which of the photons light no face but the one on which they landed, `depth` m along the mesh's axis: none
/// of their neighbours landed on another. For photons of which PhotonGrid::inner is true.
Flags on_one_face(const Photons& photons, const PhotonHits& hits, const light::Landings& landings,
                  std::size_t columns);

/// The faces that photon i lights: that on which it landed and, with `neighbors`, those on which its
/// neighbours on the grid landed, where its ray may reach them. Neighbours past the edge of a face so take
/// part in the lattice on it, and the sum of kernels is one up to the edge.
LandedFaces landed_faces(const light::BeamMesh& mesh, const light::Landings& landings, std::size_t i,
                         bool neighbors);

}  // namespace dapple::methods
