#include "methods/reference/own_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::reference {

OwnPicture::OwnPicture(const scene::FrameScene& scene, std::uint32_t light) {
    if (light < scene.light_textures.size()) texture_ = scene.light_textures[light];
    if (!texture_) return;
    const scene::Light& spot = scene.state.lights[light];
    axis_ = spot.direction;
    // A quarter turn to the right of where the light heads; what shines straight up or down heads to -z.
    const bool heads = std::hypot(axis_.x, axis_.z) > 1e-6;
    const double heading = heads ? std::atan2(axis_.z, axis_.x) : -0.5 * std::numbers::pi;
    right_ = {-std::sin(heading), 0, std::cos(heading)};
    up_ = normalize(cross(right_, axis_));
    turn_ = spot.roll;
    // Half the shorter side of the picture is the radius of the cone.
    per_unit_ = 0.5 * std::min(texture_->width(), texture_->height()) / std::tan(spot.cone_angle);
}

glm::dvec3 OwnPicture::towards(const glm::dvec3& direction) const {
    if (!texture_) return glm::dvec3(1);
    const double ahead = dot(direction, axis_);
    if (!(ahead > 0)) return glm::dvec3(0);
    const double x = dot(direction, right_) / ahead, y = dot(direction, up_) / ahead;
    const double angle = std::atan2(y, x) + turn_, radius = std::hypot(x, y);
    // From the top left, in texels, whose middles are whole numbers.
    const double column = 0.5 * texture_->width() - 0.5 + per_unit_ * radius * std::cos(angle);
    const double row = 0.5 * texture_->height() - 0.5 - per_unit_ * radius * std::sin(angle);
    const auto texel = [&](double i, double j) {
        const auto left = static_cast<std::size_t>(std::clamp(i, 0.0, texture_->width() - 1.0));
        const auto down = static_cast<std::size_t>(std::clamp(j, 0.0, texture_->height() - 1.0));
        const float* rgb =
            texture_->rgb().data() + 3 * (down * static_cast<std::size_t>(texture_->width()) + left);
        return glm::dvec3(rgb[0], rgb[1], rgb[2]);
    };
    const double i = std::floor(column), j = std::floor(row);
    const double u = column - i, v = row - j;
    return (1 - u) * (1 - v) * texel(i, j) + u * (1 - v) * texel(i + 1, j) + (1 - u) * v * texel(i, j + 1) +
           u * v * texel(i + 1, j + 1);
}

}  // namespace dapple::reference
