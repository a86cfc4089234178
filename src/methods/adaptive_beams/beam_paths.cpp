#include "methods/adaptive_beams/beam_paths.h"

#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "base/parallel.h"
#include "media/ray_box.h"
#include "methods/adaptive_beams/box_reach.h"
#include "view/camera_medium.h"
#include "view/crossing.h"
#include "view/glass_bodies.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kTile = 512;  // rays that are traced together
/// Optical depth at which light in the water is followed no farther: 6e-6 of it are left.
constexpr double kFadedDepth = 12;

/// Never 0, which stands for no path.
std::uint64_t hash64(std::uint64_t a, std::uint64_t b) {
    return static_cast<std::uint64_t>(hash_bits(a, b, 0, 0)) << 32 | hash_bits(a, b, 0, 1) | 1;
}

double mean(const glm::dvec3& v) {
    return (v.x + v.y + v.z) / 3;
}

void grow(glm::dvec3& lower, glm::dvec3& upper, const glm::dvec3& point) {
    lower = glm::min(lower, point);
    upper = glm::max(upper, point);
}

}  // namespace

const char* loss_name(Cause cause) {
    constexpr std::array<const char*, kCauses> names = {
        "lost to media before the surface, W",
        "lost to absorption in glass, W",
        "lost to reflection inside glass, W",
        "lost to total reflection, W",
        "lost to reflection at later surfaces, W",
        "lost inside glass, W",
        "lost after too many surfaces, W",
        "lost at silhouettes, W",
        "lost outside cones, W",
        "lost in weak beams, W",
        "lost beyond the scene, W",
    };
    return names[static_cast<std::size_t>(cause)];
}

/// A ray under way.
struct PathTracer::Way {
    std::size_t vertex = 0;
    light::Event event = light::Event::transmission;
    glm::dvec3 origin{0}, direction{0};
    glm::dvec3 start{0};        // where it is traced from: `origin`, lifted off the surface that was left
    double near = 0;            // m: the tracer's floats may put a point at an edge beyond the next face
    int inside = kEndsNowhere;  // the object of glass that it travels in
    bool in_water = false;      // outside glass
    glm::dvec3 throughput{1};
    std::uint64_t signature = 0;

    /// Leaves a surface, on the side that it came from or the other.
    void leave(const view::SurfacePoint& point, const view::Crossing& crossing, bool through) {
        origin = point.position;
        direction = glm::normalize(through ? crossing.refracted : crossing.reflected);
        start = view::lifted(origin, (through ? -1.0 : 1.0) * crossing.normals.geometric);
        near = view::surface_margin(origin);
    }
};

struct PathTracer::Meeting {
    enum class Kind { nothing, object, water } kind = Kind::nothing;
    rays::Hit hit;
    view::SurfacePoint point;
};

PathTracer::PathTracer(const scene::FrameScene& scene, const rays::RayScene& rays, const media::Media& media,
                       const LightView& view, int body, unsigned events, double index_shift)
    : scene_(scene),
      rays_(rays),
      media_(media),
      view_(view),
      body_(body),
      events_(events),
      index_shift_(index_shift),
      geometry_(scene) {
    if (!view.parallel()) {
        const glm::dvec3 lamp = view.ray({0, 0}).origin;
        const std::uint32_t holds = view::GlassBodies(scene).at(lamp);
        if (holds != view::kNoBody) {
            lamp_inside_ = static_cast<int>(holds);
        } else {
            // At the water a lamp is above or below the rest plane, as light::water_beams has it.
            lamp_in_water_ =
                body == light::kWater ? view.from_below() : view::point_in_water(scene, rays, lamp);
        }
    }
    if (rays.has_objects()) {
        glm::vec3 lower, upper;
        rays.object_bounds(lower, upper);
        grow(lower_, upper_, lower);
        grow(lower_, upper_, upper);
    }
    const auto& components = media.components();
    if (!components.empty() && mean(components[0].scattering) > 0) {
        // The water itself is seen wherever there is light in it: as far as light lasts, and no farther
        // than several times the size of the scene and the camera's distance.
        glm::dvec3 lower = lower_, upper = upper_;
        grow(lower, upper, scene.state.camera.position - scene.origin);
        if (scene.water)
            for (const glm::dvec3& p : scene.water->mesh.positions)
                if (glm::dot(p, p) < kInfinity) grow(lower, upper, p - scene.origin);
        const glm::dvec3& extinction = components[0].extinction;
        const double least = std::min({extinction.x, extinction.y, extinction.z});
        farthest_in_water_ = std::min(kFadedDepth / least, 4 * glm::length(upper - lower));
    }
}

