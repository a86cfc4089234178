#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "layout/beam_volume.h"
#include "methods/adaptive_beams/beam_set.h"
#include "methods/adaptive_beams/bounding_volume.h"
#include "view/camera.h"

namespace dapple::methods::adaptive_beams {

/// The beams of a set as the device draws them for one camera.
struct DrawnBeams {
    std::vector<layout::DrawnBeam> beams;
    std::vector<layout::TurningArea> turning;
    std::vector<glm::vec3> corners;  ///< six a beam: x w and y w [pixels], and w; behind the camera w <= 0
    /// 24 a beam: first of the beams without listed triangles, then of those with; each in the set's order.
    std::vector<std::uint32_t> indices;
    std::size_t plain = 0;   ///< beams without listed triangles
    std::size_t prisms = 0;  ///< beams that have a prism for want of six triangles
};

/// Depths before its start that still belong to a beam, and beyond its end on the object that it ends on, m:
/// between its vertices a surface that they lie on may bulge. A constant, and a share of the beam's width
/// there.
constexpr double kLeastBias = 1e-3;
constexpr double kBiasOfWidth = 0.1;
/// Pixels by which volumes are wider than what is drawn: more than a rasteriser's rounding of corners (1/256
/// pixel).
constexpr double kMarginPixels = 1.0 / 32;

/// `origin`: FrameScene::origin. `reach`: pixels about a beam that are drawn too, since the parts of the
/// picture that their samples stand for may lie in the beam. The same bits on any number of threads.
DrawnBeams drawn_beams(const BeamSet& set, const view::Camera& camera, const glm::dvec3& origin,
                       VolumeKind kind, double reach);

/// Cuts beams into parts, each array of which but the indices has `largest` bytes at most, or is of one beam;
/// the parts together hold all beams in their order.
std::vector<DrawnBeams> parts_of(DrawnBeams drawn, std::uint64_t largest);

}  // namespace dapple::methods::adaptive_beams
