#pragma once
#include <glm/glm.hpp>

#include "scene/frame_state.h"

namespace dapple::view {

/// A camera of one frame, in double. Pixel coordinates: x to the right, y down, (0, 0) the top left corner of
/// the picture, pixel centres at + 0.5. Camera space: x right, y up, looking along -z.
class Camera {
public:
    Camera(const scene::Camera& camera, int width, int height);

    /// World-space ray through a point of the picture; `direction` is unit. An orthographic ray starts on the
    /// plane of the camera's position.
    void ray(glm::dvec2 pixel, glm::dvec3& origin, glm::dvec3& direction) const;
    /// d(origin)/d(pixel) and d(direction)/d(pixel) of that ray, of the unit direction.
    void ray_differentials(glm::dvec2 pixel, glm::dvec3& origin_du, glm::dvec3& origin_dv,
                           glm::dvec3& direction_du, glm::dvec3& direction_dv) const;
    /// Picture coordinates (x, y) [pixels] of a world point and its depth along the axis [m] (z).
    /// Perspective: z > 0 is in front; for z <= 0 x and y mean nothing.
    glm::dvec3 project(glm::dvec3 world) const;
    /// Homogeneous pixel coordinates from world: (x, y, depth, w) with pixel = (x, y) / w. For the device,
    /// multiply from the right by a translation by FrameScene::origin.
    glm::dmat4 pixel_from_world() const;
    glm::dmat4 camera_from_world() const;
    glm::dvec3 forward() const;
    /// Offset of sample s of n inside the pixel, in [0, 1)^2, fixed for all pixels and frames; the first of
    /// one is the centre.
    static glm::dvec2 sample_offset(int sample, int samples);
    /// The part of the pixel that sample s of n stands for, which holds its offset: the parts tile the pixel.
    struct SampleCell {
        glm::dvec2 corner{0, 0};  ///< pixels, top left
        glm::dvec2 size{1, 1};    ///< pixels
    };
    static SampleCell sample_cell(int sample, int samples);

private:
    scene::Camera camera_;
    int width_;
    int height_;
    glm::dvec3 right_, up_, forward_;
    double pixel_size_;  ///< picture-plane size of a pixel: at unit distance (perspective), m (orthographic)
};

}  // namespace dapple::view
