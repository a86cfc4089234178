#pragma once
#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "light/beam_mesh.h"
#include "scene/frame_state.h"

namespace dapple::light {

/// Rays fit a sheet where dot(direction, axis) exceeds this: 84 degrees about the axis.
constexpr double kConeCosine = 0.1;

/// Axes that the sheets of one direction and channel may have, in the order in which triangles try them: the
/// mean direction, then +x, -x, +z, -z, +y, -y. Every direction lies well inside the cone of one of the last
/// six, so a ray has always a sheet; a triangle has none where its rays fly too far apart.
constexpr int kSheetAxes = 7;
std::array<glm::dvec3, kSheetAxes> sheet_axes(glm::dvec3 mean);

/// Columns a, b, axis: orthonormal and right-handed. About straight down a is +x and b is +z.
glm::dmat3 mesh_frame(glm::dvec3 axis);

/// Directions of travel from `samples` parts of equal area of the sun's disc: a Fibonacci spiral, the first
/// of one being the middle. The same in every frame for the same sun.
std::vector<glm::dvec3> sun_directions(const scene::Light& sun, int samples);

/// Semi-axes of the ellipse by which flat water spreads the light of a small disc, as slopes of a sheet.
struct DiscEllipse {
    glm::dvec2 u{0, 0};
    glm::dvec2 v{0, 0};
};

/// `radius`: rad, of the disc about the unit `direction` of a light from above. By ray differentials of the
/// rest plane (Igehy 1999). None where the flat-water direction does not fit the sheet.
DiscEllipse disc_ellipse(glm::dvec3 direction, double radius, Event event, double refractive_index,
                         const glm::dmat3& world_from_mesh);

}  // namespace dapple::light
