#include "methods/sliced_beams/shadow_shapes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "scene/transform.h"

namespace dapple::methods::sliced_beams {
namespace {

template <class L>
L within_0_1(const L& x) {
    using Real = std::remove_cvref_t<decltype(x[0])>;
    return lesser(greater(x, L{}), splat(Real(1)));  // 0 where it is not a number
}

/// Ways in an object's axes, place by place of the interval.
template <class L>
struct Sweep {
    L from[3][3], way[3][3];  ///< [place][axis]
};

/// The part of [-1, 1] on which an object stands in the ways.
template <class Real>
class Shadow {
public:
    using L = Lanes<Real>;

    L first = splat(Real(-1)), last = splat(Real(1));

    explicit Shadow(const Mask<Real>& wanted) : wanted_(wanted) {}
    bool none() const { return !any(wanted_ & (first < last)); }
    /// Leaves where the quadratic through the margins, at -1, 0 and 1, is positive. (Margins that are
    /// negative in the middle alone are rounding: the part is one interval.)
    void clip(const L (&margin)[3]);
    /// Both limit - place and limit + place.
    void clip(const L (&limit)[3], const L (&place)[3]) {
        const auto outside = (magnitude(place[0]) > limit[0]) | (magnitude(place[1]) > limit[1]) |
                             (magnitude(place[2]) > limit[2]);
        if (!any(wanted_ & outside)) return;
        const L below[3] = {limit[0] - place[0], limit[1] - place[1], limit[2] - place[2]};
        clip(below);
        const L above[3] = {limit[0] + place[0], limit[1] + place[1], limit[2] + place[2]};
        clip(above);
    }

private:
    Mask<Real> wanted_;
};

template <class Real>
void Shadow<Real>::clip(const L (&margin)[3]) {
    const Mask<Real> starts = margin[0] >= 0, stops = margin[2] >= 0;
    if (!any(wanted_ & ~(starts & stops))) return;
    const L q0 = margin[1], q1 = Real(0.5) * (margin[2] - margin[0]);
    const L q2 = Real(0.5) * (margin[2] + margin[0]) - margin[1];
    const L discriminant = q1 * q1 - Real(4) * q0 * q2;
    // Of two roots within, where the quadratic is negative at both ends, or none.
    const Mask<Real> rises =
        ~(starts | stops) & (q2 < 0) & (magnitude(q1) < Real(-2) * q2) & (discriminant > 0);
    const Mask<Real> crosses = starts ^ stops;
    const L never = splat(Real(2));
    if (!any(wanted_ & (crosses | rises))) {
        const Mask<Real> kept = starts;
        first = kept ? first : never;
        return;
    }
    const L root = square_root<Real>(greater(discriminant, L{}));
    const L sum = q1 + (q1 < 0 ? -root : root);
    const L near = Real(-2) * q0 / sum;  // the smaller root, the only one within where one is
    const L far = Real(-0.5) * sum / q2;
    const L low = rises ? lesser(near, far) : near, high = rises ? greater(near, far) : near;
    const L enters = starts ? splat(Real(-1)) : ((crosses | rises) ? low : never);
    const L leaves = stops ? splat(Real(1)) : high;
    first = greater(first, enters);
    last = ((crosses & starts) | rises) ? lesser(last, leaves) : last;
}

/// The separating axes of a segment and a box: the box's own, and their products with the segment's.
template <class L, class Real>
void clip_to_box(const Sweep<L>& ways, const Real (&half)[3], Shadow<Real>& shadow) {
    L middle[3][3], reach[3][3];  // of the ways, and their halves
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            reach[i][k] = Real(0.5) * ways.way[i][k];
            middle[i][k] = ways.from[i][k] + reach[i][k];
        }
    L limit[3], place[3];
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            limit[i] = half[k] + magnitude(reach[i][k]);
            place[i] = middle[i][k];
        }
        shadow.clip(limit, place);
        if (shadow.none()) return;
    }
    for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3, v = (k + 2) % 3;
        for (int i = 0; i < 3; ++i) {
            limit[i] = half[u] * magnitude(reach[i][v]) + half[v] * magnitude(reach[i][u]);
            place[i] = middle[i][u] * reach[i][v] - middle[i][v] * reach[i][u];
        }
        shadow.clip(limit, place);
        if (shadow.none()) return;
    }
}

