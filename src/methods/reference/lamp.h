#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "methods/reference/glass_bodies.h"
#include "methods/reference/light_samples.h"
#include "methods/reference/own_media.h"
#include "methods/reference/water_rays.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::reference {

/// A place on the water that stands for an area of it.
struct WaterPoint {
    glm::dvec3 position{0};  ///< m, relative to the origin
    glm::dvec3 area{0};      ///< m^2, along the geometric normal, to the air
    glm::dvec3 normal{0};    ///< unit, shading, to the air
};

/// Light that has come from a lamp to a point of the water.
struct Incoming {
    WaterPoint point;
    glm::dvec3 direction{0};   ///< unit
    glm::dvec3 power{0};       ///< W on the point's area
    glm::dvec3 source{0};      ///< m, relative to the origin: where it left a lamp
    double side = 1;           ///< 1: from the air; -1: from the water
    double distance = 0;       ///< m from the lamp; infinite for a sun
    std::uint64_t random = 0;  ///< index of its random numbers
    std::uint32_t stratum = 0;
};

/// One light and how it falls on the water, as the first thing that it meets.
class Lamp {
public:
    /// All arguments outlive the lamp. `index` into FrameState::lights.
    Lamp(const scene::FrameScene& scene, const rays::RayScene& rays, const WaterRays& water,
         const GlassBodies& glass, const OwnMedia& media, std::uint32_t index);

    /// Radians above the horizon (below, for a lamp in the water) from which the light comes at least.
    double lowest_elevation() const;
    /// Whether some of its light may meet waves before it comes to where it is sampled.
    bool waves_may_shadow() const { return waves_may_shadow_; }
    bool may_shine_from_below() const { return from_below_; }
    /// Of the water, for a StrataLayout.
    double aspect() const;

    /// Strata of a pass: those asked for, or a few more.
    std::size_t strata(const LightPass& pass) const;
    /// What comes to the water in strata [begin, end), without what objects or waves hide, or meets glass
    /// there.
    std::vector<Incoming> shine(const LightPass& pass, std::size_t begin, std::size_t end,
                                MediaProbe& probe) const;

private:
    std::vector<WaterPoint> sample_triangles(const LightPass& pass, std::size_t begin, std::size_t end) const;
    std::vector<WaterPoint> sample_height_field(const LightPass& pass, std::size_t begin,
                                                std::size_t end) const;
    std::optional<Incoming> illuminate(const LightPass& pass, const WaterPoint& point,
                                       std::size_t stratum) const;
    void remove_hidden(std::vector<Incoming>& incoming) const;
    void attenuate(std::vector<Incoming>& incoming, MediaProbe& probe) const;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const WaterRays& water_;
    const GlassBodies& glass_;
    const OwnMedia& media_;
    const scene::Light& light_;
    LightSamples samples_;
    OwnPicture picture_;
    double reach_ = 0;  ///< m, from the lamp's position to the farthest point that shines
    bool from_above_ = true, from_below_ = false;  ///< sides of the water that it may light
    bool waves_may_shadow_ = false;
};

}  // namespace dapple::reference
