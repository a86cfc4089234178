#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "methods/sliced_beams/landing.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

/// Objects that may stand in some light, a bit each; the last bit stands for all from the 64th on.
using ObjectSet = std::uint64_t;
constexpr ObjectSet object_bit(std::size_t object) {
    return ObjectSet{1} << (object < 63 ? object : 63);
}

/// A point a lane, in a sheet's axes, m.
template <class Real>
struct PointLanes {
    Lanes<Real> a, b, depth;
};

/// The scene's planes, boxes and spheres, against many ways at once.
template <class Real>
class ShadowShapes {
public:
    ShadowShapes(const scene::FrameScene& scene, const light::BeamSheet<Real>& sheet);

    /// Whether all of a set are shapes that depth() knows.
    bool knows(ObjectSet set) const { return (set & ~known_) == 0; }
    /// How deep straight ways reach into the objects of a set, in the units of the one they reach deepest
    /// into; < 0: by how much they pass them. Continuous in both ends, so that a shadow's edge is where it is
    /// 0.
    Lanes<Real> depth(ObjectSet set, const PointLanes<Real>& from, const PointLanes<Real>& to) const;
    /// m, along which a sun's ray from a point of the water has passed all objects.
    Real beyond() const { return beyond_; }

private:
    struct Shape {
        scene::Shape shape = scene::Shape::mesh;
        Real rows[3][4];  ///< object from sheet
        Real half[3];
    };
    ObjectSet known_ = 0;
    Real beyond_ = 0;
    std::vector<Shape> shapes_;
};

extern template class ShadowShapes<float>;
extern template class ShadowShapes<double>;

}  // namespace dapple::methods::sliced_beams
