#include "methods/sliced_beams/occluders.h"

#include <algorithm>
#include <limits>

#include "scene/transform.h"

namespace dapple::methods::sliced_beams {
namespace {

void widen(Bounds& bounds, glm::dvec3 point) {
    bounds.low = glm::min(bounds.low, point);
    bounds.high = glm::max(bounds.high, point);
}

Bounds nothing() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {glm::dvec3(infinity), glm::dvec3(-infinity)};
}

template <class Visit>
void visit_corners(const Bounds& bounds, Visit&& visit) {
    for (int i = 0; i < 8; ++i)
        visit(glm::dvec3(i & 1 ? bounds.high.x : bounds.low.x, i & 2 ? bounds.high.y : bounds.low.y,
                         i & 4 ? bounds.high.z : bounds.low.z));
}

Bounds shape_bounds(const scene::Object& object, const scene::TriangleMesh* mesh) {
    if (mesh) {
        Bounds bounds = nothing();
        for (const glm::dvec3& position : mesh->positions) widen(bounds, position);
        return bounds;
    }
    glm::dvec3 half = 0.5 * object.size;
    if (object.shape == scene::Shape::plane) half.y = 0;
    if (object.shape == scene::Shape::sphere) half = glm::dvec3(object.radius);
    return {-half, half};
}

/// Rows: two axes across `direction`, and itself.
glm::dmat3 across(glm::dvec3 direction) {
    const glm::dvec3 helper = std::abs(direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(helper, direction));
    return glm::transpose(glm::dmat3(u, glm::cross(direction, u), direction));
}

bool overlap(const Bounds& x, const Bounds& y) {
    return glm::all(glm::lessThanEqual(x.low, y.high)) && glm::all(glm::greaterThanEqual(x.high, y.low));
}

}  // namespace

template <class Real>
Occluders::Occluders(const scene::FrameScene& scene, const light::BeamSheet<Real>& sheet)
    : sheet_from_world_(glm::transpose(sheet.world_from_mesh)),
      world_from_sheet_(sheet.world_from_mesh),
      light_from_world_(1.0),
      sun_(sheet.light_direction != glm::dvec3(0)),
      light_position_(scene.state.lights[static_cast<std::size_t>(sheet.light)].position - scene.origin) {
    if (sun_) light_from_world_ = across(sheet.light_direction);
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) {
        const scene::Object& object = scene.state.objects[i];
        const scene::TriangleMesh* mesh =
            i < scene.object_meshes.size() ? scene.object_meshes[i].get() : nullptr;
        const glm::dmat4 world_from_object = scene::world_from_object(object.transform);
        Object entry{object.shape != scene::Shape::mesh, nothing(), nothing(), nothing()};
        visit_corners(shape_bounds(object, mesh), [&](glm::dvec3 corner) {
            const glm::dvec3 world = glm::dvec3(world_from_object * glm::dvec4(corner, 1)) - scene.origin;
            widen(entry.across_sheet, sheet_from_world_ * world);
            widen(entry.across_light, light_from_world_ * world);
            widen(entry.world, world);
        });
        // Room for the rounding of rays and receivers.
        for (Bounds* bounds : {&entry.across_sheet, &entry.across_light, &entry.world}) {
            const glm::dvec3 room = 1e-5 * (1.0 + glm::max(glm::abs(bounds->low), glm::abs(bounds->high)));
            bounds->low -= room;
            bounds->high += room;
        }
        objects_.push_back(entry);
    }
}

bool Occluders::free_after_water(const Box<double>& surface, double nearest, const Box<double>& receivers,
                                 double low, double high, std::uint32_t own) const {
    const auto mix = [](double from, double to, double t) { return from + t * (to - from); };
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        const Object& object = objects_[i];
        if (i == own && object.convex) continue;
        const Bounds& o = object.across_sheet;
        if (o.low.z > high || o.high.z < nearest) continue;
        // A ray to a receiver at depth d has done the share (depth - nearest) / (d - nearest) of its way.
        bool meets_a = false, meets_b = false;
        double low_a = 1e300, high_a = -1e300, low_b = 1e300, high_b = -1e300;
        for (const double depth : {std::max(o.low.z, nearest), std::min(o.high.z, high)}) {
            const double way = high - nearest;
            const double t = way > 0 ? std::clamp((std::min(depth, low) - nearest) / way, 0.0, 1.0) : 1;
            low_a = std::min(low_a, mix(surface.low_a, receivers.low_a, t));
            high_a = std::max(high_a, mix(surface.high_a, receivers.high_a, t));
            low_b = std::min(low_b, mix(surface.low_b, receivers.low_b, t));
            high_b = std::max(high_b, mix(surface.high_b, receivers.high_b, t));
        }
        meets_a = o.low.x <= high_a && o.high.x >= low_a;
        meets_b = o.low.y <= high_b && o.high.y >= low_b;
        if (meets_a && meets_b) return false;
    }
    return true;
}

bool Occluders::free_before_water(const Box<double>& surface, double nearest, double farthest) const {
    Bounds entry = nothing();
    visit_corners({{surface.low_a, surface.low_b, nearest}, {surface.high_a, surface.high_b, farthest}},
                  [&](glm::dvec3 corner) {
                      const glm::dvec3 world = world_from_sheet_ * corner;
                      widen(entry, sun_ ? light_from_world_ * world : world);
                  });
    if (sun_)
        entry.low.z = -std::numeric_limits<double>::infinity();
    else
        widen(entry, light_position_);
    return std::none_of(objects_.begin(), objects_.end(), [&](const Object& object) {
        return overlap(entry, sun_ ? object.across_light : object.world);
    });
}

template Occluders::Occluders(const scene::FrameScene&, const light::BeamSheet<float>&);
template Occluders::Occluders(const scene::FrameScene&, const light::BeamSheet<double>&);

}  // namespace dapple::methods::sliced_beams
