#include "view/camera.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "optics/optics.h"

namespace dapple::view {
namespace {

/// A vector across `forward` for cameras whose own `up` lies along it: looking straight down, the far side of
/// the picture is -z.
glm::dvec3 substitute_up(const glm::dvec3& forward) {
    return std::abs(forward.z) < 0.9 ? glm::dvec3(0, 0, forward.y < 0 ? -1 : 1) : glm::dvec3(0, 1, 0);
}

}  // namespace

Camera::Camera(const scene::Camera& camera, int width, int height)
    : camera_(camera), width_(width), height_(height) {
    const glm::dvec3 towards = camera.target - camera.position;
    forward_ = length(towards) > 0 ? normalize(towards) : glm::dvec3(0, 0, -1);
    glm::dvec3 across = cross(forward_, camera.up);
    if (!(length(across) > 1e-9 * length(camera.up))) across = cross(forward_, substitute_up(forward_));
    right_ = normalize(across);
    up_ = cross(right_, forward_);
    const double picture_height = camera.projection == scene::Projection::perspective
                                      ? 2 * std::tan(0.5 * camera.field_of_view)
                                      : camera.view_height;
    pixel_size_ = picture_height / height;
}

void Camera::ray(glm::dvec2 pixel, glm::dvec3& origin, glm::dvec3& direction) const {
    const glm::dvec3 offset =
        pixel_size_ * ((pixel.x - 0.5 * width_) * right_ + (0.5 * height_ - pixel.y) * up_);
    if (camera_.projection == scene::Projection::perspective) {
        origin = camera_.position;
        direction = normalize(forward_ + offset);
    } else {
        origin = camera_.position + offset;
        direction = forward_;
    }
}

void Camera::ray_differentials(glm::dvec2 pixel, glm::dvec3& origin_du, glm::dvec3& origin_dv,
                               glm::dvec3& direction_du, glm::dvec3& direction_dv) const {
    const glm::dvec3 du = pixel_size_ * right_;
    const glm::dvec3 dv = -pixel_size_ * up_;
    origin_du = origin_dv = direction_du = direction_dv = glm::dvec3(0);
    if (camera_.projection == scene::Projection::perspective) {
        const glm::dvec3 towards = forward_ + (pixel.x - 0.5 * width_) * du + (pixel.y - 0.5 * height_) * dv;
        direction_du = optics::f64::normalized_differential(towards, du);
        direction_dv = optics::f64::normalized_differential(towards, dv);
    } else {
        origin_du = du;
        origin_dv = dv;
    }
}

glm::dvec3 Camera::project(glm::dvec3 world) const {
    const glm::dvec4 pixel = pixel_from_world() * glm::dvec4(world, 1);
    return {pixel.x / pixel.w, pixel.y / pixel.w, pixel.z};
}

glm::dmat4 Camera::camera_from_world() const {
    const glm::dmat3 rows(right_, up_, -forward_);
    glm::dmat4 matrix(transpose(rows));
    matrix[3] = glm::dvec4(-(transpose(rows) * camera_.position), 1);
    return matrix;
}

glm::dmat4 Camera::pixel_from_world() const {
    const double scale = 1 / pixel_size_;
    const glm::dvec2 middle(0.5 * width_, 0.5 * height_);
    glm::dmat4 pixel_from_camera(0);  // columns: of x, y, z and 1
    pixel_from_camera[0][0] = scale;
    pixel_from_camera[1][1] = -scale;
    pixel_from_camera[2][2] = -1;
    // Perspective divides by the depth -z, which the middle of the picture then has to carry.
    const bool perspective = camera_.projection == scene::Projection::perspective;
    glm::dvec4& divisor = pixel_from_camera[perspective ? 2 : 3];
    const double sign = perspective ? -1 : 1;
    divisor.x = sign * middle.x;
    divisor.y = sign * middle.y;
    divisor.w = sign;
    return pixel_from_camera * camera_from_world();
}

glm::dvec3 Camera::forward() const {
    return forward_;
}

glm::dvec2 Camera::sample_offset(int sample, int samples) {
    // One sample a row and a column of an n * n grid, ordered like van der Corput's sequence: evenly spread,
    // with the pixel's centre as the mean for every n.
    const auto reversed = [](int index) {
        std::uint32_t bits = 0;
        for (int b = 0; b < 31; ++b) bits |= (static_cast<std::uint32_t>(index) >> b & 1u) << (30 - b);
        return bits;
    };
    int rank = 0;
    for (int other = 0; other < samples; ++other) rank += reversed(other) < reversed(sample) ? 1 : 0;
    return {(sample + 0.5) / samples, (rank + 0.5) / samples};
}

Camera::SampleCell Camera::sample_cell(int sample, int samples) {
    // The offsets of 2^m samples are a (0, m, 2)-net in base 2: each cell of 2^a x 2^(m - a) holds one. For
    // other counts each has a column of its own.
    int rows = 1;
    if ((samples & (samples - 1)) == 0)
        while (4 * rows * rows <= samples) rows *= 2;
    const int columns = samples / rows;
    const glm::dvec2 size(1.0 / columns, 1.0 / rows);
    return {glm::floor(sample_offset(sample, samples) / size) * size, size};
}

}  // namespace dapple::view
