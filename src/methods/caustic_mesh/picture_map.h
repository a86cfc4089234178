#pragma once
#include <array>
#include <glm/glm.hpp>

#include "scene/frame_scene.h"

namespace dapple::methods::caustic_mesh {

/// Parallelogram of the picture, middle +- edge_a +- edge_b, pixels.
struct PictureCover {
    glm::vec2 middle, edge_a, edge_b;
};

/// The camera in float, relative to the frame's origin: what cells need of it.
class PictureMap {
public:
    explicit PictureMap(const scene::FrameScene& scene);

    /// Rows x, y and w of pixel_from_world, from positions relative to the origin.
    const std::array<glm::vec4, 3>& rows() const { return rows_; }
    /// Pixel coordinates of a point; false behind the camera.
    bool project(glm::vec3 point, glm::vec2& pixel) const;
    /// Derivatives of the pixel coordinates by the world position, 1/m, at a point before the camera.
    void gradients(glm::vec3 point, glm::vec3& gradient_x, glm::vec3& gradient_y) const;
    /// Towards the camera, any length.
    glm::vec3 to_camera(glm::vec3 point) const;
    /// What pixels within `margin` (along x, along y) of the outline of four points lie in: a box, cut to the
    /// picture, and where that is much smaller a rectangle along the outline, which may leave the picture
    /// (else the box again). False where nothing of the outline is in the picture.
    bool cover(const std::array<glm::vec3, 4>& corners, glm::vec2 margin, PictureCover& box,
               PictureCover& tight) const;

private:
    std::array<glm::vec4, 3> rows_;
    glm::vec3 position_, backward_;
    bool perspective_;
    glm::vec2 picture_;
};

}  // namespace dapple::methods::caustic_mesh
