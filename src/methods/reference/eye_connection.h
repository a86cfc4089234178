#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "methods/reference/light_tracer.h"
#include "methods/reference/own_media.h"
#include "methods/reference/scattering_event.h"
#include "scene/frame_scene.h"

namespace dapple::reference {

/// S of segments that start at the eye of a perspective camera, without bias. A way of light is a straight
/// line in the picture. Events lie evenly along that line, one in each of equal parts, which is the same as
/// evenly in the angle about the eye (equi-angular sampling, Kulla & Fajardo 2012) up to the cosine to the
/// camera's axis: the square of the distance to the eye cancels. What is left grows as 1 / D where the way
/// passes the eye at D m; in proportion there are more events, so that all of them weigh about the same
/// however near the eye they are.
class EyeConnection {
public:
    /// `scene` outlives it.
    EyeConnection(const scene::FrameScene& scene, bool in_water);

    static constexpr std::uint32_t kNone = 0xffffffffu;
    /// Of each pixel: the segment, or kNone, and the factor from radiance at the eye to S of that segment.
    struct Target {
        std::uint32_t segment = kNone;
        glm::dvec3 factor{0};
    };
    std::vector<Target> targets;

    bool any() const { return any_; }
    void find_any();
    /// Adds what a way of light scatters into the picture. True where places were found at which a medium had
    /// dimmed the light to 0, so that shallower ones may have been missed.
    bool add_events(const LightWay& way, MediaProbe& light_probe, MediaProbe& eye_probe, RandomStream& random,
                    std::vector<ScatteringEvent>& events) const;

private:
    struct Clip {
        double begin, end;  ///< m along the way
        glm::dvec4 a, b;    ///< homogeneous pixels at both
        double pixels;      ///< length in the picture
    };
    bool clip(const LightWay& way, const Stretch& stretch, Clip& result) const;

    const scene::FrameScene& scene_;
    glm::dvec3 eye_{0};
    glm::dvec3 forward_{0};
    glm::dmat4 pixel_from_relative_{1.0};
    double pixel_size_ = 0;  ///< of a pixel at unit distance
    bool in_water_ = false;
    double typical_distance_ = 1;  ///< m from the eye, at which events lie kSpacing apart
    bool any_ = false;
};

}  // namespace dapple::reference
