#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "methods/reference/oracle_map.h"
#include "methods/reference/oracle_surface.h"
#include "scene/frame_state.h"

/// Proves how many specular paths lead from a light over the water to a point: interval Newton in Krawczyk's
/// form (Moore, Kearfott & Cloud, Introduction to Interval Analysis, 2009, chapter 8) on the analytic surface
/// of `waves`. It shares no physics with the rest of the program, so that it can judge it.
namespace dapple::oracle {

/// A path light - water - point.
struct Path {
    glm::dvec3 water_point{0, 0, 0};  ///< m, world space
    glm::dvec3 direction{0, 0, 0};    ///< unit, of travel after the event
    /// det d X / d (u, v): X is where the ray from above (u, v) meets the level plane through the point.
    double jacobian = 1;
    int sign = 1;  ///< of the jacobian, proven
    /// W/m^2 on the receiver for a light of 1 W/m^2, or of 1 W/sr along its axis; without absorption and
    /// without shadows. 0 where the light comes from behind the receiver, or none is sent. A spot's picture
    /// is left out.
    double irradiance = 0;
    /// The lamp's intensity towards the water point over that along its axis: 0 outside a spot's cone and
    /// behind an area light, of which the Oracle knows one part, by its point; 1 of a sun.
    double sent = 1;
    double transmittance = 1;  ///< Fresnel's share of the event: of reflection, the reflectance
    double way = 0;            ///< m, in the water; 0 after reflection
    /// Waves stand between the light and the facet, or between the facet and the point: nothing arrives.
    bool blocked = false;
};

/// A rectangle of the horizontal plane in which the number of paths was not decided. It may also hold paths
/// that are listed.
struct UndecidedBox {
    glm::dvec2 center{0, 0};  ///< m, world x and z
    glm::dvec2 half_size{0, 0};
};

struct Result {
    /// One an actual path: each proven to exist and to differ from the others. In no particular, but always
    /// the same, order.
    std::vector<Path> paths;
    /// There are no other paths, and each path is known to be blocked or not. False near folds of the
    /// landing map, and for paths that graze a wave or pass the edge of the water, within about 1e-10 m.
    bool proven = true;
    std::vector<UndecidedBox> undecided;  ///< empty if `proven`, but for grazing
    std::size_t boxes = 0;                ///< examined: what the proof cost

    /// Sums over the paths that are not blocked.
    double irradiance() const;
    /// Sum of the signs over all paths: +1 for a point that all rays land around.
    int sign() const;
};

/// Where one ray lands; plain double.
struct LandingPoint {
    glm::dvec3 water_point{0, 0, 0};  ///< m, world space
    glm::dvec2 position{0, 0};        ///< m, world x and z on the plane
    glm::dmat2 jacobian{1.0};         ///< columns: derivatives of `position` by u and by v
    glm::dvec3 direction{0, 0, 0};    ///< unit, after the event
    /// W per m^2 of horizontal area of water that leave the facet, for a light of 1 W/m^2, or of 1 W/sr along
    /// its axis; 0 for facets that face away.
    double flux = 0;
    double sent = 1;           ///< as Path::sent, where the facet faces the light
    double transmittance = 1;  ///< as Path::transmittance
    bool lands = false;        ///< the facet faces the light, and the plane lies ahead of the ray
};

/// One light over the water of one instant. Const and thread-safe.
class Oracle {
public:
    /// `water.surface` is a list of waves; the light is above the water. Error(failure) if not: sheets of
    /// light from below, and other surfaces, are not analytic here.
    Oracle(const scene::Water& water, const scene::Light& light, double time,
           Event event = Event::transmission);

    /// All paths to `point` [m] through the water's extent; `normal` (unit) of the receiver is for the
    /// irradiance only. After transmission the point is below the water, after reflection above it: paths
    /// that the water cuts off are marked as blocked.
    Result paths(const glm::dvec3& point, const glm::dvec3& normal) const;

    /// The forward map (u, v) [m, world x and z] to the level plane y = `plane`, also outside the extent.
    LandingPoint land(const glm::dvec2& uv, double plane) const;

    double height_bound() const { return surface_.height_bound(); }  ///< m

private:
    MapConstants constants(const glm::dvec2& anchor, double plane) const;
    LandingPoint land_local(const Surface::Local& surface, const MapConstants& map, const glm::dvec2& anchor,
                            const glm::dvec2& uv) const;
    Path path(const Surface::Local& surface, const MapConstants& map, const glm::dvec3& point,
              const glm::dvec3& normal, const glm::dvec2& root, bool& decided) const;
    Sight sight_of_light(const Surface::Local& surface, const MapConstants& map, const glm::dvec2& anchor,
                         const glm::dvec3& start) const;

    Surface surface_;
    scene::Light light_;
    scene::Extent extent_;
    double refractive_index_;
    Event event_;
};

}  // namespace dapple::oracle
