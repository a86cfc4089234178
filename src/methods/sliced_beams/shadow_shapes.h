#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "methods/sliced_beams/landing.h"
#include "methods/sliced_beams/lit_parts.h"
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

/// The straight ways of light to the start, the middle and the end of an interval [-1, 1]; between these the
/// margins by which objects stand in them are taken as quadratics.
template <class Real>
struct WayLanes {
    PointLanes<Real> from[3], to[3];
};

/// The scene's planes, boxes and spheres, against many ways at once.
template <class Real>
class ShadowShapes {
public:
    ShadowShapes(const scene::FrameScene& scene, const light::BeamSheet<Real>& sheet);

    /// Those that darken() knows.
    ObjectSet known() const { return known_; }
    /// Takes the shadows of the objects of a set, all known ones, from what is lit: a convex object's is one
    /// interval, found by its ends and so whatever its width. Exact where the ends of the ways are linear,
    /// the object is no sphere, and the way changes sign along none of the object's axes within the interval,
    /// where the margins, which hold its magnitude, have a kink.
    void darken(ObjectSet set, const WayLanes<Real>& ways, LitParts<Real>& lit) const;
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
