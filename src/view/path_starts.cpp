#include "view/path_starts.h"

#include <algorithm>

namespace dapple::view {
namespace {

constexpr int kPacketWidth = 4;
constexpr int kPacketHeight = 2;

/// Moves the start of a path at the water's surface clearly under it. On the surface itself a ray may meet it
/// or not, from either side.
void sink(Path& path) {
    path.origin.y -= 2 * surface_margin(path.origin);
    path.start = path.origin;
}

}  // namespace

PathStarts::PathStarts(const scene::FrameScene& scene, const rays::RayScene& rays, int width,
                       glm::dvec2 offset)
    : scene_(scene),
      rays_(rays),
      camera_(scene.state.camera, scene.state.clip.width, scene.state.clip.height),
      width_(static_cast<std::size_t>(width)),
      offset_(offset),
      medium_(camera_medium(scene)),
      glass_(scene) {
    if (perspective()) body_ = glass_.at(scene.state.camera.position - scene.origin);
}

bool PathStarts::perspective() const {
    return scene_.state.camera.projection == scene::Projection::perspective;
}

Path PathStarts::start_path(int x, int y) const {
    Path path;
    path.pixel = static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x);
    const glm::dvec2 place = glm::dvec2(x, y) + offset_;
    camera_.ray(place, path.origin, path.direction);
    path.origin -= scene_.origin;
    path.start = path.origin;
    camera_.ray_differentials(place, path.origin_du, path.origin_dv, path.direction_du, path.direction_dv);
    path.pixel_width = length(path.origin_du);
    path.body = perspective() ? body_ : glass_.at(path.origin);
    path.in_water = medium_.in_water && path.body == kNoBody;
    if (medium_.at_surface && perspective() && path.body == kNoBody) sink(path);
    return path;
}

std::vector<Path> PathStarts::start(glm::ivec2 corner, glm::ivec2 end) const {
    std::vector<Path> paths;
    const glm::ivec2 size = end - corner;
    paths.reserve(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
    for (int block_y = corner.y; block_y < end.y; block_y += kPacketHeight) {
        for (int block_x = corner.x; block_x < end.x; block_x += kPacketWidth) {
            for (int y = block_y; y < std::min(block_y + kPacketHeight, end.y); ++y) {
                for (int x = block_x; x < std::min(block_x + kPacketWidth, end.x); ++x) {
                    paths.push_back(start_path(x, y));
                }
            }
        }
    }
    if (scene_.water && !perspective()) find_media(paths);
    return paths;
}

/// The paths of an orthographic camera start apart from each other, some perhaps in the water and some in the
/// air: the rules of camera_in_water(), by rays to the surface.
void PathStarts::find_media(std::vector<Path>& paths) const {
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
        if (paths[i].body != kNoBody) continue;
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

}  // namespace dapple::view
