#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "light/beam_mesh.h"
#include "media/media.h"
#include "methods/adaptive_beams/light_view.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/surface_point.h"

namespace dapple::methods::adaptive_beams {

/// Why light of a path does not go on into its next leg.
enum class Cause : std::uint8_t {
    media,              ///< absorbed or scattered before the surface
    glass_absorption,   ///< inside glass
    glass_reflection,   ///< the Fresnel share that stays in a body where the path leaves it
    total_reflection,   ///< at the water or inside glass, where the path would have gone through
    later_reflection,   ///< the Fresnel share of later surfaces: there only what goes through is followed
    inside_glass,       ///< the way through a body ends at something else, or never
    too_many_surfaces,  ///< more than kMostLegs
    silhouette,         ///< between the last ray that meets a surface and the first that does not
    outside_cone,       ///< rays of one beam that fit no one set's cone
    too_weak,           ///< beams that carry next to nothing
    beyond,             ///< all rays of a beam miss everything that can be lit or seen
};
constexpr std::size_t kCauses = 11;
/// "lost to total reflection, W".
const char* loss_name(Cause cause);

/// Straight pieces of a path that are followed.
constexpr std::size_t kMostLegs = 5;

/// Where a leg ends: an object by its index, or
constexpr int kEndsAtWater = -1;
constexpr int kEndsNowhere = -2;

/// A straight piece of a light path outside glass, after one specular event at least.
struct PathLeg {
    glm::dvec3 start;             ///< m, relative to FrameScene::origin
    glm::dvec3 direction;         ///< unit, of travel
    double length = 0;            ///< m, to its end
    glm::dvec3 throughput;        ///< where it starts, of the light that set out towards the first surface
    std::uint64_t signature = 0;  ///< of all surfaces (of boxes: faces) and events up to here; never 0
    int end = kEndsNowhere;
    bool in_water = false;
};

/// Light that took one event at the first surface, and what became of it.
struct LightPath {
    struct Loss {
        Cause cause;
        std::size_t leg;  ///< before which it is lost
        glm::dvec3 amount;
    };
    glm::dvec3 entry{0};  ///< share of the light that takes the event, if nothing dimmed it before
    std::vector<PathLeg> legs;
    /// What is missing from the throughput of leg k against that of leg k - 1 (k = 0: `entry`); where leg
    /// k - 1 ends at a specular surface and there is no leg k, all of it.
    std::vector<Loss> losses;
};

/// What one ray of a light met.
struct VertexPaths {
    bool on_body = false;            ///< the first surface is the body of the view, met from the light's side
    int surface = kEndsNowhere;      ///< what it met first, as PathLeg::end
    glm::dvec3 position{0};          ///< m, of the first surface
    glm::dvec3 normal{0};            ///< unit, towards the light
    double distance = 0;             ///< m, from the start of the light's ray; infinite where nothing is met
    double falloff = 1;              ///< of a spot, but for its picture
    double picture = 1;              ///< LightView::picture_brightness()
    bool merged = false;             ///< it meets the mean of waves about it, as merge_waves() has it
    std::array<LightPath, 2> paths;  ///< by light::Event
};

/// A texel of the light's view: Liktor and Dachsbacher's geometry buffer (4.1). It is traced rather than
/// rasterised: exact for spheres too, and on a device without a rasteriser of its own no dearer.
struct SurfaceTexel {
    glm::vec3 normal{0};   ///< unit, towards the light; 0 where the body is not met
    bool on_body = false;  ///< as VertexPaths
    glm::vec2 entry{0};    ///< LightPath::entry by light::Event
    float light = 1;       ///< of a spot: falloff times the brightness of its picture
};

/// Follows rays of a light through chains of specular events: at the first surface both events, inside glass
/// from surface to surface, at later surfaces what goes through. In double; the tracer's floats only say
/// which primitive is met. Thread-safe.
class PathTracer {
public:
    /// `events`: bit light::Event is set for those that are asked for at the first surface. `index_shift` is
    /// added to the water's refractive index.
    PathTracer(const scene::FrameScene& scene, const rays::RayScene& rays, const media::Media& media,
               const LightView& view, int body, unsigned events, double index_shift = 0);

    /// The object of glass that the lamp lies in, or kEndsNowhere.
    int lamp_inside() const { return lamp_inside_; }
    const LightView& view() const { return view_; }

    /// Whether a beam of these legs, which end alike, may light anything that can be seen: where they meet
    /// nothing, it may pass all objects and media, those that lie between its rays too.
    bool lights(const std::array<const PathLeg*, 3>& legs) const;

    /// What rays met, an entry a (u, v); on all threads.
    void trace(std::span<const glm::dvec2> uv, std::span<VertexPaths> vertices) const;
    /// The same, as if the surface that is met first had these unit normals (towards the light) there.
    void trace(std::span<const glm::dvec2> uv, std::span<const glm::dvec3> normals,
               std::span<VertexPaths> vertices) const;
    /// The first surfaces only, `side` x `side` rays through the middles of equal parts of the view, row by
    /// row.
    std::vector<SurfaceTexel> first_surfaces(int side) const;
    /// LightPath::entry times the falloff, by light::Event, of each ray; 0 where the body is not met.
    std::vector<glm::dvec2> entries(std::span<const glm::dvec2> uv) const;

private:
    struct Way;
    struct Meeting;
    void trace_tile(std::span<const glm::dvec2> uv, std::span<const glm::dvec3> normals,
                    std::span<VertexPaths> vertices, bool follow) const;
    void meet(std::span<const Way> ways, std::vector<Meeting>& meetings) const;
    float water_before(const Way& way, const rays::Hit& object) const;
    void start(std::size_t vertex, const Way& way, const Meeting& meeting, VertexPaths& record,
               std::vector<Way>* next) const;
    void go_on(const Way& way, const Meeting& meeting, VertexPaths& record, std::vector<Way>& next) const;
    void leave_glass(Way way, const Meeting& meeting, LightPath& path, std::vector<Way>& next) const;
    void enter(Way way, const Meeting& meeting, const glm::dvec3& throughput, LightPath& path,
               std::vector<Way>& next) const;
    void go_through(Way way, const Meeting& meeting, double index_ratio, Cause reflection, LightPath& path,
                    std::vector<Way>& next) const;
    bool water_outside(const view::SurfacePoint& point) const;
    bool is_glass(std::uint32_t object) const;
    double past_objects(const glm::dvec3& start, const glm::dvec3& direction) const;
    double cut(const glm::dvec3& start, const glm::dvec3& direction, bool in_water) const;
    std::uint64_t surface_id(const Meeting& meeting) const;
    double index_outside(bool in_water) const;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const media::Media& media_;
    const LightView& view_;
    int body_;
    unsigned events_;
    double index_shift_;
    int lamp_inside_ = kEndsNowhere;
    bool lamp_in_water_ = false;
    view::SurfaceGeometry geometry_;
    glm::dvec3 lower_{std::numeric_limits<double>::infinity()};  ///< m, of all that can be lit
    glm::dvec3 upper_{-std::numeric_limits<double>::infinity()};
    double farthest_in_water_ = 0;  ///< m, that light in the water is followed for the camera's sake
};

}  // namespace dapple::methods::adaptive_beams