std::uint64_t PathTracer::surface_id(const Meeting& meeting) const {
    if (meeting.kind == Meeting::Kind::water) return 1;
    const std::uint64_t object = meeting.hit.object;
    const bool box = scene_.state.objects[meeting.hit.object].shape == scene::Shape::box;
    return 2 + object * 8 + (box ? 1 + meeting.hit.primitive / 2 : 0);
}

double PathTracer::index_outside(bool in_water) const {
    return in_water && scene_.state.water ? scene_.state.water->refractive_index + index_shift_ : 1;
}

/// Whether what lies about a body where light leaves it is water.
bool PathTracer::water_outside(const view::SurfacePoint& point) const {
    return view::point_in_water(scene_, rays_, view::lifted(point.position, point.geometric_normal));
}

bool PathTracer::is_glass(std::uint32_t object) const {
    return object != rays::kNoHit && scene_.state.objects[object].material.glass;
}

/// m: where a ray leaves the bounds of all objects; 0: it does not pass them.
double PathTracer::past_objects(const glm::dvec3& start, const glm::dvec3& direction) const {
    const media::Interval inside = media::inside_box({start, direction}, lower_, upper_, {0, kInfinity});
    return inside.empty() || inside.end == kInfinity ? 0 : inside.end;
}

/// m: where a leg that meets nothing ends. Past it nothing is lit, and nothing scatters that could be seen:
/// not between rays of one beam either, so that all go by a medium that one of them may miss.
double PathTracer::cut(const glm::dvec3& start, const glm::dvec3& direction, bool in_water) const {
    double end = past_objects(start, direction);
    for (const media::Part& part : media_.parts())
        if (part.on(in_water)) end = std::max(end, farthest_corner(part.body.place(), start));
    return in_water ? std::max(end, farthest_in_water_) : end;
}

bool PathTracer::lights(const std::array<const PathLeg*, 3>& legs) const {
    std::array<glm::dvec3, 6> corners;
    glm::dvec3 way(0);
    for (std::size_t k = 0; k < 3; ++k) {
        const PathLeg& leg = *legs[k];
        if (leg.end != kEndsNowhere ? leg.length > 0 : past_objects(leg.start, leg.direction) > 0)
            return true;
        if (leg.in_water && farthest_in_water_ > 0) return true;
        corners[k] = leg.start;
        corners[3 + k] = leg.start + leg.length * leg.direction;
        way += leg.direction;
    }
    const std::vector<media::Part>& parts = media_.parts();
    return std::any_of(parts.begin(), parts.end(), [&](const media::Part& part) {
        return part.on(legs[0]->in_water) && may_meet(part.body.place(), corners, way);
    });
}

/// How far a way may meet the water: not at all within glass (-1). Where the water and a face of glass meet,
/// the body counts: there is no film of water.
float PathTracer::water_before(const Way& way, const rays::Hit& object) const {
    if (way.inside >= 0) return -1;
    if (!is_glass(object.object)) return object.distance;
    const auto distance = static_cast<double>(object.distance);
    return static_cast<float>(distance - 2 * view::surface_margin(way.start + distance * way.direction));
}

