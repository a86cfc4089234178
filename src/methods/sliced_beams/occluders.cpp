#include "methods/sliced_beams/occluders.h"

#include <algorithm>
#include <cmath>

#include "scene/transform.h"

namespace dapple::methods::sliced_beams {
namespace {

Bounds shape_bounds(const scene::Object& object, const scene::TriangleMesh* mesh) {
    if (mesh) {
        Bounds bounds;
        for (const glm::dvec3& position : mesh->positions) bounds.widen(position);
        return bounds;
    }
    glm::dvec3 half = 0.5 * object.size;
    if (object.shape == scene::Shape::plane) half.y = 0;
    if (object.shape == scene::Shape::sphere) half = glm::dvec3(object.radius);
    return {-half, half};
}

bool is_finite(const Bounds& b) {
    return std::isfinite(glm::dot(b.low, b.low) + glm::dot(b.high, b.high));
}

bool overlap(const Bounds& x, const Bounds& y) {
    return glm::all(glm::lessThanEqual(x.low, y.high)) && glm::all(glm::greaterThanEqual(x.high, y.low));
}

}  // namespace

bool may_meet(const Bounds& from, const Bounds& to, const Bounds& object) {
    if (!is_finite(from) || !is_finite(to) || !is_finite(object)) return true;
    for (int axis = 0; axis < 3; ++axis) {
        // Along an axis on which the boxes lie apart, the object's interval bounds the part s of the way on
        // which a segment is beside it: v = f + s (t - f) gives the least s for the largest f and t.
        const double sign = to.low[axis] > from.high[axis] ? 1 : -1;
        if (sign < 0 && to.high[axis] >= from.low[axis]) continue;
        const double from_low = sign > 0 ? from.low[axis] : -from.high[axis];
        const double from_high = sign > 0 ? from.high[axis] : -from.low[axis];
        const double to_low = sign > 0 ? to.low[axis] : -to.high[axis];
        const double to_high = sign > 0 ? to.high[axis] : -to.low[axis];
        const double object_low = sign > 0 ? object.low[axis] : -object.high[axis];
        const double object_high = sign > 0 ? object.high[axis] : -object.low[axis];
        const double first = (object_low - from_high) / (to_high - from_high);
        const double last = (object_high - from_low) / (to_low - from_low);
        if (first > 1 || last < 0) return false;
        Bounds beside;
        for (const double s : {std::max(first, 0.0), std::min(last, 1.0)}) {
            beside.widen(glm::mix(from.low, to.low, s));
            beside.widen(glm::mix(from.high, to.high, s));
        }
        if (!overlap(beside, object)) return false;
    }
    return overlap({glm::min(from.low, to.low), glm::max(from.high, to.high)}, object);
}

template <class Real>
Occluders::Occluders(const scene::FrameScene& scene, const light::BeamSheet<Real>& sheet)
    : to_sun_(-sheet.light_direction),
      lamp_(scene.state.lights[static_cast<std::size_t>(sheet.light)].position - scene.origin) {
    const glm::dmat3 sheet_from_world = glm::transpose(sheet.world_from_mesh);
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) {
        const scene::Object& object = scene.state.objects[i];
        const scene::TriangleMesh* mesh =
            i < scene.object_meshes.size() ? scene.object_meshes[i].get() : nullptr;
        const glm::dmat4 world_from_object = scene::world_from_object(object.transform);
        const Bounds shape = shape_bounds(object, mesh);
        Object entry{object.shape == scene::Shape::plane,
                     object.shape != scene::Shape::mesh,
                     glm::dvec3(world_from_object[3]) - scene.origin,
                     {},
                     {}};
        for (int k = 0; k < 8; ++k) {
            const glm::dvec3 world =
                glm::dvec3(world_from_object * glm::dvec4(shape.corner(k), 1)) - scene.origin;
            entry.in_world.widen(world);
            entry.in_sheet.widen(sheet_from_world * world);
        }
        // Room for the rounding of rays and receivers.
        for (Bounds* bounds : {&entry.in_sheet, &entry.in_world}) {
            const glm::dvec3 room = 1e-5 * (1.0 + glm::max(glm::abs(bounds->low), glm::abs(bounds->high)));
            bounds->low -= room;
            bounds->high += room;
        }
        if (is_finite(entry.in_world))
            beyond_ = std::max(
                beyond_, glm::length(glm::max(glm::abs(entry.in_world.low), glm::abs(entry.in_world.high))));
        objects_.push_back(entry);
    }
}

bool Occluders::free_after_water(const Bounds (&surface)[2], const Bounds (&receivers)[2],
                                 std::uint32_t own) const {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        const Object& object = objects_[i];
        if (i == own) continue;
        if (may_meet(surface[0], receivers[0], object.in_sheet) &&
            may_meet(surface[1], receivers[1], object.in_world))
            return false;
    }
    return true;
}

double Occluders::first_depth(const Bounds (&surface)[2], const Bounds (&receivers)[2]) const {
    double first = std::numeric_limits<double>::infinity();
    for (const Object& object : objects_)
        if (may_meet(surface[0], receivers[0], object.in_sheet) &&
            may_meet(surface[1], receivers[1], object.in_world))
            first = std::min(first, object.in_sheet.low.z);
    return first;
}

ObjectSet Occluders::after_water(const Bounds (&surface)[2], const Bounds (&receivers)[2]) const {
    ObjectSet set = 0;
    for (std::size_t i = 0; i < objects_.size(); ++i)
        if (may_meet(surface[0], receivers[0], objects_[i].in_sheet) &&
            may_meet(surface[1], receivers[1], objects_[i].in_world))
            set |= object_bit(i);
    return set;
}

Bounds Occluders::source_of(const Bounds& surface, double spread) const {
    if (to_sun_ == glm::dvec3(0)) return {lamp_, lamp_};
    const glm::dvec3 size = glm::max(glm::abs(surface.low), glm::abs(surface.high));
    const glm::dvec3 way = 2 * (beyond_ + glm::length(size)) * to_sun_;
    const double wider = spread * glm::length(way);
    return {surface.low + way - wider, surface.high + way + wider};
}

bool Occluders::free_before_water(const Bounds& surface, double spread) const {
    return before_water(surface, spread) == 0;
}

ObjectSet Occluders::before_water(const Bounds& surface, double spread) const {
    const Bounds source = source_of(surface, spread);
    ObjectSet set = 0;
    for (std::size_t i = 0; i < objects_.size(); ++i)
        if (may_meet(surface, source, objects_[i].in_world)) set |= object_bit(i);
    return set;
}

template Occluders::Occluders(const scene::FrameScene&, const light::BeamSheet<float>&);
template Occluders::Occluders(const scene::FrameScene&, const light::BeamSheet<double>&);

}  // namespace dapple::methods::sliced_beams
