#include "view/camera_paths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "optics/optics.h"
#include "view/camera.h"
#include "view/camera_medium.h"
#include "view/surface_point.h"

namespace dapple::view {
namespace {

/// Pixels are traced in tiles, breadth first, so that packets hold neighbours: 4 x 2 pixels each.
constexpr int kTileSize = 16;
constexpr int kPacketWidth = 4;
constexpr int kPacketHeight = 2;

/// A footprint is at most this many times as long as its beam is wide: nearer than a degree to grazing it
/// says nothing of the pixel any more.
constexpr double kLongestAspect = 64;

/// A path on its way, in double; positions relative to the frame's origin.
struct Path {
    std::size_t pixel = 0;
    glm::dvec3 origin{0};
    glm::dvec3 direction{0};                                                  ///< unit
    glm::dvec3 origin_du{0}, origin_dv{0}, direction_du{0}, direction_dv{0};  ///< by pixel x and y
    glm::dvec3 throughput{1};
    glm::dvec3 start{0};     ///< where rays are traced from: `origin`, lifted off the surface that was left
    double pixel_width = 0;  ///< m, of the beam at the camera
    double length = 0;       ///< m, of the way so far
    int events = 0;
    bool in_water = false;
    bool split = false;
    bool left_rest_plane = false;
};

/// The nearest thing on a path's way.
struct Encounter {
    enum class Kind { nothing, object, water_mesh, rest_plane } kind = Kind::nothing;
    rays::Hit hit;
    double distance = 0;  ///< of the rest plane
};

double mean(const glm::dvec3& color) {
    return (color.x + color.y + color.z) / 3;
}

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

class LayerTracer {
public:
    LayerTracer(const scene::FrameScene& scene, const rays::RayScene& rays, LayerRequest request,
                ReceiverLayer& layer);

    std::size_t tiles() const {
        return static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(tiles_down_);
    }
    void trace_tile(std::size_t tile, LayerCounts& counts) const;

private:
    std::vector<Path> start_paths(std::size_t tile) const;
    void find_media(std::vector<Path>& paths) const;
    Path start_path(int x, int y) const;
    static void sink(Path& path);
    void find_encounters(const std::vector<Path>& paths, std::vector<Encounter>& encounters) const;
    bool meets_rest_plane(const Path& path, double nearest, double& distance) const;

