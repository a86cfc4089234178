#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "light/beam_mesh.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

/// One light path to a point, found on the water mesh.
struct PointPath {
    std::string chain;       ///< "sun > water:T"
    int light;               ///< index into FrameState::lights
    glm::dvec3 water_point;  ///< m, world, where the light leaves the water surface
    glm::dvec3 direction;    ///< unit, of travel after the event
    /// W/m^2 a channel, on the receiver's plane, after the water's extinction, as if nothing stood in the
    /// way: the mean over the landed beam.
    glm::dvec3 irradiance;
    /// det J: signed area of the beam's slice across the sheet's axis at the point over that of its facet
    /// seen along the axis; 1 just below the water.
    double jacobian;
    int sign;                                   ///< of the beam as landed on the receiver's plane
    double way;                                 ///< m, from the water to the point
    bool near_fold;                             ///< the point is near a fold of this path's own beam
    std::optional<std::uint32_t> blocker = {};  ///< index into FrameState::objects
    bool blocked_in_air = false;                ///< the blocker stands between light and water
    std::uint32_t triangle = 0;                 ///< of the water mesh
};

struct PointPaths {
    std::vector<PointPath> paths;
    int count = 0;
    int sign_sum = 0;
    bool fold = false;
};

/// All paths of all chains to a point (m, world), with a unit normal towards the side that is looked at; in
/// double, by exact predicates. A sun counts by the middle of its disc, dispersed light by its green.
PointPaths find_point_paths(const scene::FrameScene& scene, const rays::RayScene& rays,
                            std::span<const light::Chain> chains, const glm::dvec3& world_point,
                            const glm::dvec3& normal, bool in_water);

}  // namespace dapple::methods::sliced_beams
