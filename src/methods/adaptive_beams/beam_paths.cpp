#include "methods/adaptive_beams/beam_paths.h"

#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "base/parallel.h"
#include "optics/optics.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kTile = 512;  // rays that are traced together
/// Optical depth at which light in the water is followed no farther: 6e-6 of it are left.
constexpr double kFadedDepth = 12;

/// m: what the tracer's floats can tell two surfaces apart by, with room.
double margin(const glm::dvec3& p) {
    return 0x1p-21 * (1 + std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}));
}

/// Never 0, which stands for no path.
std::uint64_t hash64(std::uint64_t a, std::uint64_t b) {
    return static_cast<std::uint64_t>(hash_bits(a, b, 0, 0)) << 32 | hash_bits(a, b, 0, 1) | 1;
}

/// Margins within which a ray that leaves a surface may meet that again, from the side where it is not.
constexpr double kGrazingMargins = 64;

double mean(const glm::dvec3& v) {
    return (v.x + v.y + v.z) / 3;
}

/// What a smooth dielectric surface does to a ray.
struct Crossing {
    glm::dvec3 refracted{0}, reflected{0};
    double transmittance = 0, reflectance = 1;  ///< 0 and 1 at total reflection
};

/// `eta`: index on the side that the ray comes from over that on the other. Where an interpolated normal
/// would send the ray to the wrong side of its triangle, the triangle's own is taken.
Crossing cross(const glm::dvec3& direction, const view::SurfacePoint& point, double eta) {
    using namespace optics::f64;
    const double side = glm::dot(direction, point.geometric_normal) <= 0 ? 1 : -1;
    const glm::dvec3 geometric = side * point.geometric_normal;
    Crossing crossing;
    bool transmits = false;
    double cos_i = 0;
    const auto try_normal = [&](const glm::dvec3& normal) {
        cos_i = -glm::dot(direction, normal);
        transmits = refracted_direction(direction, normal, eta, crossing.refracted);
        crossing.reflected = reflected_direction(direction, normal);
        return cos_i > 0 && glm::dot(crossing.reflected, geometric) > 0 &&
               (!transmits || glm::dot(crossing.refracted, geometric) < 0);
    };
    if (!try_normal(side * point.shading_normal)) try_normal(geometric);
    cos_i = std::clamp(cos_i, 0.0, 1.0);
    const double cos_t = transmitted_cosine(cos_i, eta);
    crossing.transmittance = transmits ? fresnel_transmittance(cos_i, cos_t, eta) : 0;
    crossing.reflectance = transmits ? fresnel_reflectance(cos_i, cos_t, eta) : 1;
    return crossing;
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
    double near = 0;
    int inside = kEndsNowhere;  // the object of glass that it travels in
    bool in_water = false;      // outside glass
    glm::dvec3 throughput{1};
    std::uint64_t signature = 0;
};

struct PathTracer::Meeting {
    enum class Kind { nothing, object, water } kind = Kind::nothing;
    rays::Hit hit;
    view::SurfacePoint point;
};

PathTracer::PathTracer(const scene::FrameScene& scene, const rays::RayScene& rays, const media::Media& media,
                       const LightView& view, int body, unsigned events)
    : scene_(scene), rays_(rays), media_(media), view_(view), body_(body), events_(events), geometry_(scene) {
    if (rays.has_objects()) {
        glm::vec3 lower, upper;
        rays.object_bounds(lower, upper);
        grow(lower_, upper_, lower);
        grow(lower_, upper_, upper);
    }
    for (std::size_t i = 0; i < scene.state.media.size(); ++i)
        if (!media::Body::is_empty(scene, i)) bodies_.emplace_back(scene, i);
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
    return in_water && scene_.state.water ? scene_.state.water->refractive_index : 1;
}

/// Whether the point is under the water's mesh, seen straight up; beside the mesh, whether it is under the
/// rest plane of open water.
bool PathTracer::water_above(const glm::dvec3& point) const {
    if (!scene_.water) return false;
    rays::Ray up;
    up.origin = glm::vec3(point);
    up.direction = {0, 1, 0};
    rays::Hit hit;
    rays_.intersect_water({&up, 1}, {&hit, 1});
    if (hit.primitive != rays::kNoHit) return hit.normal.y > 0;
    const glm::dvec3 world = point + scene_.origin;
    const scene::Extent& extent = scene_.state.water->extent;
    const bool beside = std::abs(world.x - extent.center.x) > 0.5 * extent.size.x ||
                        std::abs(world.z - extent.center.y) > 0.5 * extent.size.y;
    return extent.kind == scene::ExtentKind::open_water && beside && world.y < 0;
}

