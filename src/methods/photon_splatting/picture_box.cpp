#include "methods/photon_splatting/picture_box.h"

#include <algorithm>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "view/camera.h"

namespace dapple::methods {
namespace {

constexpr float kNearest = 1e-3f;    // m before the camera
constexpr float kFarthest = 1e4f;    // pixels: a longer parallelogram leaves the raster's range
constexpr float kWorthwhile = 0.7f;  // of the box's area
constexpr float kRounding = 0.01f;   // pixels: projection in float and the raster's own grid

}  // namespace

PictureMap::PictureMap(const scene::FrameScene& scene)
    : perspective_(scene.state.camera.projection == scene::Projection::perspective),
      picture_(scene.state.clip.width, scene.state.clip.height) {
    const view::Camera camera(scene.state.camera, scene.state.clip.width, scene.state.clip.height);
    const glm::dmat4 pixel_from_relative = glm::translate(camera.pixel_from_world(), scene.origin);
    const glm::dvec4 x = glm::row(pixel_from_relative, 0), y = glm::row(pixel_from_relative, 1),
                     w = glm::row(pixel_from_relative, 3);
    row_x_ = glm::vec3(x);
    row_y_ = glm::vec3(y);
    row_w_ = glm::vec3(w);
    offset_x_ = static_cast<float>(x.w);
    offset_y_ = static_cast<float>(y.w);
    offset_w_ = static_cast<float>(w.w);
    position_ = glm::vec3(scene.state.camera.position - scene.origin);
    backward_ = -glm::vec3(camera.forward());
    const int samples = scene.state.clip.samples;
    glm::dvec2 low(0.5), high(0.5);
    for (int s = 0; s < samples; ++s) {
        low = glm::min(low, view::Camera::sample_offset(s, samples));
        high = glm::max(high, view::Camera::sample_offset(s, samples));
    }
    grow_low_ = glm::vec2(high - 0.5) + kRounding;
    grow_high_ = glm::vec2(0.5 - low) + kRounding;
}

bool PictureMap::at(glm::vec3 point, glm::vec2& pixel, glm::vec3& gradient_x, glm::vec3& gradient_y) const {
    const float w = glm::dot(row_w_, point) + offset_w_;
    if (w < kNearest) return false;
    pixel = glm::vec2(glm::dot(row_x_, point) + offset_x_, glm::dot(row_y_, point) + offset_y_) / w;
    gradient_x = (row_x_ - pixel.x * row_w_) / w;
    gradient_y = (row_y_ - pixel.y * row_w_) / w;
    return true;
}

glm::vec3 PictureMap::to_camera(glm::vec3 point) const {
    return perspective_ ? position_ - point : backward_;
}

glm::vec2 PictureMap::corner(glm::vec3 point, bool& in_front) const {
    // A corner behind the camera: where the surface passes the camera so closely that nothing of it is in the
    // picture but the far part, which the corner at the near plane bounds on the far side only.
    const float w = glm::dot(row_w_, point) + offset_w_;
    in_front = in_front && w > kNearest;
    return glm::vec2(glm::dot(row_x_, point) + offset_x_, glm::dot(row_y_, point) + offset_y_) /
           std::max(kNearest, w);
}

bool PictureMap::box(glm::vec3 center, glm::vec3 first, glm::vec3 second, PictureCover& cover) const {
    glm::vec2 low(HUGE_VALF), high(-HUGE_VALF);
    bool in_front = true;
    for (const float a : {-1.0f, 1.0f})
        for (const float b : {-1.0f, 1.0f}) {
            const glm::vec2 pixel = corner(center + a * first + b * second, in_front);
            low = glm::min(low, pixel);
            high = glm::max(high, pixel);
        }
    low = glm::max(low - grow_low_, glm::vec2(0));
    high = glm::min(high + grow_high_, picture_);
    if (!(low.x < high.x && low.y < high.y)) return false;
    cover.middle = 0.5f * (low + high);
    cover.edge_a = {0.5f * (high.x - low.x), 0};
    cover.edge_b = {0, 0.5f * (high.y - low.y)};
    return true;
}

void PictureMap::fit(glm::vec3 center, glm::vec3 first, glm::vec3 second, PictureCover& cover) const {
    bool in_front = true;
    const glm::vec2 nn = corner(center - first - second, in_front),
                    np = corner(center - first + second, in_front),
                    pn = corner(center + first - second, in_front),
                    pp = corner(center + first + second, in_front);
    if (!in_front) return;
    PictureCover slanted{0.25f * (nn + np + pn + pp), 0.25f * (pn + pp - nn - np),
                         0.25f * (np + pp - nn - pn)};
    const float area = std::abs(slanted.edge_a.x * slanted.edge_b.y - slanted.edge_a.y * slanted.edge_b.x);
    const float length_a = glm::length(slanted.edge_a), length_b = glm::length(slanted.edge_b);
    // Perspective makes the outline a general quadrilateral, whose corners lie this far off the
    // parallelogram's.
    const float off = 0.25f * glm::length(pp - pn - np + nn);
    const float margin = off + glm::length(glm::max(grow_low_, grow_high_));
    if (!(area > 0) || length_a + length_b > kFarthest) return;
    // Each pair of sides moves out by the margin, measured across them.
    slanted.edge_a *= 1 + margin * length_b / area;
    slanted.edge_b *= 1 + margin * length_a / area;
    const float slanted_area = area * (1 + margin * length_b / area) * (1 + margin * length_a / area);
    if (slanted_area < kWorthwhile * cover.edge_a.x * cover.edge_b.y) cover = slanted;
}

}  // namespace dapple::methods
