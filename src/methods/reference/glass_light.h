#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "methods/reference/glass_bodies.h"
#include "methods/reference/light_samples.h"
#include "methods/reference/own_media.h"
#include "methods/reference/water_rays.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::reference {

/// Light that has come from a lamp to a body of glass, and met nothing before.
struct GlassIncoming {
    view::SurfacePoint point;
    glm::dvec3 direction{0};  ///< unit
    glm::dvec3 power{0};      ///< W
    bool inside = false;      ///< the lamp stands in the glass
    bool in_water = false;    ///< else: the light comes through the water
    double distance = 0;      ///< m from the lamp; infinite for a sun
    std::uint64_t random = 0;
    std::uint32_t stratum = 0;
};

/// One light and how it falls on one body of glass, as the first thing that it meets. Strata lie over the
/// light's view of the body: for a sun over its bounds on a plane that faces the sun, widened by the sun's
/// disc; for a lamp over its bounds in perspective, or over all directions where the body is all around.
/// What hits something else first is left out, so that no light is counted twice where bodies of glass or the
/// water lie behind one another.
class GlassLight {
public:
    /// All arguments outlive it. `light` and `object` are indices into FrameState.
    GlassLight(const scene::FrameScene& scene, const rays::RayScene& rays, const WaterRays& water,
               const GlassBodies& bodies, std::uint32_t light, std::uint32_t object);

    std::uint32_t object() const { return object_; }
    /// Of the view, for a StrataLayout.
    double aspect() const;
    std::size_t strata(const LightPass& pass) const;
    std::vector<GlassIncoming> shine(const LightPass& pass, std::size_t begin, std::size_t end,
                                     MediaProbe& probe) const;

private:
    /// A ray of light on its way to the body, that would carry `power`, W.
    struct Aimed {
        glm::dvec3 origin, direction, power;
    };
    Aimed from_sun(const glm::dvec2& place, double area, const SunRay& ray) const;
    Aimed from_lamp(const glm::dvec2& place, double area, const glm::dvec3& source) const;
    void remove_hidden(std::vector<GlassIncoming>& incoming) const;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const WaterRays& water_;
    const GlassBodies& bodies_;
    const scene::Light& light_;
    std::uint32_t object_;
    LightSamples samples_;
    OwnPicture picture_;
    bool sun_ = false;
    bool lamp_in_water_ = false;
    bool all_around_ = false;  ///< strata cover all directions of a lamp
    glm::dvec3 u_{0}, v_{0}, axis_{0};
    Rectangle view_;  ///< m for a sun; tangents for a lamp; the unit square where all_around_
};

}  // namespace dapple::reference
