#pragma once
#include <glm/glm.hpp>

#include "scene/frame_state.h"

/// Area lights: flat emitters of which one side sends the same radiance in all directions (Lambert's law).
/// Their light is found by points that stand for equal parts of them.
namespace dapple::scene {

inline bool is_area(const Light& light) {
    return light.type == LightType::quad || light.type == LightType::disc;
}

/// Unit vectors across a light's direction as the light sees them: right is direction x (0, 1, 0), and +x
/// where the direction is vertical, so that up is -z for what shines straight down; turned by `roll`.
struct LightFrame {
    glm::dvec3 right, up;
};
LightFrame light_frame(const Light& light);

/// m^2
double emitter_area(const Light& light);

/// Radius of the emitter's smallest sphere, m.
double emitter_reach(const Light& light);

/// m: a point of a part of an emitter. Places in [0, 1]^2 lie evenly over the part.
glm::dvec3 emitter_point(const Light& part, glm::dvec2 place);

/// The same state with `samples` parts in place of each area light, in a fixed order, each at its own middle
/// with its intensity and spread. Lights without a name are given that of their place in the timeline.
FrameState with_emitter_parts(FrameState state);

}  // namespace dapple::scene