    /// One event of a path; false where the path has ended.
    bool advance(Path& path, const Encounter& encounter, LayerCounts& counts) const;
    bool cross_water(Path& path, const SurfacePoint& surface, LayerCounts& counts) const;
    bool mirror(Path& path, const SurfacePoint& surface, const glm::dvec3& color, LayerCounts& counts) const;
    bool may_go_on(Path& path, LayerCounts& counts) const;
    void move_to(Path& path, const SurfacePoint& surface) const;
    void lift_off(Path& path, const glm::dvec3& normal) const;
    void absorb(Path& path, double distance) const;
    void note_depth(const Path& path, double distance) const;
    void end_at_receiver(const Path& path, const rays::Hit& hit, const SurfacePoint& surface) const;
    void end_in_environment(const Path& path) const;
    bool wanted(const Path& path) const { return request_.branch == 0 || path.split; }

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    LayerRequest request_;
    ReceiverLayer& layer_;
    Camera camera_;
    SurfaceGeometry geometry_;
    glm::dvec2 offset_;
    CameraMedium medium_;
    int tiles_across_;
    int tiles_down_;
};

LayerTracer::LayerTracer(const scene::FrameScene& scene, const rays::RayScene& rays, LayerRequest request,
                         ReceiverLayer& layer)
    : scene_(scene),
      rays_(rays),
      request_(request),
      layer_(layer),
      camera_(scene.state.camera, scene.state.clip.width, scene.state.clip.height),
      geometry_(scene),
      offset_(request.offset.value_or(Camera::sample_offset(request.sample, scene.state.clip.samples)) +
              glm::dvec2(request.window ? request.window->corner : glm::ivec2(0))),
      medium_(camera_medium(scene)),
      tiles_across_((layer.width + kTileSize - 1) / kTileSize),
      tiles_down_((layer.height + kTileSize - 1) / kTileSize) {}

Path LayerTracer::start_path(int x, int y) const {
    Path path;
    path.pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(layer_.width) + static_cast<std::size_t>(x);
    const glm::dvec2 place = glm::dvec2(x, y) + offset_;
    camera_.ray(place, path.origin, path.direction);
    path.origin -= scene_.origin;
    path.start = path.origin;
    camera_.ray_differentials(place, path.origin_du, path.origin_dv, path.direction_du, path.direction_dv);
    path.pixel_width = length(path.origin_du);
    path.in_water = medium_.in_water;
    if (medium_.at_surface && scene_.state.camera.projection == scene::Projection::perspective) sink(path);
    return path;
}

std::vector<Path> LayerTracer::start_paths(std::size_t tile) const {
    const int left = static_cast<int>(tile % static_cast<std::size_t>(tiles_across_)) * kTileSize;
    const int top = static_cast<int>(tile / static_cast<std::size_t>(tiles_across_)) * kTileSize;
    std::vector<Path> paths;
    paths.reserve(std::size_t{kTileSize} * kTileSize);
    for (int block_y = top; block_y < top + kTileSize; block_y += kPacketHeight) {
        for (int block_x = left; block_x < left + kTileSize; block_x += kPacketWidth) {
            for (int y = block_y; y < std::min(block_y + kPacketHeight, layer_.height); ++y) {
                for (int x = block_x; x < std::min(block_x + kPacketWidth, layer_.width); ++x) {
                    paths.push_back(start_path(x, y));
                }
            }
        }
    }
    return paths;
}

/// Moves the start of a path at the water's surface clearly under it. On the surface itself a ray may meet it
/// or not, from either side.
void LayerTracer::sink(Path& path) {
    path.origin.y -= 2 * surface_margin(path.origin);
    path.start = path.origin;
}

/// The paths of an orthographic camera start apart from each other, some perhaps in the water and some in the
/// air: the rules of camera_in_water(), by rays to the surface.
void LayerTracer::find_media(std::vector<Path>& paths) const {
    std::vector<rays::Ray> rays(paths.size());
    std::vector<rays::Hit> above(paths.size());
    std::vector<rays::Hit> below(paths.size());
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const double margin = surface_margin(paths[i].start);
        rays[i].origin = glm::vec3(paths[i].start - glm::dvec3(0, margin, 0));
        rays[i].direction = {0, 1, 0};
    }
    rays_.intersect_water(rays, above);
    for (rays::Ray& ray : rays) ray.direction = {0, -1, 0};
    rays_.intersect_water(rays, below);
    const bool open = scene_.state.water->extent.kind == scene::ExtentKind::open_water;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const double margin = surface_margin(paths[i].start);
        bool at_surface = above[i].distance <= 2 * margin;
        paths[i].in_water = false;
        if (above[i].primitive != rays::kNoHit) {
            paths[i].in_water = above[i].normal.y > 0;
        } else if (open && below[i].primitive == rays::kNoHit) {
            const double height = paths[i].start.y + scene_.origin.y;
            paths[i].in_water = height <= margin;
            at_surface = std::abs(height) <= margin;
        }
        if (at_surface) sink(paths[i]);
    }
}

void LayerTracer::trace_tile(std::size_t tile, LayerCounts& counts) const {
    std::vector<Path> paths = start_paths(tile);
    if (scene_.water && scene_.state.camera.projection == scene::Projection::orthographic) find_media(paths);
    std::vector<Encounter> encounters;
    while (!paths.empty()) {
        find_encounters(paths, encounters);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < paths.size(); ++i) {
            if (advance(paths[i], encounters[i], counts)) paths[kept++] = paths[i];
        }
        paths.resize(kept);
    }
}

void LayerTracer::find_encounters(const std::vector<Path>& paths, std::vector<Encounter>& encounters) const {
    std::vector<rays::Ray> rays(paths.size());
    std::vector<rays::Hit> objects(paths.size());
    std::vector<rays::Hit> water(paths.size());
    for (std::size_t i = 0; i < paths.size(); ++i) {
        rays[i].origin = glm::vec3(paths[i].start);
        rays[i].direction = glm::vec3(paths[i].direction);
    }
    rays_.intersect_objects(rays, objects);
    if (scene_.water) {
        for (std::size_t i = 0; i < paths.size(); ++i) rays[i].far = objects[i].distance;
        rays_.intersect_water(rays, water);
    }
    encounters.assign(paths.size(), Encounter{});
    for (std::size_t i = 0; i < paths.size(); ++i) {
        Encounter& encounter = encounters[i];
        if (water[i].primitive != rays::kNoHit) {
            encounter.kind = Encounter::Kind::water_mesh;
            encounter.hit = water[i];
        } else if (objects[i].primitive != rays::kNoHit) {
            encounter.kind = Encounter::Kind::object;
            encounter.hit = objects[i];
        }
        const auto nearest = static_cast<double>(encounter.hit.distance);
        if (meets_rest_plane(paths[i], nearest, encounter.distance))
            encounter.kind = Encounter::Kind::rest_plane;
    }
}

