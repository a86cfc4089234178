#include "view/camera_paths.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "media/media.h"
#include "view/camera.h"
#include "view/camera_medium.h"
#include "view/crossing.h"
#include "view/path_starts.h"
#include "view/segment_recorder.h"
#include "view/surface_point.h"

namespace dapple::view {
namespace {

/// Pixels are traced in tiles, breadth first, so that packets of rays hold neighbours.
constexpr int kTileSize = 16;

/// A footprint is at most this many times as long as its beam is wide: nearer than a degree to grazing it
/// says nothing of the pixel any more.
constexpr double kLongestAspect = 64;

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
    /// `recorder` may be null; it has as many tiles as the tracer.
    LayerTracer(const scene::FrameScene& scene, const rays::RayScene& rays, const media::Media& media,
                LayerRequest request, ReceiverLayer& layer, SegmentRecorder* recorder);

    static std::size_t tiles(const ReceiverLayer& layer) {
        return static_cast<std::size_t>((layer.width + kTileSize - 1) / kTileSize) *
               static_cast<std::size_t>((layer.height + kTileSize - 1) / kTileSize);
    }
    void trace_tile(std::size_t tile, LayerCounts& counts) const;

private:
    void find_encounters(const std::vector<Path>& paths, std::vector<Encounter>& encounters) const;
    float before(const Path& path, const rays::Hit& object) const;
    bool meets_rest_plane(const Path& path, double nearest, double& distance) const;

    /// One event of a path; false where the path has ended.
    bool advance(Path& path, const Encounter& encounter, LayerCounts& counts) const;
    bool cross_water(Path& path, const SurfacePoint& surface, LayerCounts& counts) const;
    bool cross_glass(Path& path, std::uint32_t object, const SurfacePoint& surface,
                     LayerCounts& counts) const;
    bool cross(Path& path, const SurfacePoint& surface, double index, double index_beyond,
               LayerCounts& counts) const;
    bool mirror(Path& path, const SurfacePoint& surface, const glm::dvec3& color, LayerCounts& counts) const;
    bool may_go_on(Path& path, LayerCounts& counts) const;
    void reach(Path& path, double distance) const;
    glm::dvec3 transmitted(const Path& path, double distance) const;
    void note_piece(const Path& path, double distance) const;
    double index_outside(bool in_water) const;
    bool is_glass(std::uint32_t object) const;
    void end_at_receiver(const Path& path, const rays::Hit& hit, const SurfacePoint& surface) const;
    void end_in_environment(const Path& path) const;
    bool reflects_first() const { return request_.branch % 2 == 1; }
    bool takes_weaker() const { return request_.branch >= 2; }
    /// Whether this branch is the one that a path's next piece belongs to.
    bool wanted(const Path& path) const {
        return takes_weaker() ? path.split_again : !reflects_first() || path.split;
    }

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const media::Media& media_;
    LayerRequest request_;
    ReceiverLayer& layer_;
    PathStarts starts_;
    glm::dvec3 forward_;
    SurfaceGeometry geometry_;
    int tiles_across_;
    SegmentRecorder* recorder_;
};

LayerTracer::LayerTracer(const scene::FrameScene& scene, const rays::RayScene& rays,
                         const media::Media& media, LayerRequest request, ReceiverLayer& layer,
                         SegmentRecorder* recorder)
    : scene_(scene),
      rays_(rays),
      media_(media),
      request_(request),
      layer_(layer),
      starts_(scene, rays, layer.width,
              request.offset.value_or(Camera::sample_offset(request.sample, scene.state.clip.samples)) +
                  glm::dvec2(request.window ? request.window->corner : glm::ivec2(0))),
      forward_(Camera(scene.state.camera, scene.state.clip.width, scene.state.clip.height).forward()),
      geometry_(scene),
      tiles_across_((layer.width + kTileSize - 1) / kTileSize),
      recorder_(recorder) {}

void LayerTracer::trace_tile(std::size_t tile, LayerCounts& counts) const {
    const auto across = static_cast<std::size_t>(tiles_across_);
    const glm::ivec2 corner(static_cast<int>(tile % across) * kTileSize,
                            static_cast<int>(tile / across) * kTileSize);
    std::vector<Path> paths =
        starts_.start(corner, glm::min(corner + kTileSize, glm::ivec2(layer_.width, layer_.height)));
    if (!request_.splits.empty())
        std::erase_if(paths,
                      [&](const Path& path) { return (request_.splits[path.pixel] & request_.only) == 0; });
    counts.paths += paths.size();
    for (Path& path : paths) {
        path.index = path.body == kNoBody ? index_outside(path.in_water)
                                          : scene_.state.objects[path.body].material.refractive_index;
    }
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
    for (std::size_t i = 0; i < paths.size(); ++i) {
        // A path that leaves a triangle nearly along it may meet it again at once, in float.
        if (paths[i].events > 0) rays[i].near = static_cast<float>(surface_margin(paths[i].start));
        rays[i].far = before(paths[i], objects[i]);
    }
    if (scene_.water) rays_.intersect_water(rays, water);
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
        const auto nearest = static_cast<double>(std::min(rays[i].far, water[i].distance));
        if (meets_rest_plane(paths[i], nearest, encounter.distance))
            encounter.kind = Encounter::Kind::rest_plane;
    }
}

