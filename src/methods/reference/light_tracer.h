#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "light/beam_mesh.h"
#include "methods/reference/receiver_charts.h"
#include "methods/reference/true_surface.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/surface_point.h"

namespace dapple::reference {

/// What becomes of light after the event at the water that its chain asks for. All on is the truth; off, it
/// ends where it meets such a thing, for comparison with methods that model one event only.
struct ReferenceOptions {
    bool second_crossings = true;  ///< the water again: both refraction and reflection are followed
    bool mirrors = true;
};

/// Light that reached a diffuse surface.
struct Arrival {
    ChartPlace place;
    glm::dvec3 power{0};  ///< W a channel
};

/// One set of light rays, stratified over the water: each pass is an estimate of its own.
struct LightPass {
    std::uint64_t number = 0;  ///< of the pass; its random numbers follow from it and `strata`
    std::size_t strata = 0;    ///< asked for; strata() may be a few more
};

/// Follows light from the lights through one event at the water and any chain of specular events after it to
/// diffuse surfaces: brute force, in double, with Embree to say which surface is next.
class LightTracer {
public:
    /// `rays` and `scene` outlive the tracer. Builds a finer water mesh of its own where light may meet the
    /// water more than once.
    LightTracer(const scene::FrameScene& scene, const rays::RayScene& rays,
                const std::vector<light::Chain>& chains, const ReceiverCharts& charts,
                ReferenceOptions options);

    /// Lights that have a chain and shine on the water.
    std::size_t lights() const { return lights_.size(); }
    /// Strata of a pass, for each light.
    std::size_t strata(const LightPass& pass) const;
    /// Traces strata [begin, end) of one light and appends what arrives, in a fixed order. Thread-safe.
    void trace(const LightPass& pass, std::size_t light, std::size_t begin, std::size_t end,
               std::vector<Arrival>& arrivals) const;

private:
    struct LitBy {
        scene::Light light;
        std::uint32_t index = 0;  ///< in FrameState::lights
        bool transmission = false, reflection = false;
        bool from_above = true, from_below = false;  ///< sides of the water that it may light
        bool waves_may_shadow = false;
    };
    /// A place on the water that stands for an area of it.
    struct WaterPoint {
        glm::dvec3 position{0};  ///< m, relative to the origin
        glm::dvec3 area{0};      ///< m^2, along the geometric normal, to the air
        glm::dvec3 normal{0};    ///< unit, shading, to the air
    };
    /// Light on its way from the lamp to a point of the water.
    struct Incoming {
        WaterPoint point;
        glm::dvec3 direction{0};  ///< unit
        glm::dvec3 power{0};      ///< W on the point's area
        double side = 1;          ///< 1: from the air; -1: from the water
        double distance = 0;      ///< m from the lamp; infinite for a sun
    };
    struct LightRay {
        glm::dvec3 position{0};   ///< m, relative to the origin
        glm::dvec3 lift{0};       ///< m, off a mirror that was left, to where rays are traced from
        double clear = 0;         ///< m of way within which triangles of the water that was left do not count
        glm::dvec3 direction{0};  ///< unit
        glm::dvec3 power{0};      ///< W
        double least_power = 0;   ///< W, mean of the channels: branches below it are not followed
        double index = 1;         ///< of the water, for this colour
        int events = 0;
        bool in_water = false;
        bool left_water = true;  ///< it starts on the water's surface
    };
    struct Grid {
        std::size_t columns, rows;
    };
    struct Crossing {
        glm::dvec3 position, geometric_normal, shading_normal;
        double distance;
    };

    LitBy prepare(std::uint32_t index) const;
    /// Radians above the horizon from which the light comes at least, wherever it meets the water.
    double lowest_elevation(const scene::Light& light) const;
    bool meets_water_again() const;
    Grid grid(const LightPass& pass) const;
    std::vector<WaterPoint> sample_water(const LightPass& pass, std::uint32_t light, std::size_t begin,
                                         std::size_t end) const;
    std::optional<Incoming> illuminate(const LightPass& pass, const LitBy& by, const WaterPoint& point,
                                       std::size_t stratum) const;
    void remove_shadowed(const LitBy& by, std::vector<Incoming>& incoming) const;
    void meet_water(const LitBy& by, const Incoming& incoming, std::vector<LightRay>& rays) const;
    void follow(std::vector<LightRay>& rays, std::vector<Arrival>& arrivals) const;
    void arrive(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next,
                std::vector<Arrival>& arrivals) const;
    void cross_again(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next) const;
    Crossing true_crossing(const LightRay& ray, const rays::Hit& hit) const;
    void add_branches(const LightRay& from, const glm::dvec3& position, const glm::dvec3& geometric_normal,
                      const glm::dvec3& shading_normal, bool refract, bool reflect,
                      std::vector<LightRay>& next) const;
    bool may_meet_water(const glm::dvec3& direction) const;
    double size_of(const glm::dvec3& position) const;
    double clear_of_water(const glm::dvec3& position, const glm::dvec3& direction,
                          const glm::dvec3& normal) const;
    void absorb(glm::dvec3& power, double distance) const;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const ReceiverCharts& charts_;
    ReferenceOptions options_;
    TrueSurface surface_;
    view::SurfaceGeometry geometry_;
    std::vector<LitBy> lights_;
    /// The frame with the finer water mesh, and its rays; none where the light meets the water but once.
    std::optional<scene::FrameScene> water_scene_;
    std::optional<rays::RayScene> water_rays_;
    std::optional<view::SurfaceGeometry> water_geometry_;
    double chord_error_ = 0;  ///< m, of its triangles
};

}  // namespace dapple::reference
