#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "light/beam_axes.h"
#include "light/spot_picture.h"
#include "light/water_beams.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// One light as the water sees it: a sun's part, or a lamp.
struct WaterLight {
    scene::LightType type = scene::LightType::sun;
    bool from_below = false;
    glm::dvec3 direction{0, -1, 0};  ///< unit, of travel; sun, spot, area light
    glm::dvec3 position{0, 0, 0};    ///< m, world; all but suns
    double cos_outer = -2;           ///< spot, as optics/spot_light.h
    double cos_inner = 1;
    double extinction = 0;  ///< /m, of the water, on the way from a lamp in it to the surface
    /// Optical depth from the light to each vertex of the water mesh, where there is more than the water on
    /// the way; else empty.
    std::span<const float> depths = {};
    const SpotPicture* picture = nullptr;  ///< of a spot that throws one
    int channel = 1;                       ///< of the picture

    double side() const { return from_below ? -1 : 1; }  ///< times a water normal: towards the light
};

/// What the event did at the vertices of the water mesh.
struct VertexEvents {
    /// Transmittance or reflectance, times a spot's falloff and what media left over on the way from the
    /// light; NaN where position or normal means nothing.
    std::vector<double> share;
    /// By how much more `share` would be without extinction; empty where there is none.
    std::vector<double> absorbed;
    /// Bit k: the ray fits the cone of sheet_axes()[k]. 0: there is no ray.
    std::vector<std::uint8_t> cones;
    /// Of all rays, the least ratio of the squares of rise and of horizontal way.
    double flattest_squared = 0;
};

/// Fills `sheet.rays`, `start` and `valid` for the axis `axis_index`, and `events`.
/// `eta`: index on the light's side over that on the other.
template <class Real>
void trace_vertices(const scene::FrameScene& scene, const WaterLight& light, double eta,
                    const std::array<glm::dvec3, kSheetAxes>& axes, int axis_index, BeamSheet<Real>& sheet,
                    VertexEvents& events);

struct FluxSurvey {
    bool faces_away = false;      ///< some triangle does not face the light: shadows on the water can be
    double steepest_squared = 0;  ///< square of the largest slope of a triangle; infinite for overhangs
    std::uint32_t axes = 0;       ///< bit k: a triangle fits sheet_axes()[k] and none before it
    BeamLosses losses;
};

/// Signed light that a triangle meets, for unit irradiance (m^2) or unit intensity (sr): exact for a plane
/// triangle, negative where it faces away. The lamp's is the solid angle (van Oosterom & Strackee 1983).
double incident_on_triangle(const scene::TriangleMesh& mesh, glm::uvec3 triangle, const WaterLight& light);

/// Fills `sheet.flux` with the triangles whose first axis is `axis_index`: light met, times the mean share of
/// the three vertices, times the mean of the light's picture over the triangle, times `visible` (a triangle;
/// empty: 1).
template <class Real>
FluxSurvey fill_flux(const scene::TriangleMesh& mesh, const WaterLight& light, double eta,
                     const VertexEvents& events, const std::vector<float>& visible, int axis_index,
                     BeamSheet<Real>& sheet);

}  // namespace dapple::light
