#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/camera.h"
#include "view/camera_medium.h"
#include "view/glass_bodies.h"

namespace dapple::view {

/// A camera path on its way, in double; positions relative to the frame's origin.
struct Path {
    std::size_t pixel = 0;
    glm::dvec3 origin{0};
    glm::dvec3 direction{0};                                                  ///< unit
    glm::dvec3 origin_du{0}, origin_dv{0}, direction_du{0}, direction_dv{0};  ///< by pixel x and y
    glm::dvec3 throughput{1};
    glm::dvec3 start{0};     ///< where rays are traced from: `origin`, lifted off the surface that was left
    double pixel_width = 0;  ///< m, of the beam at the camera
    double length = 0;       ///< m, of the way so far
    int events = 0;
    double index = 1;              ///< of refraction of the medium that it starts in
    bool in_water = false;         ///< false within a body of glass
    std::uint32_t body = kNoBody;  ///< the object of glass that it travels in
    bool split = false;            ///< it has met a Fresnel split
    bool split_again = false;      ///< and a later one of which both sides are worth following
    bool left_rest_plane = false;
};

/// Where the paths of a layer start, and in which medium or body of glass.
class PathStarts {
public:
    /// `width` is the layer's, `offset` the place of pixel (0, 0)'s path in the clip's picture.
    PathStarts(const scene::FrameScene& scene, const rays::RayScene& rays, int width, glm::dvec2 offset);

    /// Of the pixels from `corner` to `end` (not included), in packets of neighbours.
    std::vector<Path> start(glm::ivec2 corner, glm::ivec2 end) const;

private:
    bool perspective() const;
    Path start_path(int x, int y) const;
    void find_media(std::vector<Path>& paths) const;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    Camera camera_;
    std::size_t width_;
    glm::dvec2 offset_;
    CameraMedium medium_;
    GlassBodies glass_;
    std::uint32_t body_ = kNoBody;  ///< of a perspective camera
};

}  // namespace dapple::view