template <class L, class Real>
void clip_to_sphere(const Sweep<L>& ways, Real radius, Shadow<Real>& shadow) {
    const auto dot = [](const L(&x)[3], const L(&y)[3]) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
    L margin[3];
    for (int i = 0; i < 3; ++i) {
        const L nearest = within_0_1(-dot(ways.from[i], ways.way[i]) / dot(ways.way[i], ways.way[i]));
        L at[3];
        for (int k = 0; k < 3; ++k) at[k] = multiply_add(nearest, ways.way[i][k], ways.from[i][k]);
        margin[i] = radius * radius - dot(at, at);
    }
    shadow.clip(margin);
}

}  // namespace

template <class Real>
ShadowShapes<Real>::ShadowShapes(const scene::FrameScene& scene, const light::BeamSheet<Real>& sheet) {
    const std::size_t count = std::min<std::size_t>(scene.state.objects.size(), 63);
    shapes_.resize(count);
    double beyond = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const scene::Object& object = scene.state.objects[i];
        Shape& shape = shapes_[i];
        shape.shape = object.shape;
        if (object.shape == scene::Shape::mesh) continue;
        const glm::dmat4 world_from_object = scene::world_from_object(object.transform);
        glm::dvec3 half = 0.5 * object.size;
        if (object.shape == scene::Shape::sphere) half = glm::dvec3(object.radius);
        if (object.shape == scene::Shape::plane) half.y = 0;
        const glm::dmat3 spread(world_from_object);
        const glm::dmat3 object_from_sheet = glm::inverse(spread) * sheet.world_from_mesh;
        const glm::dvec3 centre = glm::dvec3(world_from_object[3]) - scene.origin;
        const glm::dvec3 offset = glm::inverse(spread) * -centre;
        for (int row = 0; row < 3; ++row) {
            for (int k = 0; k < 3; ++k) shape.rows[row][k] = static_cast<Real>(object_from_sheet[k][row]);
            shape.rows[row][3] = static_cast<Real>(offset[row]);
            shape.half[row] = static_cast<Real>(half[row]);
        }
        const double size = glm::length(spread[0]) * half.x + glm::length(spread[1]) * half.y +
                            glm::length(spread[2]) * half.z;
        if (!std::isfinite(size)) continue;
        beyond = std::max(beyond, glm::length(centre) + size);
        known_ |= object_bit(i);
    }
    double widest = 0;
    for (const glm::dvec3& position : scene.water->mesh.positions)
        widest = std::max(widest, glm::length(position - scene.origin));
    beyond_ = static_cast<Real>(beyond + widest);
}

template <class Real>
void ShadowShapes<Real>::darken(ObjectSet set, const WayLanes<Real>& ways, LitParts<Real>& lit) const {
    using L = Lanes<Real>;
    for (; set != 0 && lit.any_lit(); set &= set - 1) {
        const Shape& shape = shapes_[static_cast<std::size_t>(std::countr_zero(set))];
        Sweep<L> sweep;
        for (int i = 0; i < 3; ++i) {
            const auto &from = ways.from[i], &to = ways.to[i];
            const L a = to.a - from.a, b = to.b - from.b, depth = to.depth - from.depth;
            for (int k = 0; k < 3; ++k) {
                const Real(&row)[4] = shape.rows[k];
                sweep.from[i][k] =
                    multiply_add(splat(row[0]), from.a,
                                 multiply_add(splat(row[1]), from.b,
                                              multiply_add(splat(row[2]), from.depth, splat(row[3]))));
                sweep.way[i][k] =
                    multiply_add(splat(row[0]), a, multiply_add(splat(row[1]), b, splat(row[2]) * depth));
            }
        }
        Shadow<Real> shadow(lit.lanes());
        if (shape.shape == scene::Shape::sphere)
            clip_to_sphere(sweep, shape.half[0], shadow);
        else
            clip_to_box(sweep, shape.half, shadow);
        if (!shadow.none()) lit.darken(shadow.first, shadow.last);
    }
}

template class ShadowShapes<float>;
template class ShadowShapes<double>;

}  // namespace dapple::methods::sliced_beams