/// Where a path's way ends on which it may meet the water; there is none within glass (-1). Where water and a
/// body meet, as under a body that lies on it, the body counts.
float LayerTracer::before(const Path& path, const rays::Hit& object) const {
    if (path.body != kNoBody) return -1;
    if (!is_glass(object.object)) return object.distance;
    const auto distance = static_cast<double>(object.distance);
    const double margin = 2 * surface_margin(path.start + distance * path.direction);
    return static_cast<float>(distance - margin);
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
            note_piece(path, std::numeric_limits<double>::infinity());
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
    if (is_glass(encounter.hit.object)) return cross_glass(path, encounter.hit.object, surface, counts);
    reach(path, surface.distance);
    const scene::Material& material = scene_.state.objects[encounter.hit.object].material;
    if (material.mirror) return mirror(path, surface, material.color, counts);
    if (wanted(path)) end_at_receiver(path, encounter.hit, surface);
    return false;
}

bool LayerTracer::cross_water(Path& path, const SurfacePoint& surface, LayerCounts& counts) const {
    // The side that the path comes from is the triangle's to say: a path that entered the water through the
    // open side of a pool learns here that it is under water.
    const bool from_air = dot(path.direction, surface.geometric_normal) <= 0;
    path.in_water = !from_air;
    reach(path, surface.distance);
    if (!may_go_on(path, counts)) return false;
    const double index = index_outside(true);
    const bool refracts = cross(path, surface, from_air ? 1 : index, from_air ? index : 1, counts);
    path.in_water = refracts == from_air;
    return true;
}

bool LayerTracer::cross_glass(Path& path, std::uint32_t object, const SurfacePoint& surface,
                              LayerCounts& counts) const {
    const bool enters = dot(path.direction, surface.geometric_normal) <= 0;
    reach(path, surface.distance);
    if (!may_go_on(path, counts)) return false;
    // What a path finds outside is the place's to say, as a body may reach from the water into the air.
    const bool known = enters && path.body == kNoBody;
    const bool outside_in_water =
        known ? path.in_water
              : point_in_water(scene_, rays_, lifted(surface.position, surface.geometric_normal));
    const double outside = index_outside(outside_in_water);
    const double glass = scene_.state.objects[object].material.refractive_index;
    const bool refracts = cross(path, surface, enters ? outside : glass, enters ? glass : outside, counts);
    const bool inside = refracts == enters;
    path.body = inside ? object : kNoBody;
    path.in_water = !inside && outside_in_water;
    return true;
}

/// Sends the path on through the interface or back from it; whether through it. The indices of refraction
/// are those of the path's own medium and of that beyond.
bool LayerTracer::cross(Path& path, const SurfacePoint& surface, double index, double index_beyond,
                        LayerCounts& counts) const {
    const Crossing crossing(path.direction, surface, index / index_beyond);
    bool refracts = crossing.transmittance > 0;
    if (crossing.transmittance > 0 && crossing.reflectance > 0) {
        const bool refraction_is_stronger = crossing.transmittance >= crossing.reflectance;
        // As the camera's medium sees it: radiance over n^2 is what a pixel has shares of.
        const double weaker = mean(path.throughput) * index * index / (path.index * path.index) *
                              std::min(crossing.transmittance, crossing.reflectance);
        if (!path.split) {
            path.split = true;
            ++counts.split_pixels;
            layer_.splits[path.pixel] |= kSplits;
            refracts = !reflects_first();
        } else if (!path.split_again && weaker >= kWorthFollowing) {
            path.split_again = true;
            ++counts.split_again_pixels;
            layer_.splits[path.pixel] |= kSplitsAgain;
            refracts = refraction_is_stronger != takes_weaker();
        } else {
            if (wanted(path)) {
                ++counts.dropped_splits;
                counts.dropped_weight += weaker;
            }
            refracts = refraction_is_stronger;
        }
    }
    move_to(path, surface);
    if (refracts) {
        refract(path, crossing);
    } else {
        reflect(path, crossing);
    }
    return refracts;
}

