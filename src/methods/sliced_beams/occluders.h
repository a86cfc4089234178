#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "light/water_beams.h"
#include "methods/sliced_beams/beam_pyramid.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

struct Bounds {
    glm::dvec3 low{0, 0, 0}, high{0, 0, 0};
};

/// Which objects can stand in the light of one sheet at all, by bounding boxes: their answer "free" is sure.
class Occluders {
public:
    template <class Real>
    Occluders(const scene::FrameScene& scene, const light::BeamSheet<Real>& sheet);

    /// Whether nothing can stand between the water and receivers. In the sheet's space: rays leave the water
    /// within `surface` from the depth `nearest` on, and end within `receivers` at depths [low, high].
    /// `own`: the receivers' object, which cannot hide itself where it is convex.
    bool free_after_water(const Box<double>& surface, double nearest, const Box<double>& receivers,
                          double low, double high, std::uint32_t own) const;
    /// Whether nothing can stand between the light and that part of the water; `farthest`: the depth at which
    /// the last ray leaves the water.
    bool free_before_water(const Box<double>& surface, double nearest, double farthest) const;

    /// Planes, boxes and spheres: what lies before one of their faces is not hidden by themselves.
    bool convex(std::uint32_t object) const { return objects_[object].convex; }

private:
    struct Object {
        bool convex;
        Bounds across_sheet, across_light, world;
    };
    glm::dmat3 sheet_from_world_, world_from_sheet_, light_from_world_;
    bool sun_;
    glm::dvec3 light_position_;
    std::vector<Object> objects_;
};

}  // namespace dapple::methods::sliced_beams
