#include "methods/caustic_mesh/picture_map.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "view/camera.h"

namespace dapple::methods::caustic_mesh {
namespace {

constexpr float kNearest = 1e-3f;    // m before the camera
constexpr float kFarthest = 1e4f;    // pixels: a longer rectangle leaves the raster's range
constexpr float kWorthwhile = 0.7f;  // of the box's area
constexpr float kRounding = 0.01f;   // pixels: projection in float and the raster's own grid

/// Corners of an outline that is cut at the near plane: each of four edges may add one.
struct Outline {
    std::array<glm::vec2, 8> points;
    std::size_t count = 0;
    void add(glm::vec3 homogeneous) { points[count++] = glm::vec2(homogeneous) / homogeneous.z; }

    /// Extents along `direction` and across it.
    void extents(glm::vec2 direction, glm::vec2& low, glm::vec2& high) const {
        low = glm::vec2(HUGE_VALF);
        high = glm::vec2(-HUGE_VALF);
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec2 p = points[i];
            const glm::vec2 at(glm::dot(p, direction), direction.x * p.y - direction.y * p.x);
            low = glm::min(low, at);
            high = glm::max(high, at);
        }
    }
};

}  // namespace

PictureMap::PictureMap(const scene::FrameScene& scene)
    : perspective_(scene.state.camera.projection == scene::Projection::perspective),
      picture_(scene.state.clip.width, scene.state.clip.height) {
    const view::Camera camera(scene.state.camera, scene.state.clip.width, scene.state.clip.height);
    const glm::dmat4 pixel_from_relative = glm::translate(camera.pixel_from_world(), scene.origin);
    rows_ = {glm::vec4(glm::row(pixel_from_relative, 0)), glm::vec4(glm::row(pixel_from_relative, 1)),
             glm::vec4(glm::row(pixel_from_relative, 3))};
    position_ = glm::vec3(scene.state.camera.position - scene.origin);
    backward_ = -glm::vec3(camera.forward());
}

bool PictureMap::project(glm::vec3 point, glm::vec2& pixel) const {
    const glm::vec4 p(point, 1);
    const float w = glm::dot(rows_[2], p);
    if (w < kNearest) return false;
    pixel = glm::vec2(glm::dot(rows_[0], p), glm::dot(rows_[1], p)) / w;
    return true;
}

void PictureMap::gradients(glm::vec3 point, glm::vec3& gradient_x, glm::vec3& gradient_y) const {
    const glm::vec4 p(point, 1);
    const float w = glm::dot(rows_[2], p);
    gradient_x = glm::vec3(rows_[0] - (glm::dot(rows_[0], p) / w) * rows_[2]) / w;
    gradient_y = glm::vec3(rows_[1] - (glm::dot(rows_[1], p) / w) * rows_[2]) / w;
}

glm::vec3 PictureMap::to_camera(glm::vec3 point) const {
    return perspective_ ? position_ - point : backward_;
}

bool PictureMap::cover(const std::array<glm::vec3, 4>& corners, glm::vec2 margin, PictureCover& box,
                       PictureCover& tight) const {
    std::array<glm::vec3, 4> homogeneous;
    for (std::size_t k = 0; k < 4; ++k) {
        const glm::vec4 p(corners[k], 1);
        homogeneous[k] = {glm::dot(rows_[0], p), glm::dot(rows_[1], p), glm::dot(rows_[2], p)};
    }
    Outline outline;
    for (std::size_t k = 0; k < 4; ++k) {
        const glm::vec3 from = homogeneous[k], to = homogeneous[(k + 1) % 4];
        if (from.z >= kNearest) outline.add(from);
        if ((from.z >= kNearest) == (to.z >= kNearest)) continue;
        glm::vec3 cut = glm::mix(from, to, (kNearest - from.z) / (to.z - from.z));
        cut.z = kNearest;
        outline.add(cut);
    }
    if (outline.count == 0) return false;
    glm::vec2 low, high;
    outline.extents({1, 0}, low, high);
    const glm::vec2 room = margin + kRounding;
    low = glm::max(low - room, glm::vec2(0));
    high = glm::min(high + room, picture_);
    if (!(low.x < high.x && low.y < high.y)) return false;
    const glm::vec2 half = 0.5f * (high - low);
    box = tight = {0.5f * (low + high), {half.x, 0}, {0, half.y}};

    glm::vec2 longest(0);
    for (std::size_t k = 0; k < outline.count; ++k)
        for (std::size_t j = 0; j < k; ++j) {
            const glm::vec2 way = outline.points[k] - outline.points[j];
            if (glm::dot(way, way) > glm::dot(longest, longest)) longest = way;
        }
    const float length = glm::length(longest);
    if (!(length > 2 * std::max(room.x, room.y)) || length > kFarthest) return true;
    const glm::vec2 along = longest / length, across(-along.y, along.x);
    outline.extents(along, low, high);
    const glm::vec2 grown(glm::dot(glm::abs(along), room), glm::dot(glm::abs(across), room));
    const glm::vec2 extent = 0.5f * (high - low) + grown, middle = 0.5f * (high + low);
    if (extent.x * extent.y < kWorthwhile * half.x * half.y)
        tight = {middle.x * along + middle.y * across, extent.x * along, extent.y * across};
    return true;
}

}  // namespace dapple::methods::caustic_mesh
