#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "base/stats.h"
#include "light/beam_mesh.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// Flux of the event that no beam carries, by cause; unit of BeamSheet::flux.
struct BeamLosses {
    double absorbed = 0;          ///< or scattered by media between the light and the surface
    double wave_shadow = 0;       ///< other waves stand between the light and the facet
    double total_reflection = 0;  ///< transmission from below: triangles across the critical angle
    double outside_cone = 0;      ///< the triangle's three rays fit no one sheet's cone
    double not_finite = 0;        ///< normals are not finite; by Fresnel of the triangle's own plane
    /// Facets with vertices that are not finite: nobody knows what they would have met.
    std::size_t unknown_facets = 0;
    /// Carried by beams all the same, but these meet the water a second time, which is not followed.
    double second_crossing = 0;

    BeamLosses& operator+=(const BeamLosses& other);
    /// That share of the flux.
    BeamLosses scaled(double share) const;
};

/// A beam mesh whose grid is the water mesh itself: every vertex is a ray just after one event at the water,
/// every triangle a caustic beam. Mesh space has the orthonormal right-handed axes a, b and `axis` (the mean
/// direction of travel) and its zero at FrameScene::origin; `depth` runs along the axis. A ray passes
/// (a + depth slope_a, b + depth slope_b, depth), so landing points are linear in depth.
template <class Real>
struct BeamSheet {
    struct Ray {
        Real a, b;              ///< m, where it passes (or would pass) the plane depth = 0
        Real slope_a, slope_b;  ///< m a m of depth
    };

    std::string name;  ///< for plans and stats: "sun > water:T"
    int light = 0;     ///< index into FrameState::lights
    Event event = Event::transmission;
    bool from_below = false;  ///< the light is under water: T lands in the air, R in the water
    /// Whether the rays travel through the water after the event.
    bool in_water() const { return from_below == (event == Event::reflection); }
    /// Of a chain's channels and directions the one by which paths are counted, whatever the light's colour:
    /// the first direction's, all channels or green. All sheets of other axes of that one have it too.
    bool counts_paths = true;

    /// Direction of travel of the light of this sheet (a sun: one direction of its disc); 0 for point, spot.
    glm::dvec3 light_direction{0, 0, 0};
    /// W/m^2 or W/sr a channel that a flux of 1 stands for: the light's, times the share of the sun's disc,
    /// 0 in channels that the sheet does not carry.
    glm::dvec3 color{0, 0, 0};
    glm::dmat3 world_from_mesh{1.0};  ///< columns: a, b, axis

    int rows = 0;  ///< of vertices, as WaterMesh; 0: indexed
    int columns = 0;
    std::vector<Ray> rays;            ///< a vertex of the water mesh; finite also where not valid
    std::vector<Real> start;          ///< m, depth at which the ray leaves the water surface
    std::vector<std::uint8_t> valid;  ///< 1 where there is a ray of this sheet
    /// A triangle of the water mesh, after extinction before the surface, Fresnel and wave shadows, and with
    /// the mean of a spot's picture over it, for a
    /// light of unit irradiance (sun: m^2) or unit intensity (point, spot: sr). 0 where a vertex has no ray;
    /// never negative.
    std::vector<Real> flux;
    /// Of a triangle, by how much more of a channel there is than of all, where channels that go the same
    /// ways are not dimmed or coloured alike before the surface: `flux` is the mean of theirs, weighted by
    /// `color`. Empty: they are alike.
    std::vector<glm::vec<3, Real>> tint;
    glm::vec<3, Real> tint_of(std::size_t triangle) const {
        return tint.empty() ? glm::vec<3, Real>(1) : tint[triangle];
    }
    /// W a channel.
    glm::dvec3 power(std::size_t triangle) const {
        return static_cast<double>(flux[triangle]) * color * glm::dvec3(tint_of(triangle));
    }
    /// The part of the sun's disc that this sheet stands for: semi-axes of the ellipse by which a landing
    /// point moves, in (a, b), m a m of way along the axis below the surface; 0: none. For flat water; u is
    /// in the plane of incidence. 0 also on sheets about other axes that flat water sends nothing along.
    glm::dvec2 disc_u{0, 0};
    glm::dvec2 disc_v{0, 0};

    /// Those of one direction and channel are on the first of its sheets; second_crossing is each sheet's
    /// own.
    BeamLosses losses;
};

/// Beams of one light after one event, in a fixed order: the directions of the sun's disc (`sun_samples`
/// equal parts of it, the same in every frame; 1: its middle; each with its part's ellipse), within these
/// the channels where dispersion parts their ways, within these the axes where one cone cannot hold all
/// directions: every triangle has flux in one of these at most, the first that holds its three rays. Beams
/// of all channels are tinted where extinction before the surface, by the water about a lamp or by bounded
/// media, or the colours of a spot's picture tell these apart. dot(direction, axis) > 0.1 for all rays.
/// Fluxes of the two chains of a light, with their losses (but for second crossings), sum to what the light
/// sends onto the lit side of the water. Occlusion by objects is not in the fluxes. Empty where the light has
/// set or is in the rest plane.
template <class Real>
std::vector<BeamSheet<Real>> water_beams(const scene::FrameScene& scene, const rays::RayScene& rays,
                                         Chain chain, int sun_samples, FrameStats& stats);

/// Whether the channels of a light may be dimmed or coloured unevenly before the surface, so that its beams
/// are tinted: by the state alone, for the memory that is needed.
bool may_tint(const scene::FrameState& state, const scene::Light& light);

}  // namespace dapple::light