void PathTracer::meet(std::span<const Way> ways, std::vector<Meeting>& meetings) const {
    std::vector<rays::Ray> rays(ways.size());
    std::vector<rays::Hit> objects(ways.size()), water(ways.size());
    for (std::size_t i = 0; i < ways.size(); ++i) {
        rays[i].origin = glm::vec3(ways[i].start);
        rays[i].direction = glm::vec3(ways[i].direction);
        rays[i].near = static_cast<float>(ways[i].near);
    }
    rays_.intersect_objects(rays, objects);
    if (scene_.water) {
        for (std::size_t i = 0; i < ways.size(); ++i) rays[i].far = water_before(ways[i], objects[i]);
        rays_.intersect_water(rays, water);
    }
    meetings.assign(ways.size(), Meeting{});
    for (std::size_t i = 0; i < ways.size(); ++i) {
        Meeting& meeting = meetings[i];
        const Way& way = ways[i];
        if (water[i].primitive != rays::kNoHit) {
            meeting.kind = Meeting::Kind::water;
            meeting.hit = water[i];
            meeting.point = geometry_.water_point(meeting.hit, way.origin, way.direction);
        } else if (objects[i].primitive != rays::kNoHit) {
            meeting.kind = Meeting::Kind::object;
            meeting.hit = objects[i];
            meeting.point = geometry_.object_point(meeting.hit, way.origin, way.direction);
        }
    }
}

void PathTracer::start(std::size_t vertex, const Way& way, const Meeting& meeting, VertexPaths& record,
                       std::vector<Way>* next) const {
    record.distance = kInfinity;
    if (meeting.kind == Meeting::Kind::nothing) return;
    const bool water = meeting.kind == Meeting::Kind::water;
    const bool inwards = glm::dot(way.direction, meeting.point.geometric_normal) < 0;
    const auto object = static_cast<int>(meeting.hit.object);
    // From the side where the light is; of glass that may be the inside.
    const bool from_light = water ? inwards != way.in_water : inwards == (object != way.inside);
    record.surface = water ? kEndsAtWater : object;
    record.position = meeting.point.position;
    record.distance = meeting.point.distance;
    record.normal = (inwards ? 1.0 : -1.0) * meeting.point.shading_normal;
    // Light of a lamp within another body meets nothing before that one.
    const bool enclosed = way.inside >= 0 && object != way.inside;
    record.on_body = (water ? light::kWater : object) == body_ && from_light && !enclosed;
    if (!record.on_body) return;

    const bool leaves_glass = way.inside >= 0;
    const bool beyond_in_water = leaves_glass ? water_outside(meeting.point) : water && !way.in_water;
    const auto index = [&](bool glass, bool in_water) {
        return glass ? scene_.state.objects[meeting.hit.object].material.refractive_index
                     : index_outside(in_water);
    };
    const view::Crossing crossing(
        way.direction, meeting.point,
        index(leaves_glass, way.in_water) / index(!water && !leaves_glass, beyond_in_water));
    double length = record.distance;
    if (view_.parallel()) length = kInfinity;
    const glm::dvec3 arriving =
        leaves_glass ? glm::exp(-length * scene_.state.objects[meeting.hit.object].material.absorption)
                     : glm::exp(-media_.optical_depth(record.position, -way.direction, length, way.in_water));
    for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
        if ((events_ >> static_cast<unsigned>(event) & 1) == 0) continue;
        const bool through = event == light::Event::transmission;
        const double share = through ? crossing.transmittance : crossing.reflectance;
        LightPath& path = record.paths[static_cast<std::size_t>(event)];
        path.entry = glm::dvec3(share);
        if (!(share > 0) || next == nullptr) continue;
        if (arriving != glm::dvec3(1))
            path.losses.push_back(
                {leaves_glass ? Cause::glass_absorption : Cause::media, 0, share * (1.0 - arriving)});
        Way out = way;
        out.vertex = vertex;
        out.event = event;
        out.leave(meeting.point, crossing, through);
        out.throughput = share * arriving;
        out.signature = hash64(surface_id(meeting), through ? 0 : 1);
        if (through) {
            out.inside = water || leaves_glass ? kEndsNowhere : object;
            out.in_water = beyond_in_water;
        }
        next->push_back(out);
    }
}