bool LayerTracer::mirror(Path& path, const SurfacePoint& surface, const glm::dvec3& color,
                         LayerCounts& counts) const {
    if (!may_go_on(path, counts)) return false;
    move_to(path, surface);
    reflect(path, surface);
    path.throughput *= color;
    return true;
}

bool LayerTracer::may_go_on(Path& path, LayerCounts& counts) const {
    if (path.events == kLongestChain) {
        if (wanted(path)) ++counts.longest_chain_hits;
        return false;
    }
    ++path.events;
    return true;
}

/// Follows the path to the end of its piece: notes it and what is lost on it.
void LayerTracer::reach(Path& path, double distance) const {
    if (path.events == 0)
        layer_.depth[path.pixel] = static_cast<float>(distance * dot(path.direction, forward_));
    note_piece(path, distance);
    path.throughput *= transmitted(path, distance);
}

/// Share of the light that the path's next piece lets through.
glm::dvec3 LayerTracer::transmitted(const Path& path, double distance) const {
    if (path.body != kNoBody)
        return glm::exp(-distance * scene_.state.objects[path.body].material.absorption);
    if (!path.in_water && !media_.bounded(false)) return glm::dvec3(1);
    return glm::exp(-media_.optical_depth(path.origin, path.direction, distance, path.in_water));
}

double LayerTracer::index_outside(bool in_water) const {
    return in_water ? scene_.state.water->refractive_index : 1;
}

bool LayerTracer::is_glass(std::uint32_t object) const {
    return object != rays::kNoHit && scene_.state.objects[object].material.glass;
}

/// There is no medium within glass.
void LayerTracer::note_piece(const Path& path, double distance) const {
    if (!recorder_ || !wanted(path) || path.body != kNoBody) return;
    const std::size_t width = static_cast<std::size_t>(layer_.width);
    const std::size_t tile = path.pixel / width / kTileSize * static_cast<std::size_t>(tiles_across_) +
                             path.pixel % width / kTileSize;
    recorder_->record(
        tile, {path.pixel, path.origin, path.direction, distance, path.in_water, path.events == 0,
               path.throughput, path.origin_du, path.origin_dv, path.direction_du, path.direction_dv});
}

/// In glass only where its mesh has a hole.
void LayerTracer::end_in_environment(const Path& path) const {
    if (path.in_water || path.body != kNoBody || !wanted(path)) return;
    layer_.flags[path.pixel] = kEnvironment | (path.events > 0 ? kBehindSpecular : 0u);
    layer_.throughput[path.pixel] =
        glm::vec3(path.throughput * transmitted(path, std::numeric_limits<double>::infinity()));
}

void LayerTracer::end_at_receiver(const Path& path, const rays::Hit& hit, const SurfacePoint& surface) const {
    const std::size_t pixel = path.pixel;
    std::uint32_t flags = kReceiver;
    if (path.in_water) flags |= kInWater;
    if (path.body != kNoBody) flags |= kInGlass;
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
    layer.splits.assign(pixels, 0);
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
                          LayerCounts& counts, SegmentLayer* segments) {
    ReceiverLayer layer = empty_layer(scene.state.clip, request);
    const std::size_t tiles = LayerTracer::tiles(layer);
    const media::Media media(scene);
    SegmentRecorder recorder(media, segments ? tiles : 0);
    const LayerTracer tracer(scene, rays, media, request, layer, segments ? &recorder : nullptr);
    std::vector<LayerCounts> parts(tiles);
    parallel_for(tiles, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tile = begin; tile < end; ++tile) tracer.trace_tile(tile, parts[tile]);
    });
    counts = LayerCounts{};
    for (const LayerCounts& part : parts) {  // in order of the tiles: the same bits on any number of threads
        counts.paths += part.paths;
        counts.split_pixels += part.split_pixels;
        counts.split_again_pixels += part.split_again_pixels;
        counts.dropped_splits += part.dropped_splits;
        counts.dropped_weight += part.dropped_weight;
        counts.longest_chain_hits += part.longest_chain_hits;
    }
    if (segments) {
        recorder.write(layer.width, layer.height, *segments);
        segments->sample = request.sample;
        segments->branch = request.branch;
    }
    return layer;
}

}  // namespace dapple::view
