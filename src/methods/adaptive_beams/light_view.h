#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "light/spot_picture.h"
#include "scene/frame_scene.h"

namespace dapple::methods::adaptive_beams {

struct LightRay {
    glm::dvec3 origin;     ///< m, relative to FrameScene::origin
    glm::dvec3 direction;  ///< unit, of travel
};

/// Rays of one light (a sun: of one direction of its disc) towards one specular body, the water or an object
/// of glass, named by (u, v) in [0, 1]^2. A sun's rays start on a parallelogram, a lamp's fill a rectangular
/// pyramid, (u, v) being linear on a plane across it, so that straight lines in (u, v) are planes of rays and
/// what adjoining triangles send adds up exactly.
class LightView {
public:
    LightRay ray(glm::dvec2 uv) const;
    /// What a light of unit irradiance (m^2) or unit intensity (sr) sends through a triangle of (u, v),
    /// whichever way it turns; the falloff is not in it.
    double extent(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) const;
    /// Intensity of a spot, but for its picture, or an area light relative to its axis; 1 for other lights.
    double falloff(glm::dvec2 uv) const;
    /// Whether the light is a spot that throws a picture.
    bool textured() const { return picture_ != nullptr; }
    /// Mean of its picture over a triangle of (u, v), a channel; 1 for other lights.
    glm::dvec3 picture(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) const;
    /// Luminance of its picture over the brightest texel's; 1 for other lights. `width`: as a share of the
    /// view, of what it is the mean over.
    double picture_brightness(glm::dvec2 uv, double width) const;

    /// What u and v, from 0 to 1, are long at the corner: m across, of a sun; rad, of a lamp, about.
    glm::dvec2 size() const;
    bool parallel() const { return parallel_; }
    /// W/m^2 or W/sr a channel that a unit of extent() stands for, but for the falloff.
    const glm::dvec3& color() const { return color_; }
    /// Whether the light is a lamp below the rest plane of the water.
    bool from_below() const { return from_below_; }
    /// The same rays, of the channels in `mask` (1; others 0) only.
    LightView in_channels(const glm::dvec3& mask) const;

private:
    friend class LightViewMaker;
    bool parallel_ = true;
    bool from_below_ = false;
    bool spot_ = false;
    bool emitter_ = false;  // a part of an area light
    glm::dvec3 color_{0};
    glm::dvec3 direction_{0, -1, 0};  // sun; axis of a spot or an area light
    glm::dvec3 corner_{0};            // sun: where ray (0, 0) starts; lamp: its direction, not unit
    glm::dvec3 along_u_{1, 0, 0};     // change of the same over u in [0, 1]
    glm::dvec3 along_v_{0, 0, 1};
    glm::dvec3 position_{0};  // lamp, relative to the origin
    double cos_outer_ = -2;
    double cos_inner_ = 1;
    std::shared_ptr<const light::SpotPicture> picture_;
    double brightest_ = 1;  // SpotPicture::brightest()
};

/// Points whose hull holds a body, relative to FrameScene::origin; a sphere is said apart.
struct BodyHull {
    std::vector<glm::dvec3> points;
    bool round = false;
    glm::dvec3 center{0};
    glm::dmat3 offset_from_unit{1};

    bool empty() const { return points.empty() && !round; }
    /// Least and greatest of dot(point, axis).
    glm::dvec2 range(const glm::dvec3& axis) const;
};

/// Finds the views of a frame's lights; the frame outlives it.
class LightViews {
public:
    explicit LightViews(const scene::FrameScene& scene);

    /// The views of one light that cover a body (light::kWater or an index into FrameState::objects): one, or
    /// up to six faces of a cube about a lamp that the body surrounds. `direction` is that of the sun's disc
    /// to look along, and `share` the share of the light that it stands for; lamps ignore the direction.
    /// Empty where the light does not reach: a sun that has set, or a lamp in the plane of the water. A body
    /// each has a view of its own, where Liktor and Dachsbacher (section 4.1) put all into one: a coarse grid
    /// then fits a small body in a wide pool too, and a low sun does not stretch it.
    std::vector<LightView> of(int light, glm::dvec3 direction, double share, int body) const;

private:
    const scene::FrameScene& scene_;
    std::vector<BodyHull> objects_;
    BodyHull water_;
};

}  // namespace dapple::methods::adaptive_beams
