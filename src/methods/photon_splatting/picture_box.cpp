#include "methods/photon_splatting/picture_box.h"

#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "methods/photon_splatting/sample_place.h"
#include "view/camera.h"

namespace dapple::methods {
namespace {

using lanes::greater;
using lanes::lesser;

constexpr float kNearest = 1e-3f;    // m before the camera
constexpr float kFarthest = 1e4f;    // pixels: a longer parallelogram leaves the raster's range
constexpr float kWorthwhile = 0.7f;  // of the box's area
constexpr float kRounding = 0.01f;   // pixels: projection in float and the raster's own grid

Floats length(Vectors2 v) {
    return lanes::square_root<float>(dot(v, v));
}

}  // namespace

PictureMap::PictureMap(const scene::FrameScene& scene, bool at_cells)
    : perspective_(scene.state.camera.projection == scene::Projection::perspective),
      picture_(scene.state.clip.width, scene.state.clip.height) {
    const view::Camera camera(scene.state.camera, scene.state.clip.width, scene.state.clip.height);
    const glm::dmat4 pixel_from_relative = glm::translate(camera.pixel_from_world(), scene.origin);
    const glm::dvec4 x = glm::row(pixel_from_relative, 0), y = glm::row(pixel_from_relative, 1),
                     w = glm::row(pixel_from_relative, 3);
    row_x_ = glm::vec3(x);
    row_y_ = glm::vec3(y);
    row_w_ = glm::vec3(w);
    offset_ = glm::vec3(x.w, y.w, w.w);
    position_ = glm::vec3(scene.state.camera.position - scene.origin);
    backward_ = -glm::vec3(camera.forward());
    const int samples = scene.state.clip.samples;
    glm::dvec2 low(0.5), high(0.5);
    for (int s = 0; s < samples; ++s) {
        const glm::dvec2 place = SamplePlace(s, samples, at_cells).in_pixel();
        low = glm::min(low, place);
        high = glm::max(high, place);
    }
    grow_low_ = glm::vec2(high - 0.5) + kRounding;
    grow_high_ = glm::vec2(0.5 - low) + kRounding;
    cells_ = glm::vec2(1.0 / view::Camera::sample_cell(0, samples).size);
}

Vectors3 PictureMap::pixels_of(Vectors3 vector) const {
    return {dot(row_x_, vector), dot(row_y_, vector), dot(row_w_, vector)};
}

PlaneViews PictureMap::look_at(Vectors3 point, Vectors3 right, Vectors3 up) const {
    const Vectors3 at = pixels_of(point) + all(offset_), along = pixels_of(right), across = pixels_of(up);
    const Floats inverse = 1.0f / at.z;
    const Floats x = inverse * at.x, y = inverse * at.y;
    const auto derivative = [&](Vectors3 v) {
        return inverse * Vectors2{cells_.x * (v.x - x * v.z), cells_.y * (v.y - y * v.z)};
    };
    return {at, along, across, at.z >= kNearest, derivative(along), derivative(across)};
}

Flags PictureMap::holds(const PlaneViews& planes) const {
    const Vectors3 at = planes.point;
    return planes.in_front & (at.x >= 0.0f) & (at.y >= 0.0f) & (at.x <= picture_.x * at.z) &
           (at.y <= picture_.y * at.z);
}

Vectors3 PictureMap::to_camera(Vectors3 point) const {
    return perspective_ ? all(position_) - point : all(backward_);
}

PictureCorners PictureMap::corners(const PlaneViews& planes, Vectors2 first, Vectors2 second) const {
    const auto in_plane = [&](Vectors2 v) { return v.x * planes.right + v.y * planes.up; };
    const Vectors3 a = in_plane(first), b = in_plane(second);
    Flags in_front = all(true);
    // A corner behind the camera: where the surface passes the camera so closely that nothing of it is in the
    // picture but the far part, which the corner at the near plane bounds on the far side only.
    const auto corner = [&](Vectors3 at) {
        in_front &= at.z > kNearest;
        const Floats inverse = 1.0f / greater(at.z, all(kNearest));
        return Vectors2{inverse * at.x, inverse * at.y};
    };
    const Vectors3 low = planes.point - a, high = planes.point + a;
    const Vectors2 nn = corner(low - b), np = corner(low + b), pn = corner(high - b), pp = corner(high + b);
    return {nn, np, pn, pp, in_front};
}

Flags PictureMap::box(const PictureCorners& corners, PictureCovers& covers) const {
    const auto bounds = [](Floats a, Floats b, Floats c, Floats d, Floats& low, Floats& high) {
        low = lesser(lesser(a, b), lesser(c, d));
        high = greater(greater(a, b), greater(c, d));
    };
    Vectors2 low, high;
    bounds(corners.nn.x, corners.np.x, corners.pn.x, corners.pp.x, low.x, high.x);
    bounds(corners.nn.y, corners.np.y, corners.pn.y, corners.pp.y, low.y, high.y);
    low = {greater(low.x - grow_low_.x, all(0.0f)), greater(low.y - grow_low_.y, all(0.0f))};
    high = {lesser(high.x + grow_high_.x, all(picture_.x)), lesser(high.y + grow_high_.y, all(picture_.y))};
    covers.middle = {0.5f * (low.x + high.x), 0.5f * (low.y + high.y)};
    covers.edge_a = {0.5f * (high.x - low.x), Floats{}};
    covers.edge_b = {Floats{}, 0.5f * (high.y - low.y)};
    return (low.x < high.x) & (low.y < high.y);
}

PictureCovers PictureMap::fitted(const PictureCorners& corners, const PictureCovers& boxes) const {
    const Vectors2 &nn = corners.nn, &np = corners.np, &pn = corners.pn, &pp = corners.pp;
    const Floats quarter = all(0.25f);
    PictureCovers slanted{quarter * (nn + np + pn + pp), quarter * (pn + pp - nn - np),
                          quarter * (np + pp - nn - pn)};
    const Floats area = lanes::magnitude(cross(slanted.edge_a, slanted.edge_b));
    const Floats length_a = length(slanted.edge_a), length_b = length(slanted.edge_b);
    // Perspective makes the outline a general quadrilateral, whose corners lie this far off the
    // parallelogram's.
    const Floats off = 0.25f * length(pp - pn - np + nn);
    const Floats margin = off + glm::length(glm::max(grow_low_, grow_high_));
    // Each pair of sides moves out by the margin, measured across them.
    const Floats widened_a = 1.0f + margin * length_b / area, widened_b = 1.0f + margin * length_a / area;
    slanted.edge_a = widened_a * slanted.edge_a;
    slanted.edge_b = widened_b * slanted.edge_b;
    const Flags fits = corners.in_front & (area > 0.0f) & (length_a + length_b <= kFarthest) &
                       (area * widened_a * widened_b < kWorthwhile * (boxes.edge_a.x * boxes.edge_b.y));
    return {choose(fits, slanted.middle, boxes.middle), choose(fits, slanted.edge_a, boxes.edge_a),
            choose(fits, slanted.edge_b, boxes.edge_b)};
}

}  // namespace dapple::methods