/// `way` ends inside its body at `meeting`.
void PathTracer::leave_glass(Way way, const Meeting& meeting, LightPath& path, std::vector<Way>& next) const {
    const std::size_t leg = path.legs.size();
    const bool own = meeting.kind == Meeting::Kind::object &&
                     static_cast<int>(meeting.hit.object) == way.inside &&
                     glm::dot(way.direction, meeting.point.geometric_normal) > 0;
    if (!own) {
        path.losses.push_back({Cause::inside_glass, leg, way.throughput});
        return;
    }
    const scene::Material& glass = scene_.state.objects[meeting.hit.object].material;
    const glm::dvec3 left = way.throughput * glm::exp(-glass.absorption * meeting.point.distance);
    if (left != way.throughput) path.losses.push_back({Cause::glass_absorption, leg, way.throughput - left});
    way.inside = kEndsNowhere;
    way.in_water = water_outside(meeting.point);
    way.throughput = left;
    go_through(way, meeting, glass.refractive_index / index_outside(way.in_water), Cause::glass_reflection,
               path, next);
}

/// Takes a way through the surface that it met; its throughput is still that before. `index_ratio`: of the
/// side that it comes from to the other.
void PathTracer::go_through(Way way, const Meeting& meeting, double index_ratio, Cause reflection,
                            LightPath& path, std::vector<Way>& next) const {
    const view::Crossing crossing(way.direction, meeting.point, index_ratio);
    const bool total = !(crossing.transmittance > 0);
    path.losses.push_back({total ? Cause::total_reflection : reflection, path.legs.size(),
                           way.throughput * crossing.reflectance});
    if (total) return;
    way.signature = hash64(way.signature, surface_id(meeting));
    way.leave(meeting.point, crossing, true);
    way.throughput *= crossing.transmittance;
    next.push_back(way);
}

/// The leg that was pushed last ends at a specular surface, where what is left of it is `throughput`.
void PathTracer::enter(Way way, const Meeting& meeting, const glm::dvec3& throughput, LightPath& path,
                       std::vector<Way>& next) const {
    const std::size_t leg = path.legs.size();
    if (leg == kMostLegs) {
        path.losses.push_back({Cause::too_many_surfaces, leg, throughput});
        return;
    }
    const bool water = meeting.kind == Meeting::Kind::water;
    double outer = index_outside(way.in_water), inner = 0;
    if (water) {
        const bool from_air = glm::dot(way.direction, meeting.point.geometric_normal) <= 0;
        outer = index_outside(!from_air);
        inner = index_outside(from_air);
        way.in_water = from_air;
    } else {
        inner = scene_.state.objects[meeting.hit.object].material.refractive_index;
        way.inside = static_cast<int>(meeting.hit.object);
    }
    way.throughput = throughput;
    go_through(way, meeting, outer / inner, Cause::later_reflection, path, next);
}

void PathTracer::go_on(const Way& way, const Meeting& meeting, VertexPaths& record,
                       std::vector<Way>& next) const {
    LightPath& path = record.paths[static_cast<std::size_t>(way.event)];
    if (way.inside >= 0) {
        leave_glass(way, meeting, path, next);
        return;
    }
    PathLeg leg;
    leg.start = way.origin;
    leg.direction = way.direction;
    leg.throughput = way.throughput;
    leg.signature = way.signature;
    leg.in_water = way.in_water;
    if (meeting.kind == Meeting::Kind::nothing) {
        leg.length = cut(way.origin, way.direction, way.in_water);
        path.legs.push_back(leg);
        return;
    }
    const bool water = meeting.kind == Meeting::Kind::water;
    leg.length = std::max(0.0, meeting.point.distance);
    leg.end = water ? kEndsAtWater : static_cast<int>(meeting.hit.object);
    path.legs.push_back(leg);
    // A body that is met from inside is none: it is open, or others overlap it.
    const bool enters = water || (is_glass(meeting.hit.object) &&
                                  glm::dot(way.direction, meeting.point.geometric_normal) < 0);
    if (!enters) return;
    const glm::dvec3 left =
        way.throughput * glm::exp(-media_.optical_depth(way.origin, way.direction, leg.length, way.in_water));
    if (left != way.throughput)
        path.losses.push_back({Cause::media, path.legs.size(), way.throughput - left});
    enter(way, meeting, left, path, next);
}

