#pragma once
#include "methods/reference_volume_frame.h"

/// What the tests of the reference's light through glass share.
namespace dapple::test {

inline constexpr light::Event kThrough = light::Event::transmission, kBack = light::Event::reflection;

inline scene::Object glass(scene::Shape shape, glm::dvec3 position, double index) {
    scene::Object object;
    object.name = "glass";
    object.shape = shape;
    object.transform.position = position;
    object.material.glass = true;
    object.material.refractive_index = index;
    return object;
}

/// A frame whose first round, which is the answer, has a quarter of a million rays.
struct GlassFrame : Frame {
    explicit GlassFrame(const scene::FrameState& state, std::uint64_t strata = 16384) : Frame(state) {
        options.first_strata = strata;
    }
};

/// A floor at y = 0 in the air, seen straight down from under the glass at `height`; without water.
inline scene::FrameState floor_below(scene::Object body, double height, double view, int pixels) {
    scene::FrameState state;
    state.clip.width = state.clip.height = pixels;
    state.clip.samples = 1;
    state.camera.projection = scene::Projection::orthographic;
    state.camera.position = {0, height, 0};
    state.camera.target = {0, 0, 0};
    state.camera.up = {0, 0, -1};
    state.camera.view_height = view;
    state.objects = {level_plane("floor", 0, 100), std::move(body)};
    state.lights = {sun_from_zenith(0)};
    state.caustics.method = "reference";
    state.caustics.reference = kOneRound;
    return state;
}

/// A slab of 0.2 m over the floor, and the part of the floor that the sun's light through its middle reaches.
/// What enters by the sides never leaves by the bottom: it is totally reflected there. What they reflect
/// leaves by the bottom nearer to them than half the slab's width.
inline scene::FrameState slab_over_floor(double zenith, const glm::dvec3& absorption, int pixels) {
    scene::Object slab = glass(scene::Shape::box, {0, 0.6, 0}, 1.5);
    slab.size = {2.4, 0.2, 1.2};
    slab.material.absorption = absorption;
    scene::FrameState state = floor_below(slab, 0.4, 0.5, pixels);
    state.camera.position.x = state.camera.target.x = 0.6 * std::tan(glm::radians(zenith));
    state.lights = {sun_from_zenith(zenith)};
    return state;
}

/// T^2 a / (1 - R^2 a^2): straight through, and after any number of pairs of reflections inside; a is what
/// one way through leaves.
inline double slab_transmittance(double zenith, double thickness, double index, double absorption) {
    const Refraction at = refract(glm::radians(zenith), 1, index);
    const double way = std::exp(-absorption * thickness / std::cos(at.angle));
    const double r = at.reflectance;
    return (1 - r) * (1 - r) * way / (1 - r * r * way * way);
}

}  // namespace dapple::test