bool LayerTracer::meets_rest_plane(const Path& path, double nearest, double& distance) const {
    if (!scene_.state.water || path.left_rest_plane) return false;
    const scene::Extent& extent = scene_.state.water->extent;
    if (extent.kind != scene::ExtentKind::open_water) return false;
    distance = (-scene_.origin.y - path.origin.y) / path.direction.y;
    if (!(distance > 0 && distance < nearest)) return false;
    const glm::dvec3 world = path.origin + distance * path.direction + scene_.origin;
    return std::abs(world.x - extent.center.x) > 0.5 * extent.size.x ||
           std::abs(world.z - extent.center.y) > 0.5 * extent.size.y;
}

bool LayerTracer::advance(Path& path, const Encounter& encounter, LayerCounts& counts) const {
    switch (encounter.kind) {
        case Encounter::Kind::nothing:
            end_in_environment(path);
            return false;
        case Encounter::Kind::water_mesh:
            return cross_water(path, geometry_.water_point(encounter.hit, path.origin, path.direction),
                               counts);
        case Encounter::Kind::rest_plane: {
            SurfacePoint surface;
            surface.distance = encounter.distance;
            surface.position = path.origin + encounter.distance * path.direction;
            if (!cross_water(path, surface, counts)) return false;
            path.left_rest_plane = true;
            return true;
        }
        case Encounter::Kind::object:
            break;
    }
    const SurfacePoint surface = geometry_.object_point(encounter.hit, path.origin, path.direction);
    note_depth(path, surface.distance);
    if (path.in_water) absorb(path, surface.distance);
    const scene::Material& material = scene_.state.objects[encounter.hit.object].material;
    if (material.mirror) return mirror(path, surface, material.color, counts);
    if (wanted(path)) end_at_receiver(path, encounter.hit, surface);
    return false;
}

/// The sides that a path at a surface may use: geometric and shading normal towards the side it comes from,
/// the latter with its derivative.
struct FacingNormals {
    glm::dvec3 geometric;
    glm::dvec3 shading;
    glm::dmat3 shading_change;

    FacingNormals(const SurfacePoint& surface, const glm::dvec3& direction) {
        const double side = dot(direction, surface.geometric_normal) <= 0 ? 1 : -1;
        geometric = side * surface.geometric_normal;
        shading = side * surface.shading_normal;
        shading_change = side * surface.shading_normal_change;
    }
    /// Where an interpolated normal would send the path to the wrong side of the triangle.
    void fall_back_to_geometric() {
        shading = geometric;
        shading_change = glm::dmat3(0.0);
    }
};

