#include "methods/sliced_beams/shadow_shapes.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "scene/transform.h"

namespace dapple::methods::sliced_beams {
namespace {

template <class L>
L within_0_1(const L& x) {
    using Real = std::remove_cvref_t<decltype(x[0])>;
    return lesser(greater(x, L{}), splat(Real(1)));  // 0 where it is not a number
}

/// The least of how far a way lies within the box's slabs, where it lies deepest in them, or nearly so: in
/// the middle of what the slabs have in common, or of the gap between them.
template <class L, class Real>
L depth_in_box(const L (&from)[3], const L (&way)[3], const Real (&half)[3]) {
    L enter{}, leave = splat(Real(1));
    for (int k = 0; k < 3; ++k) {
        const L inverse = Real(1) / way[k];
        const L low = (-half[k] - from[k]) * inverse, high = (half[k] - from[k]) * inverse;
        enter = greater(lesser(low, high), enter);
        leave = lesser(greater(low, high), leave);
    }
    const L middle = within_0_1(Real(0.5) * (enter + leave));
    L depth = half[0] - magnitude(multiply_add(middle, way[0], from[0]));
    for (int k = 1; k < 3; ++k)
        depth = lesser(depth, half[k] - magnitude(multiply_add(middle, way[k], from[k])));
    return depth;
}

template <class L, class Real>
L depth_in_sphere(const L (&from)[3], const L (&way)[3], Real radius) {
    const auto dot = [](const L(&x)[3], const L(&y)[3]) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
    const L nearest = within_0_1(-dot(from, way) / dot(way, way));
    L at[3];
    for (int k = 0; k < 3; ++k) at[k] = multiply_add(nearest, way[k], from[k]);
    return radius - square_root<Real>(dot(at, at));
}

/// How far the nearer end lies beyond the plane's rectangle.
template <class L, class Real>
L depth_in_plane(const L (&from)[3], const L (&way)[3], const Real (&half)[3]) {
    const L to = from[1] + way[1];
    const auto crosses = (from[1] < 0) ^ (to < 0);
    const L nearer = lesser(magnitude(from[1]), magnitude(to));
    const L at = within_0_1(-from[1] / way[1]);
    L depth = crosses ? nearer : -nearer;
    for (const int k : {0, 2}) depth = lesser(depth, half[k] - magnitude(multiply_add(at, way[k], from[k])));
    return depth;
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
Lanes<Real> ShadowShapes<Real>::depth(ObjectSet set, const PointLanes<Real>& from,
                                      const PointLanes<Real>& to) const {
    using L = Lanes<Real>;
    L deepest = splat(std::numeric_limits<Real>::lowest());
    const L way_a = to.a - from.a, way_b = to.b - from.b, way_depth = to.depth - from.depth;
    for (; set != 0; set &= set - 1) {
        const Shape& shape = shapes_[static_cast<std::size_t>(std::countr_zero(set))];
        L origin[3], way[3];
        for (int k = 0; k < 3; ++k) {
            const Real(&row)[4] = shape.rows[k];
            origin[k] = multiply_add(
                splat(row[0]), from.a,
                multiply_add(splat(row[1]), from.b, multiply_add(splat(row[2]), from.depth, splat(row[3]))));
            way[k] = multiply_add(splat(row[0]), way_a,
                                  multiply_add(splat(row[1]), way_b, splat(row[2]) * way_depth));
        }
        const L depth = shape.shape == scene::Shape::box      ? depth_in_box(origin, way, shape.half)
                        : shape.shape == scene::Shape::sphere ? depth_in_sphere(origin, way, shape.half[0])
                                                              : depth_in_plane(origin, way, shape.half);
        deepest = greater(depth, deepest);
    }
    return deepest;
}

template class ShadowShapes<float>;
template class ShadowShapes<double>;

}  // namespace dapple::methods::sliced_beams
