#pragma once
#include <glm/glm.hpp>

#include "scene/frame_scene.h"

namespace dapple::methods {

/// Parallelogram of the picture, middle +- edge_a +- edge_b, pixels.
struct PictureCover {
    glm::vec2 middle, edge_a, edge_b;
};

/// The camera in float, relative to the frame's origin: what splats need of it.
class PictureMap {
public:
    explicit PictureMap(const scene::FrameScene& scene);

    /// Derivatives of the pixel coordinates by the world position, 1/m, at a point; false behind the camera.
    bool at(glm::vec3 point, glm::vec2& pixel, glm::vec3& gradient_x, glm::vec3& gradient_y) const;
    /// Towards the camera, any length.
    glm::vec3 to_camera(glm::vec3 point) const;
    /// Box of the picture, cut to it, that holds the samples in the parallelogram center +- first +- second
    /// of the world; false where it misses the picture.
    bool box(glm::vec3 center, glm::vec3 first, glm::vec3 second, PictureCover& cover) const;
    /// Changes `cover`, the box of the same parallelogram, to one that lies along it, where that is much
    /// smaller.
    void fit(glm::vec3 center, glm::vec3 first, glm::vec3 second, PictureCover& cover) const;

private:
    /// Picture coordinates of the corner center + a first + b second, held before the near plane.
    glm::vec2 corner(glm::vec3 point, bool& in_front) const;

    glm::vec3 row_x_, row_y_, row_w_;  // of pixel_from_world, relative to the origin
    float offset_x_, offset_y_, offset_w_;
    glm::vec3 position_, backward_;
    bool perspective_;
    glm::vec2 picture_;
    // How far sample positions lie from pixel centres: a box grows by this so that it covers the centres of
    // all pixels whose samples it holds.
    glm::vec2 grow_low_, grow_high_;
};

}  // namespace dapple::methods
