#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "light/beam_mesh.h"
#include "methods/reference/lamp.h"
#include "methods/reference/own_media.h"
#include "methods/reference/receiver_charts.h"
#include "methods/reference/water_rays.h"
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

/// A straight way of light after its first event at the water, to the next or to its end.
struct LightWay {
    glm::dvec3 position{0};   ///< m, relative to the origin
    glm::dvec3 direction{0};  ///< unit
    double length = 0;        ///< m; infinite where it meets nothing
    glm::dvec3 power{0};      ///< W a channel, where it begins
    bool in_water = false;
    std::uint64_t random = 0;  ///< index for random numbers
    std::uint32_t stratum = 0;
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
    LightTracer(const LightTracer&) = delete;

    const OwnMedia& media() const { return media_; }
    const WaterRays& water() const { return water_; }

    /// Lights that have a chain and shine on the water.
    std::size_t lights() const { return lights_.size(); }
    const Lamp& lamp(std::size_t light) const { return lights_[light].lamp; }
    /// Strata of a pass, for each light.
    std::size_t strata(const LightPass& pass) const;
    /// Traces strata [begin, end) of one light and appends what arrives, in a fixed order, and, where `ways`
    /// is given, the ways that it took. Thread-safe.
    void trace(const LightPass& pass, std::size_t light, std::size_t begin, std::size_t end,
               std::vector<Arrival>& arrivals, std::vector<LightWay>* ways = nullptr) const;

private:
    struct LitBy {
        Lamp lamp;
        bool transmission = false, reflection = false;
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
        bool left_water = true;    ///< it starts on the water's surface
        std::uint64_t random = 0;  ///< index of its random numbers
        std::uint32_t stratum = 0;
    };
    /// What a tile of strata gives.
    struct Harvest {
        std::vector<Arrival>& arrivals;
        std::vector<LightWay>* ways;
        MediaProbe probe;
    };
    bool meets_water_again() const;
    void meet_water(const LitBy& by, const Incoming& incoming, std::vector<LightRay>& rays) const;
    void follow(std::vector<LightRay>& rays, Harvest& harvest) const;
    void go(LightRay& ray, double distance, Harvest& harvest) const;
    void arrive(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next, Harvest& harvest) const;
    void cross_again(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next, Harvest& harvest) const;
    void add_branches(const LightRay& from, const glm::dvec3& position, const glm::dvec3& geometric_normal,
                      const glm::dvec3& shading_normal, bool refract, bool reflect,
                      std::vector<LightRay>& next) const;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const ReceiverCharts& charts_;
    ReferenceOptions options_;
    OwnMedia media_;
    WaterRays water_;
    view::SurfaceGeometry geometry_;
    std::vector<LitBy> lights_;
};

}  // namespace dapple::reference
