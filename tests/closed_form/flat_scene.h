#pragma once
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "optics/optics.h"
#include "scene/frame_state.h"

/// Scenes of the closed forms: water over one level, untextured floor, seen by a camera under water.
namespace dapple::test {

inline scene::Light sun_from_zenith(double zenith_degrees) {
    const double zenith = glm::radians(zenith_degrees);
    scene::Light sun;
    sun.name = "sun";
    sun.direction = {std::sin(zenith), -std::cos(zenith), 0};
    sun.irradiance = {3, 2, 1};
    sun.angular_diameter = 0;
    return sun;
}

inline scene::Object level_plane(const char* name, double height, double size) {
    scene::Object plane;
    plane.name = name;
    plane.shape = scene::Shape::plane;
    plane.size = {size, 1, size};
    plane.transform.position = {0, height, 0};
    plane.material.color = {0.8, 0.5, 0.3};
    return plane;
}

/// `patch` m of water in x and z, floor at -`depth`; the camera looks straight down (+x to the right, the top
/// of the picture towards -z) at `view` m of the floor from just below the surface.
inline scene::FrameState pool_over_floor(double patch, double depth, double view, int pixels) {
    scene::FrameState state;
    state.clip.width = state.clip.height = pixels;
    state.clip.samples = 1;
    state.camera.projection = scene::Projection::orthographic;
    state.camera.position = {0, -0.1, 0};
    state.camera.target = {0, -1, 0};
    state.camera.up = {0, 0, -1};
    state.camera.view_height = view;
    state.water.emplace();
    state.water->extent.size = {patch, patch};
    state.water->absorption = {0.4, 0.1, 0.03};
    state.objects.push_back(level_plane("floor", -depth, 100));
    return state;
}

/// Irradiance of a level floor below flat water for a sun of unit irradiance, before absorption, and the way
/// in the water, m: E = cos(i) T, d / cos(t).
struct FlatFloor {
    double irradiance;
    double way;
};

inline FlatFloor flat_floor(double zenith_degrees, double depth, double n) {
    // Written apart from the program's physics: angles and 1 - F, with Fresnel's sine and tangent forms.
    const long double i = glm::radians(static_cast<long double>(zenith_degrees));
    const long double t = std::asin(std::sin(i) / n);
    long double reflectance;
    if (zenith_degrees == 0) {
        reflectance = std::pow((n - 1.0L) / (n + 1.0L), 2);
    } else {
        const long double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
        reflectance = 0.5L * (s * s + p * p);
    }
    return {static_cast<double>(std::cos(i) * (1 - reflectance)), depth / static_cast<double>(std::cos(t))};
}

}  // namespace dapple::test
