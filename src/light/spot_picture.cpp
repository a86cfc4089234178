#include "light/spot_picture.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "optics/optics.h"
#include "scene/area_light.h"

namespace dapple::light {
namespace {

/// Cosine of the angle to the axis beyond which no cone reaches: there the picture's edge goes on.
constexpr double kLeastCosine = 0.05;
/// Parts of an edge of a triangle.
constexpr double kMostParts = 16;
/// Channels that differ by less against the brightest texel are alike.
constexpr float kGrey = 1e-4f;

}  // namespace

SpotPicture::SpotPicture(const scene::FrameScene& scene, int light_index) {
    const auto index = static_cast<std::size_t>(light_index);
    const scene::Light& light = scene.state.lights[index];
    if (light.type != scene::LightType::spot || index >= scene.light_textures.size()) return;
    texture_ = scene.light_textures[index];
    if (!texture_) return;
    axis_ = light.direction;
    const scene::LightFrame frame = scene::light_frame(light);
    right_ = frame.right;
    up_ = frame.up;
    const glm::dvec2 size(texture_->width(), texture_->height());
    texel_ = 2 * std::tan(light.cone_angle) / std::min(size.x, size.y);
    uv_scale_ = 1.0 / (texel_ * size);
    cos_outer_ = std::cos(light.cone_angle);
    cos_inner_ = std::cos(std::max(0.0, light.cone_angle - light.falloff_angle));
}

/// Tangents of the angles to the axis, to the right and up.
glm::dvec2 SpotPicture::place(const glm::dvec3& way) const {
    const double ahead = std::max(glm::dot(way, axis_), kLeastCosine * glm::length(way));
    return glm::dvec2(glm::dot(way, right_), glm::dot(way, up_)) / ahead;
}

glm::dvec3 SpotPicture::at(const glm::dvec2& place, double texels) const {
    const auto longer = static_cast<double>(std::max(texture_->width(), texture_->height()));
    return texture_->sample_once(glm::vec2(0.5 + uv_scale_ * place), static_cast<float>(texels / longer));
}

bool SpotPicture::grey() const {
    if (!exists()) return true;
    const std::span<const float> rgb = texture_->rgb();
    const float least = kGrey * *std::max_element(rgb.begin(), rgb.end());
    for (std::size_t i = 0; i < rgb.size(); i += 3) {
        const float red = std::abs(rgb[i] - rgb[i + 1]), blue = std::abs(rgb[i + 2] - rgb[i + 1]);
        if (std::max(red, blue) > least) return false;
    }
    return true;
}

double SpotPicture::brightest() const {
    if (!exists()) return 1;
    const std::span<const float> rgb = texture_->rgb();
    double found = 0;
    for (std::size_t i = 0; i < rgb.size(); i += 3)
        found = std::max(found, luminance({rgb[i], rgb[i + 1], rgb[i + 2]}));
    return found;
}

double SpotPicture::luminance(const glm::dvec3& color) {
    return glm::dot(color, glm::dvec3(0.2126, 0.7152, 0.0722));
}

bool SpotPicture::in_cone(const glm::dvec3& way) const {
    return glm::dot(way, axis_) > cos_outer_ * glm::length(way);
}

glm::dvec3 SpotPicture::towards(const glm::dvec3& way, double width) const {
    if (!exists()) return glm::dvec3(1);
    const glm::dvec2 tangents = place(way);
    // A radian is at least 1 / cos^2 wide on the plane.
    return at(tangents, width * (1 + glm::dot(tangents, tangents)) / texel_);
}

glm::dvec3 SpotPicture::mean(const std::array<glm::dvec3, 3>& ways) const {
    if (!exists()) return glm::dvec3(1);
    const std::array<glm::dvec2, 3> corner{place(ways[0]), place(ways[1]), place(ways[2])};
    const double longest = std::max({glm::distance(corner[0], corner[1]), glm::distance(corner[1], corner[2]),
                                     glm::distance(corner[2], corner[0])}) /
                           texel_;
    const double wanted = std::ceil(2 * longest);  // parts of half a texel
    const int parts = static_cast<int>(wanted >= 1 ? std::min(wanted, kMostParts) : 1.0);
    const double texels = longest / parts;
    const glm::dvec3 u = (ways[1] - ways[0]) / (3.0 * parts), v = (ways[2] - ways[0]) / (3.0 * parts);
    glm::dvec3 lit(0), all(0);
    double lit_weight = 0, all_weight = 0;
    const auto add = [&](int thirds_u, int thirds_v) {
        const glm::dvec3 way =
            ways[0] + static_cast<double>(thirds_u) * u + static_cast<double>(thirds_v) * v;
        // What a part of a plane triangle fills of the light's sight goes with 1 / r^3.
        const double square = glm::dot(way, way), distance = std::sqrt(square);
        const double weight = 1 / (square * distance);
        const double falloff =
            weight * optics::f64::spot_light_falloff(glm::dot(way, axis_) / distance, cos_outer_, cos_inner_);
        const glm::dvec3 value = at(place(way), texels);
        all += weight * value;
        all_weight += weight;
        lit += falloff * value;
        lit_weight += falloff;
    };
    for (int i = 0; i < parts; ++i)
        for (int j = 0; i + j < parts; ++j) {
            add(3 * i + 1, 3 * j + 1);
            if (i + j + 1 < parts) add(3 * i + 2, 3 * j + 2);
        }
    return lit_weight > 0 ? lit / lit_weight : all / all_weight;
}

std::vector<SpotPicture> spot_pictures(const scene::FrameScene& scene) {
    std::vector<SpotPicture> pictures;
    for (std::size_t i = 0; i < scene.state.lights.size(); ++i)
        pictures.emplace_back(scene, static_cast<int>(i));
    return pictures;
}

}  // namespace dapple::light
