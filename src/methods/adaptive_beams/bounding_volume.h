#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace dapple::methods::adaptive_beams {

/// Volumes that a rasteriser can draw about a beam, whose own sides are bilinear patches.
enum class VolumeKind {
    prism,  ///< three planes, each through an edge of the base triangle, that touch the beam (Ernst et al.
            ///< 2005)
    six_triangles,  ///< the hull of the beam's six corners (Liktor and Dachsbacher 2011, section 4.3)
};

/// A convex closed body of eight triangles: caps 0 1 2 and 3 4 5, in planes of constant depth, and six sides.
struct BoundingVolume {
    VolumeKind kind = VolumeKind::prism;
    std::array<glm::dvec3, 6> corner{};                 ///< m, mesh space
    std::array<std::array<std::uint8_t, 3>, 8> face{};  ///< counter-clockwise from outside
};

/// A beam between two depths.
struct BeamSection {
    std::array<glm::dvec2, 3> near, far;  ///< m, where the three rays pass the two depths
    double near_depth = 0;                ///< m
    double far_depth = 0;                 ///< m, more than near_depth
    double near_margin = 0;               ///< m by which the volume is wider than the beam there
    double far_margin = 0;
};

/// The volume about a beam. Six triangles are chosen for each edge of the two caps by itself: with the edge
/// goes that vertex of the other cap for which all others lie on one side. Where the choice is not unique (a
/// side that is nearly planar), where a cap is a line, and where the prism is the smaller, it is the prism.
BoundingVolume bounding_volume(const BeamSection& beam, VolumeKind wanted);

}  // namespace dapple::methods::adaptive_beams
