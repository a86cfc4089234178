#pragma once
#include <cstdint>
#include <glm/glm.hpp>

#include "methods/reference/oracle_dual.h"

namespace dapple::oracle {

/// What happens to the light at the water.
enum class Event : std::uint8_t { transmission, reflection };

/// One light, one event, one level plane; x and z relative to the receiver's, y as in the world.
struct MapConstants {
    Event event = Event::transmission;
    bool sun = true;
    glm::dvec3 light{0, -1, 0};  ///< a sun's direction of travel (unit); else the place of the lamp, m
    double eta = 1 / 1.333;      ///< index of the air over that of the water
    double plane = -1;           ///< m, height of the level plane on which rays land
};

/// A ray after the event. Its direction of travel, up to its length, is (ahead_x, -+ahead_y, ahead_z), down
/// after transmission and up after reflection; it approaches the plane where ahead_y > 0.
template <class T>
struct Departure {
    /// -(way to the facet) . (-dh/dx, 1, -dh/dz): > 0 where the light comes from the facet's air side.
    T facing;
    T drop;  ///< m from the facet to the plane; > 0 where the plane is on the side that the ray leaves to
    T ahead_x, ahead_y, ahead_z;
};

/// Of the ray that comes along `way`, of squared length `distance2`, to a facet with these slopes. Way is a
/// plain number where the direction is the same everywhere.
///
/// Snell's law in vector form is t = eta i + (eta c - sqrt(1 - eta^2 (1 - c^2))) N. With the normal
/// M = (-h_x, 1, -h_z) = L N and the way w = R i, with C = -w . M, S = sqrt(R^2 L^2 (1 - eta^2) + eta^2 C^2)
/// and s = S + eta C, the bracket is -(1 - eta^2) R L / s, since S^2 - eta^2 C^2 = R^2 L^2 (1 - eta^2). Times
/// s R that reads t ~ eta s w - (1 - eta^2) R^2 M: no difference of near numbers and no division. A mirror
/// turns w into w + 2 C M / L^2.
template <class T, class Way>
Departure<T> departure_along(const MapConstants& map, const Way& way_x, const Way& way_y, const Way& way_z,
                             const Way& distance2, const T& height, const T& slope_x, const T& slope_z) {
    const T length2 = square(slope_x) + square(slope_z) + 1.0;
    Departure<T> ray;
    ray.facing = way_x * slope_x + way_z * slope_z - way_y;
    if (map.event == Event::reflection) {
        const T twice = 2.0 * ray.facing;
        ray.ahead_x = way_x * length2 - twice * slope_x;
        ray.ahead_z = way_z * length2 - twice * slope_z;
        ray.ahead_y = way_y * length2 + twice;
        ray.drop = map.plane - height;
        return ray;
    }
    const Way scaled = (1 - map.eta) * (1 + map.eta) * distance2;
    const T eta_c = map.eta * ray.facing;
    const T eta_s = map.eta * (square_root(scaled * length2 + square(eta_c)) + eta_c);
    ray.ahead_x = way_x * eta_s + scaled * slope_x;
    ray.ahead_z = way_z * eta_s + scaled * slope_z;
    ray.ahead_y = scaled - way_y * eta_s;
    ray.drop = height - map.plane;
    return ray;
}

/// The ray that leaves the water at (x, height, z). T is a number, an interval, or the Dual of one of them.
template <class T>
Departure<T> departure(const MapConstants& map, const T& x, const T& z, const T& height, const T& slope_x,
                       const T& slope_z) {
    if (map.sun) {
        return departure_along<T, double>(map, map.light.x, map.light.y, map.light.z, 1.0, height, slope_x,
                                          slope_z);
    }
    const T way_x = x - map.light.x, way_y = height - map.light.y, way_z = z - map.light.z;
    const T distance2 = square(way_x) + square(way_y) + square(way_z);
    return departure_along<T, T>(map, way_x, way_y, way_z, distance2, height, slope_x, slope_z);
}

/// Where the ray meets the plane, relative to the receiver: X = (x, z) + drop (ahead_x, ahead_z) / ahead_y.
template <class T>
struct Landing {
    T x, z;
};
template <class T>
Landing<T> landing(const Departure<T>& ray, const T& x, const T& z) {
    return {x + ray.drop * (ray.ahead_x / ray.ahead_y), z + ray.drop * (ray.ahead_z / ray.ahead_y)};
}

}  // namespace dapple::oracle
