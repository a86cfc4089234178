#pragma once
#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "image/texture.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// The picture that a spot throws (Light::texture), as a slide in its way would: central projection onto a
/// plane across the axis, on which the largest circle within the picture is the edge of the cone. As the
/// light sees it along its axis the picture is upright and not mirrored: to the right lies axis x (0, 1, 0),
/// or +x where the axis is vertical, so that -z is up in what is thrown straight down; `roll` turns it
/// clockwise. Bilinear between texels; at the edge of the picture the outermost go on.
class SpotPicture {
public:
    /// None: 1 everywhere.
    SpotPicture() = default;
    SpotPicture(const scene::FrameScene& scene, int light);

    bool exists() const { return texture_ != nullptr; }
    /// Whether the channels are alike, to 1e-4 of the brightest texel; looks at all texels.
    bool grey() const;
    /// Luminance (Rec. 709) of the brightest texel; looks at all.
    double brightest() const;
    static double luminance(const glm::dvec3& color);

    /// Relative to the light's intensity, in the direction of `way` (m, any length, from the light). The mean
    /// over `width` rad about it, to what levels of half as many texels tell; 0: the point's.
    glm::dvec3 towards(const glm::dvec3& way, double width = 0) const;

    /// The mean over the directions to a triangle, weighted by the spot's falloff: the picture at the middles
    /// of up to 256 equal parts of the triangle, half a texel wide where so many are enough (then right to
    /// 1e-2 of the brightest texel for checkers a texel sharp), else over the parts' widths. `ways`: to the
    /// corners, m, from the light.
    glm::dvec3 mean(const std::array<glm::dvec3, 3>& ways) const;

    /// Texels along a radian at the middle of the picture, the coarser way.
    double texels_per_radian() const { return 1 / texel_; }
    /// Whether the way is in the cone.
    bool in_cone(const glm::dvec3& way) const;

private:
    glm::dvec2 place(const glm::dvec3& way) const;
    glm::dvec3 at(const glm::dvec2& place, double texels) const;

    std::shared_ptr<const image::Texture> texture_;
    glm::dvec3 right_{1, 0, 0}, up_{0, 0, -1}, axis_{0, -1, 0};
    glm::dvec2 uv_scale_{0};  ///< uv from tangents of angles to the axis
    double texel_ = 1;        ///< tangent, of one texel
    double cos_outer_ = -2, cos_inner_ = 1;
};

/// Of all lights of a frame.
std::vector<SpotPicture> spot_pictures(const scene::FrameScene& scene);

}  // namespace dapple::light