bool LayerTracer::cross_water(Path& path, const SurfacePoint& surface, LayerCounts& counts) const {
    note_depth(path, surface.distance);
    // The side that the path comes from is the triangle's to say: a path that entered the water through the
    // open side of a pool learns here that it is under water.
    const bool from_air = dot(path.direction, surface.geometric_normal) <= 0;
    if (!from_air) absorb(path, surface.distance);
    if (!may_go_on(path, counts)) return false;

    const double index = scene_.state.water->refractive_index;
    const double eta = from_air ? 1 / index : index;
    FacingNormals normals(surface, path.direction);
    glm::dvec3 refracted;
    bool transmits = optics::f64::refracted_direction(path.direction, normals.shading, eta, refracted);
    glm::dvec3 reflected = optics::f64::reflected_direction(path.direction, normals.shading);
    if (dot(path.direction, normals.shading) >= 0 || dot(reflected, normals.geometric) <= 0 ||
        (transmits && dot(refracted, normals.geometric) >= 0)) {
        normals.fall_back_to_geometric();
        transmits = optics::f64::refracted_direction(path.direction, normals.shading, eta, refracted);
        reflected = optics::f64::reflected_direction(path.direction, normals.shading);
    }
    const double cos_i = std::min(1.0, -dot(path.direction, normals.shading));
    const double cos_t = optics::f64::transmitted_cosine(cos_i, eta);
    const double transmittance = transmits ? optics::f64::fresnel_transmittance(cos_i, cos_t, eta) : 0;
    const double reflectance = transmits ? optics::f64::fresnel_reflectance(cos_i, cos_t, eta) : 1;
    const double through = transmittance * eta * eta;  // radiance scales by n^2

    bool refracts = transmittance > 0;
    if (transmittance > 0 && reflectance > 0) {
        if (!path.split) {
            path.split = true;
            ++counts.split_pixels;
            refracts = request_.branch == 0;
        } else {
            refracts = transmittance >= reflectance;
            ++counts.dropped_splits;
            counts.dropped_weight += mean(path.throughput) * (refracts ? reflectance : through);
        }
    }

    move_to(path, surface);
    const glm::dvec3 normal_du = normals.shading_change * path.origin_du;
    const glm::dvec3 normal_dv = normals.shading_change * path.origin_dv;
    const glm::dvec3 incident = path.direction;
    if (refracts) {
        path.throughput *= through;
        path.direction_du =
            optics::f64::refracted_differential(incident, normals.shading, eta, path.direction_du, normal_du);
        path.direction_dv =
            optics::f64::refracted_differential(incident, normals.shading, eta, path.direction_dv, normal_dv);
        path.direction = normalize(refracted);
        path.in_water = from_air;
        lift_off(path, -normals.geometric);
    } else {
        path.throughput *= reflectance;
        path.direction_du =
            optics::f64::reflected_differential(incident, normals.shading, path.direction_du, normal_du);
        path.direction_dv =
            optics::f64::reflected_differential(incident, normals.shading, path.direction_dv, normal_dv);
        path.direction = normalize(reflected);
        path.in_water = !from_air;
        lift_off(path, normals.geometric);
    }
    return true;
}

bool LayerTracer::mirror(Path& path, const SurfacePoint& surface, const glm::dvec3& color,
                         LayerCounts& counts) const {
    if (!may_go_on(path, counts)) return false;
    FacingNormals normals(surface, path.direction);
    glm::dvec3 reflected = optics::f64::reflected_direction(path.direction, normals.shading);
    if (dot(reflected, normals.geometric) <= 0) {
        normals.fall_back_to_geometric();
        reflected = optics::f64::reflected_direction(path.direction, normals.shading);
    }
    move_to(path, surface);
    path.direction_du = optics::f64::reflected_differential(
        path.direction, normals.shading, path.direction_du, normals.shading_change * path.origin_du);
    path.direction_dv = optics::f64::reflected_differential(
        path.direction, normals.shading, path.direction_dv, normals.shading_change * path.origin_dv);
    path.direction = normalize(reflected);
    path.throughput *= color;
    lift_off(path, normals.geometric);
    return true;
}

bool LayerTracer::may_go_on(Path& path, LayerCounts& counts) const {
    if (path.events == kLongestChain) {
        ++counts.longest_chain_hits;
        return false;
    }
    ++path.events;
    return true;
}

/// Brings the path and its differentials to the surface.
void LayerTracer::move_to(Path& path, const SurfacePoint& surface) const {
    for (auto [dp, dd] :
         {std::pair{&path.origin_du, &path.direction_du}, {&path.origin_dv, &path.direction_dv}}) {
        *dp = optics::f64::transferred_differential(*dp, *dd, path.direction, surface.distance,
                                                    surface.geometric_normal);
    }
    path.length += surface.distance;
    path.origin = surface.position;
    path.left_rest_plane = false;
}

/// Rays start a few roundings off the surface, on the side that the path goes on in, so as not to meet it
/// again; what they hit is placed from the unmoved path.
void LayerTracer::lift_off(Path& path, const glm::dvec3& normal) const {
    const glm::dvec3 size = glm::abs(path.origin);
    path.start = path.origin + 0x1p-20 * (1 + std::max({size.x, size.y, size.z})) * normal;
}

void LayerTracer::absorb(Path& path, double distance) const {
    path.throughput *= glm::exp(-distance * scene_.state.water->absorption);
}

void LayerTracer::note_depth(const Path& path, double distance) const {
    if (path.events > 0 || path.length > 0) return;
    layer_.depth[path.pixel] = static_cast<float>(distance * dot(path.direction, camera_.forward()));
}

void LayerTracer::end_in_environment(const Path& path) const {
    if (path.in_water || !wanted(path)) return;
    layer_.flags[path.pixel] = kEnvironment | (path.events > 0 ? kBehindSpecular : 0u);
    layer_.throughput[path.pixel] = glm::vec3(path.throughput);
}