void PathTracer::trace_tile(std::span<const glm::dvec2> uv, std::span<const glm::dvec3> normals,
                            std::span<VertexPaths> vertices, bool follow) const {
    std::vector<Way> ways(uv.size()), next;
    std::vector<Meeting> meetings;
    for (std::size_t i = 0; i < uv.size(); ++i) {
        const LightRay ray = view_.ray(uv[i]);
        ways[i].vertex = i;
        ways[i].origin = ways[i].start = ray.origin;
        ways[i].direction = ray.direction;
        ways[i].inside = lamp_inside_;
        ways[i].in_water = lamp_in_water_;
        vertices[i] = VertexPaths{};
        vertices[i].falloff = view_.falloff(uv[i]);
        if (view_.textured()) vertices[i].picture = view_.picture_brightness(uv[i], 0);
    }
    meet(ways, meetings);
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const bool inwards = glm::dot(ways[i].direction, meetings[i].point.geometric_normal) < 0;
        meetings[i].point.shading_normal = (inwards ? 1.0 : -1.0) * normals[i];
    }
    for (std::size_t i = 0; i < uv.size(); ++i)
        start(i, ways[i], meetings[i], vertices[i], follow ? &next : nullptr);
    while (!next.empty()) {
        ways.swap(next);
        next.clear();
        meet(ways, meetings);
        for (std::size_t i = 0; i < ways.size(); ++i)
            go_on(ways[i], meetings[i], vertices[ways[i].vertex], next);
    }
}

void PathTracer::trace(std::span<const glm::dvec2> uv, std::span<VertexPaths> vertices) const {
    parallel_for(uv.size(), kTile, [&](std::size_t begin, std::size_t end) {
        trace_tile(uv.subspan(begin, end - begin), {}, vertices.subspan(begin, end - begin), true);
    });
}

void PathTracer::trace(std::span<const glm::dvec2> uv, std::span<const glm::dvec3> normals,
                       std::span<VertexPaths> vertices) const {
    parallel_for(uv.size(), kTile, [&](std::size_t begin, std::size_t end) {
        const std::size_t count = end - begin;
        trace_tile(uv.subspan(begin, count), normals.subspan(begin, count), vertices.subspan(begin, count),
                   true);
    });
}

std::vector<SurfaceTexel> PathTracer::first_surfaces(int side) const {
    const auto columns = static_cast<std::size_t>(side);
    std::vector<SurfaceTexel> texels(columns * columns);
    parallel_for(texels.size(), kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<glm::dvec2> uv;
        for (std::size_t i = begin; i < end; ++i)
            uv.push_back((glm::dvec2(i % columns, i / columns) + 0.5) / static_cast<double>(side));
        std::vector<VertexPaths> found(uv.size());
        trace_tile(uv, {}, found, false);
        for (std::size_t i = begin; i < end; ++i) {
            const VertexPaths& at = found[i - begin];
            if (!at.on_body) continue;
            texels[i] = {glm::vec3(at.normal), true, {at.paths[0].entry.x, at.paths[1].entry.x}};
            if (view_.textured())
                texels[i].light = static_cast<float>(
                    at.falloff * view_.picture_brightness(uv[i - begin], 1 / static_cast<double>(side)));
        }
    });
    return texels;
}

std::vector<glm::dvec2> PathTracer::entries(std::span<const glm::dvec2> uv) const {
    std::vector<glm::dvec2> entries(uv.size());
    parallel_for(uv.size(), kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<VertexPaths> found(end - begin);
        trace_tile(uv.subspan(begin, end - begin), {}, found, false);
        for (std::size_t i = begin; i < end; ++i) {
            const VertexPaths& at = found[i - begin];
            entries[i] = at.falloff * glm::dvec2(at.paths[0].entry.x, at.paths[1].entry.x);
        }
    });
    return entries;
}

}  // namespace dapple::methods::adaptive_beams
