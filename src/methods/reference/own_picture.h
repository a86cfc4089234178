#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>

#include "image/texture.h"
#include "scene/frame_scene.h"

namespace dapple::reference {

/// What a spot throws, looked up in the picture's own texels apart from light::SpotPicture on purpose.
class OwnPicture {
public:
    OwnPicture(const scene::FrameScene& scene, std::uint32_t light);
    /// By which the picture multiplies the light's intensity in a unit direction; 1 without one.
    glm::dvec3 towards(const glm::dvec3& direction) const;

private:
    std::shared_ptr<const image::Texture> texture_;
    glm::dvec3 axis_{0}, right_{0}, up_{0};
    double turn_ = 0;      ///< rad
    double per_unit_ = 0;  ///< texels a unit of length, at a unit of distance along the axis
};

}  // namespace dapple::reference