/// m: where a leg that meets nothing ends. Past it nothing is lit, and nothing scatters that could be seen.
double PathTracer::cut(const glm::dvec3& start, const glm::dvec3& direction, bool in_water) const {
    double first = 0, last = kInfinity;
    for (int i = 0; i < 3; ++i) {
        const double a = (lower_[i] - start[i]) / direction[i], b = (upper_[i] - start[i]) / direction[i];
        if (direction[i] == 0) {
            if (start[i] < lower_[i] || start[i] > upper_[i]) last = 0;
            continue;
        }
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
    }
    double end = last > first && last < kInfinity ? last : 0;
    for (const media::Body& body : bodies_) {
        const media::Interval overlap = body.overlap(start, direction, kInfinity);
        if (!overlap.empty()) end = std::max(end, overlap.end);
    }
    return in_water ? std::max(end, farthest_in_water_) : end;
}

void PathTracer::meet(std::span<const Way> ways, std::vector<Meeting>& meetings) const {
    std::vector<rays::Ray> rays(ways.size());
    std::vector<rays::Hit> objects(ways.size()), water(ways.size());
    for (std::size_t i = 0; i < ways.size(); ++i) {
        rays[i].origin = glm::vec3(ways[i].origin);
        rays[i].direction = glm::vec3(ways[i].direction);
        rays[i].near = static_cast<float>(ways[i].near);
    }
    rays_.intersect_objects(rays, objects);
    if (scene_.water) {
        for (std::size_t i = 0; i < ways.size(); ++i) {
            rays[i].far = objects[i].distance;
            // Within glass there is no water.
            if (ways[i].inside >= 0) rays[i].far = -1;
        }
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
    leave_start(ways, meetings);
}

/// Looks again for those that met but the surface that they leave, from the other side: what floats round at
/// grazing angles.
void PathTracer::leave_start(std::span<const Way> ways, std::vector<Meeting>& meetings) const {
    std::vector<Way> again;
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < ways.size(); ++i) {
        const Way& way = ways[i];
        const Meeting& meeting = meetings[i];
        if (way.near == 0 || meeting.kind == Meeting::Kind::nothing) continue;
        // By `near` too, which grows each time: so it comes to an end whatever the distance is.
        if (std::max(way.near, meeting.point.distance) > kGrazingMargins * margin(way.origin)) continue;
        const bool inwards = glm::dot(way.direction, meeting.point.geometric_normal) < 0;
        const bool wrong = meeting.kind == Meeting::Kind::water
                               ? inwards == way.in_water
                               : inwards == (static_cast<int>(meeting.hit.object) == way.inside) &&
                                     scene_.state.objects[meeting.hit.object].material.glass;
        if (!wrong) continue;
        again.push_back(way);
        again.back().near = std::max(way.near, meeting.point.distance) + margin(way.origin);
        which.push_back(i);
    }
    if (again.empty()) return;
    std::vector<Meeting> found;
    meet(again, found);
    for (std::size_t i = 0; i < which.size(); ++i) meetings[which[i]] = found[i];
}