void LayerTracer::end_at_receiver(const Path& path, const rays::Hit& hit, const SurfacePoint& surface) const {
    const std::size_t pixel = path.pixel;
    std::uint32_t flags = kReceiver;
    if (path.in_water) flags |= kInWater;
    if (path.events > 0) flags |= kBehindSpecular;

    Path end = path;
    move_to(end, surface);
    const auto beam_width = [&](const glm::dvec3& dp, const glm::dvec3& dd) {
        const glm::dvec3 beside = dp + surface.distance * dd;
        return length(beside - dot(beside, path.direction) * path.direction);
    };
    const double widest = std::max(beam_width(path.origin_du, path.direction_du),
                                   beam_width(path.origin_dv, path.direction_dv));
    const double longest =
        kLongestAspect *
        std::min(widest, (end.length + path.pixel_width) / kLongestAspect + path.pixel_width);
    for (glm::dvec3* footprint : {&end.origin_du, &end.origin_dv}) {
        const double size = length(*footprint);
        if (size <= longest) continue;
        flags |= kFootprintCapped;
        *footprint = is_finite(*footprint) ? (longest / size) * *footprint : glm::dvec3(0);
    }

    const FacingNormals normals(surface, path.direction);
    const TexturePoint texture = geometry_.texture_point(hit, surface);
    const auto texture_width = [&](const glm::dvec3& footprint) {
        return length(glm::dvec2(dot(texture.u_gradient, footprint), dot(texture.v_gradient, footprint)));
    };
    layer_.flags[pixel] = flags;
    layer_.object[pixel] = hit.object;
    layer_.primitive[pixel] = hit.primitive;
    layer_.position[pixel] = glm::vec3(end.origin);
    layer_.footprint_u[pixel] = glm::vec3(end.origin_du);
    layer_.footprint_v[pixel] = glm::vec3(end.origin_dv);
    layer_.geometric_normal[pixel] = glm::vec3(normals.geometric);
    layer_.shading_normal[pixel] = glm::vec3(normals.shading);
    layer_.throughput[pixel] = glm::vec3(path.throughput);
    layer_.uv[pixel] = glm::vec2(texture.uv);
    layer_.uv_width[pixel] =
        static_cast<float>(std::max(texture_width(end.origin_du), texture_width(end.origin_dv)));
}

ReceiverLayer empty_layer(const scene::Clip& clip, LayerRequest request) {
    ReceiverLayer layer;
    layer.width = request.window ? request.window->size.x : clip.width;
    layer.height = request.window ? request.window->size.y : clip.height;
    layer.sample = request.sample;
    layer.branch = request.branch;
    const std::size_t pixels = layer.pixels();
    layer.flags.assign(pixels, 0);
    layer.object.assign(pixels, 0);
    layer.primitive.assign(pixels, 0);
    for (auto* positions : {&layer.position, &layer.footprint_u, &layer.footprint_v, &layer.throughput}) {
        positions->assign(pixels, glm::vec3(0));
    }
    layer.geometric_normal.assign(pixels, glm::vec3(0, 1, 0));
    layer.shading_normal.assign(pixels, glm::vec3(0, 1, 0));
    layer.uv.assign(pixels, glm::vec2(0));
    layer.uv_width.assign(pixels, 0);
    layer.depth.assign(pixels, std::numeric_limits<float>::infinity());
    return layer;
}

}  // namespace

ReceiverLayer trace_layer(const scene::FrameScene& scene, const rays::RayScene& rays, LayerRequest request,
                          LayerCounts& counts, SegmentLayer*) {
    ReceiverLayer layer = empty_layer(scene.state.clip, request);
    const LayerTracer tracer(scene, rays, request, layer);
    std::vector<LayerCounts> parts(tracer.tiles());
    parallel_for(tracer.tiles(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tile = begin; tile < end; ++tile) tracer.trace_tile(tile, parts[tile]);
    });
    counts = LayerCounts{};
    for (const LayerCounts& part : parts) {  // in order of the tiles: the same bits on any number of threads
        counts.split_pixels += part.split_pixels;
        counts.dropped_splits += part.dropped_splits;
        counts.dropped_weight += part.dropped_weight;
        counts.longest_chain_hits += part.longest_chain_hits;
    }
    return layer;
}

}  // namespace dapple::view
