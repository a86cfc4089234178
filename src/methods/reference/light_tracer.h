#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <variant>
#include <vector>

#include "light/beam_mesh.h"
#include "methods/reference/energy_account.h"
#include "methods/reference/glass_bodies.h"
#include "methods/reference/glass_light.h"
#include "methods/reference/lamp.h"
#include "methods/reference/own_media.h"
#include "methods/reference/receiver_charts.h"
#include "methods/reference/water_rays.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/surface_point.h"

namespace dapple::reference {

/// What becomes of light after the first event, which its chain asks for. All on is the truth; off, it
/// ends where it meets such a thing, for comparison with methods that model one event only.
struct ReferenceOptions {
    bool second_crossings = true;  ///< the water again: both refraction and reflection are followed
    bool mirrors = true;
    /// Of E, a pass and source in the first round: a million rays in all.
    std::uint64_t first_strata = 65536;
};

/// Light that reached a diffuse surface.
struct Arrival {
    ChartPlace place;
    glm::dvec3 power{0};  ///< W a channel
};

/// A straight way of light after its first event, to the next or to its end; not those inside glass.
struct LightWay {
    glm::dvec3 position{0};   ///< m, relative to the origin
    glm::dvec3 direction{0};  ///< unit
    double length = 0;        ///< m; infinite where it meets nothing
    glm::dvec3 power{0};      ///< W a channel, where it begins
    bool in_water = false;
    std::uint64_t random = 0;  ///< index for random numbers
    std::uint32_t stratum = 0;
};

/// What a range of strata gives.
struct Harvest {
    std::vector<Arrival> arrivals;
    std::vector<LightWay> ways;  ///< only where they are asked for
    EnergyAccount account;
};

/// Follows light from the lights through one event at the water or at a body of glass, and any chain of
/// specular events after it, to diffuse surfaces: brute force, in double, with Embree to say which surface is
/// next. At each later event both refraction and reflection are followed, by weight.
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

    /// Sources: a light, and the water or the body of glass that it meets first.
    std::size_t sources() const { return sources_.size(); }
    /// Width over height of a source's strata, for a StrataLayout.
    double aspect(std::size_t source) const;
    std::size_t strata(const LightPass& pass, std::size_t source) const;
    /// Traces strata [begin, end) of one source. Results come in a fixed order. Thread-safe.
    Harvest trace(const LightPass& pass, std::size_t source, std::size_t begin, std::size_t end,
                  bool with_ways = false) const;

private:
    struct Source {
        std::variant<Lamp, GlassLight> lamp;
        std::uint32_t light = 0;
        int object = light::kWater;
        bool transmission = false, reflection = false;
    };
    static constexpr std::uint32_t kNoGlass = 0xffffffffu;
    struct LightRay {
        glm::dvec3 position{0};   ///< m, relative to the origin
        glm::dvec3 lift{0};       ///< m, off a mirror or glass that was left, to where rays are traced from
        double clear = 0;         ///< m of way within which triangles of the water that was left do not count
        glm::dvec3 direction{0};  ///< unit
        glm::dvec3 power{0};      ///< W
        double least_power = 0;   ///< W, mean of the channels: branches below it are not followed
        double index = 1;         ///< of the water, for this colour
        int events = 0;
        bool in_water = false;           ///< false in glass
        std::uint32_t glass = kNoGlass;  ///< the object that it is in
        bool left_water = true;          ///< it starts on the water's surface
        std::uint64_t random = 0;        ///< index of its random numbers
        std::uint32_t stratum = 0;
    };
    /// A smooth surface between two indices. Its outside is that of the normals: for the water, the air.
    struct Interface {
        glm::dvec3 position, geometric_normal, shading_normal;
        double outside = 1, inside = 1;  ///< indices
        std::uint32_t glass = kNoGlass;  ///< kNoGlass: the water
        bool outside_in_water = false;   ///< what lies about the glass
    };
    /// A tile on its way.
    struct Work {
        Harvest harvest;
        bool with_ways;
        MediaProbe probe;
        std::vector<LightRay> next;
    };
    bool meets_water_again() const;
    Interface water_interface(const LightRay& ray, const glm::dvec3& position, const glm::dvec3& geometric,
                              const glm::dvec3& shading) const;
    Interface glass_interface(const LightRay& ray, std::uint32_t object,
                              const view::SurfacePoint& point) const;
    template <class Meet>
    void start(const Source& source, LightRay ray, const glm::dvec3& power, const Meet& interface,
               Work& work) const;
    void follow(std::vector<LightRay> rays, Work& work) const;
    float water_before(const LightRay& ray, const rays::Hit& object) const;
    void go(LightRay& ray, double distance, Work& work) const;
    void arrive(LightRay ray, const rays::Hit& hit, Work& work) const;
    void meet_glass(LightRay ray, const rays::Hit& hit, Work& work) const;
    void mirror(LightRay ray, const view::SurfacePoint& point, const glm::dvec3& color, Work& work) const;
    void cross_again(LightRay ray, const rays::Hit& hit, Work& work) const;
    void add_branches(const LightRay& from, const Interface& surface, bool refract, bool reflect,
                      Work& work) const;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const ReceiverCharts& charts_;
    ReferenceOptions options_;
    OwnMedia media_;
    WaterRays water_;
    view::SurfaceGeometry geometry_;
    GlassBodies glass_;
    std::vector<Source> sources_;
};

}  // namespace dapple::reference
