#pragma once
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "light/water_beams.h"
#include "methods/sliced_beams/beam_pyramid.h"
#include "methods/sliced_beams/shadow_shapes.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

/// A box, m, relative to FrameScene::origin; without points: low > high.
struct Bounds {
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};

    void widen(glm::dvec3 point) {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    glm::dvec3 corner(int i) const {
        return {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    }
};

/// Whether a segment from a point of one box to a point of the other can meet a third; sure where it says no.
bool may_meet(const Bounds& from, const Bounds& to, const Bounds& object);

constexpr std::uint32_t kNoObject = 0xffffffffu;

/// Which objects can stand in the light of one sheet at all, by bounding boxes: their answer "free" is sure.
class Occluders {
public:
    template <class Real>
    Occluders(const scene::FrameScene& scene, const light::BeamSheet<Real>& sheet);

    /// Whether nothing but the object `own` can stand between points of the water and receivers; both boxes
    /// in the sheet's axes and in the world's.
    bool free_after_water(const Bounds (&surface)[2], const Bounds (&receivers)[2], std::uint32_t own) const;
    /// Whether nothing can stand between the light and points of the water, in world axes; `spread`: m a m,
    /// by how much rays to a sun may lean from its middle's.
    bool free_before_water(const Bounds& surface, double spread = 0) const;
    /// The objects that can stand in either light.
    ObjectSet after_water(const Bounds (&surface)[2], const Bounds (&receivers)[2]) const;
    ObjectSet before_water(const Bounds& surface, double spread = 0) const;
    /// The least depth in the sheet at which an object can stand between such points; infinite: none can.
    double first_depth(const Bounds (&surface)[2], const Bounds (&receivers)[2]) const;
    /// Whether a ray that meets the object leaves nothing but points inside or behind it between those of two
    /// others that do.
    bool convex(std::uint32_t object) const { return objects_[object].flat || objects_[object].convex; }

    /// Whether an object may stand in the light of its own receiver: not where the receiver is on the outside
    /// of a plane, a box or a sphere.
    bool may_hide_itself(std::uint32_t object, glm::dvec3 position, glm::dvec3 normal) const {
        if (object >= objects_.size()) return false;  // receivers of no object
        const Object& o = objects_[object];
        return !o.flat && (!o.convex || glm::dot(normal, position - o.centre) <= 0);
    }

private:
    /// Where the light that reaches points of the water comes from.
    Bounds source_of(const Bounds& surface, double spread) const;

    struct Object {
        bool flat, convex;
        glm::dvec3 centre;
        Bounds in_sheet, in_world;
    };
    glm::dvec3 to_sun_;  ///< 0: a lamp
    glm::dvec3 lamp_;
    double beyond_ = 0;  ///< m, a way along which a sun's ray has passed all objects
    std::vector<Object> objects_;
};

}  // namespace dapple::methods::sliced_beams