void PathTracer::start(std::size_t vertex, const Way& way, const Meeting& meeting, VertexPaths& record,
                       std::vector<Way>* next) const {
    record.distance = kInfinity;
    if (meeting.kind == Meeting::Kind::nothing) return;
    const bool water = meeting.kind == Meeting::Kind::water;
    const bool outside = water ? (glm::dot(way.direction, meeting.point.geometric_normal) < 0) != way.in_water
                               : glm::dot(way.direction, meeting.point.geometric_normal) < 0;
    record.surface = water ? kEndsAtWater : static_cast<int>(meeting.hit.object);
    record.position = meeting.point.position;
    record.distance = meeting.point.distance;
    const double side = glm::dot(way.direction, meeting.point.geometric_normal) <= 0 ? 1 : -1;
    record.normal = side * meeting.point.shading_normal;
    const int body = water ? light::kWater : static_cast<int>(meeting.hit.object);
    record.on_body = body == body_ && outside;
    if (!record.on_body || next == nullptr) return;

    const double outer = index_outside(way.in_water);
    double inner = index_outside(!way.in_water);
    if (!water) inner = scene_.state.objects[meeting.hit.object].material.refractive_index;
    const Crossing crossing = cross(way.direction, meeting.point, outer / inner);
    double length = record.distance;
    if (view_.parallel()) length = kInfinity;
    const glm::dvec3 arriving =
        glm::exp(-media_.optical_depth(record.position, -way.direction, length, way.in_water));
    for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
        if ((events_ >> static_cast<unsigned>(event) & 1) == 0) continue;
        const bool through = event == light::Event::transmission;
        const double share = through ? crossing.transmittance : crossing.reflectance;
        LightPath& path = record.paths[static_cast<std::size_t>(event)];
        path.entry = glm::dvec3(share);
        if (!(share > 0)) continue;
        if (arriving != glm::dvec3(1)) path.losses.push_back({Cause::media, 0, share * (1.0 - arriving)});
        Way out = way;
        out.vertex = vertex;
        out.event = event;
        out.origin = record.position;
        out.near = margin(out.origin);
        out.direction = through ? glm::normalize(crossing.refracted) : glm::normalize(crossing.reflected);
        out.throughput = share * arriving;
        out.signature = hash64(surface_id(meeting), through ? 0 : 1);
        if (through && water) out.in_water = !way.in_water;
        if (through && !water) out.inside = static_cast<int>(meeting.hit.object);
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
    const bool in_water = water_above(meeting.point.position);
    const Crossing crossing =
        cross(way.direction, meeting.point, glass.refractive_index / index_outside(in_water));
    const bool total = !(crossing.transmittance > 0);
    path.losses.push_back(
        {total ? Cause::total_reflection : Cause::glass_reflection, leg, left * crossing.reflectance});
    if (total) return;
    way.signature = hash64(way.signature, surface_id(meeting));
    way.origin = meeting.point.position;
    way.near = margin(way.origin);
    way.direction = glm::normalize(crossing.refracted);
    way.throughput = left * crossing.transmittance;
    way.inside = kEndsNowhere;
    way.in_water = in_water;
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
    const Crossing crossing = cross(way.direction, meeting.point, outer / inner);
    const bool total = !(crossing.transmittance > 0);
    path.losses.push_back(
        {total ? Cause::total_reflection : Cause::later_reflection, leg, throughput * crossing.reflectance});
    if (total) return;
    way.signature = hash64(way.signature, surface_id(meeting));
    way.origin = meeting.point.position;
    way.near = margin(way.origin);
    way.direction = glm::normalize(crossing.refracted);
    way.throughput = throughput * crossing.transmittance;
    next.push_back(way);
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
    leg.length = meeting.point.distance;
    leg.end = water ? kEndsAtWater : static_cast<int>(meeting.hit.object);
    path.legs.push_back(leg);
    // A body that is met from inside is none: it is open, or others overlap it.
    const bool enters = water || (scene_.state.objects[meeting.hit.object].material.glass &&
                                  glm::dot(way.direction, meeting.point.geometric_normal) < 0);
    if (!enters) return;
    const glm::dvec3 left =
        way.throughput * glm::exp(-media_.optical_depth(way.origin, way.direction, leg.length, way.in_water));
    if (left != way.throughput)
        path.losses.push_back({Cause::media, path.legs.size(), way.throughput - left});
    enter(way, meeting, left, path, next);
}

void PathTracer::trace_tile(std::span<const glm::dvec2> uv, std::span<VertexPaths> vertices,
                            bool follow) const {
    std::vector<Way> ways(uv.size()), next;
    std::vector<Meeting> meetings;
    for (std::size_t i = 0; i < uv.size(); ++i) {
        const LightRay ray = view_.ray(uv[i]);
        ways[i].vertex = i;
        ways[i].origin = ray.origin;
        ways[i].direction = ray.direction;
        ways[i].in_water = view_.from_below();
        vertices[i] = VertexPaths{};
        vertices[i].falloff = view_.falloff(uv[i]);
    }
    meet(ways, meetings);
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
        trace_tile(uv.subspan(begin, end - begin), vertices.subspan(begin, end - begin), true);
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
        trace_tile(uv, found, false);
        for (std::size_t i = begin; i < end; ++i) {
            const VertexPaths& at = found[i - begin];
            if (at.on_body) texels[i] = {glm::vec3(at.normal), true};
        }
    });
    return texels;
}

}  // namespace dapple::methods::adaptive_beams
