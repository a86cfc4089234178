#include "methods/adaptive_beams/bounding_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace dapple::methods::adaptive_beams {
namespace {

using Triangle = std::array<glm::dvec2, 3>;

/// Share of a cap's size by which two candidates for a side must differ.
constexpr double kUnique = 1e-5;

double cross(glm::dvec2 a, glm::dvec2 b) {
    return a.x * b.y - a.y * b.x;
}

double twice_area(const Triangle& t) {
    return cross(t[1] - t[0], t[2] - t[0]);
}

double perimeter(const Triangle& t) {
    return glm::length(t[1] - t[0]) + glm::length(t[2] - t[1]) + glm::length(t[0] - t[2]);
}

/// Of the edge that faces corner k.
glm::dvec2 outward(const Triangle& t, int k) {
    const auto i = static_cast<std::size_t>((k + 1) % 3), j = static_cast<std::size_t>((k + 2) % 3);
    const glm::dvec2 edge = glm::normalize(t[j] - t[i]);
    return twice_area(t) > 0 ? glm::dvec2(edge.y, -edge.x) : glm::dvec2(-edge.y, edge.x);
}

bool has_width(const Triangle& t) {
    // The inscribed circle's radius is the area by half the perimeter.
    const double around = perimeter(t);
    return std::abs(twice_area(t)) > 1e-6 * around * around;
}

/// Farthest that a triangle reaches along a direction.
double reach(const Triangle& t, glm::dvec2 direction) {
    return std::max({glm::dot(t[0], direction), glm::dot(t[1], direction), glm::dot(t[2], direction)});
}

/// The triangle with these outward normals about `t`, by `margin` wider.
Triangle enclosing(const Triangle& t, const std::array<glm::dvec2, 3>& normal, double margin) {
    Triangle corners;
    for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec2 p = normal[(k + 1) % 3], q = normal[(k + 2) % 3];
        const double at_p = reach(t, p) + margin, at_q = reach(t, q) + margin;
        corners[k] = glm::dvec2(at_p * q.y - at_q * p.y, at_q * p.x - at_p * q.x) / cross(p, q);
    }
    return corners;
}

/// Outward normals of triangles about one: its own, and those about a box along its longest edge, as slivers
/// grow long spikes with a margin.
std::vector<std::array<glm::dvec2, 3>> choices(const Triangle& t, double margin) {
    std::vector<std::array<glm::dvec2, 3>> normals;
    if (has_width(t)) normals.push_back({outward(t, 0), outward(t, 1), outward(t, 2)});
    glm::dvec2 along(1, 0);
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec2 edge = t[(k + 1) % 3] - t[k];
        if (glm::length(edge) <= longest) continue;
        longest = glm::length(edge);
        along = edge / longest;
    }
    // The flattest triangle about a box of length a and width b has a base of 2 a and a height of 2 b.
    glm::dvec2 across(-along.y, along.x);
    const double length = longest + 2 * margin, thickness = reach(t, across) + reach(t, -across) + 2 * margin;
    if (!(thickness > 0)) return normals;
    const glm::dvec2 steep = glm::normalize(glm::dvec2(2 * thickness, length));
    normals.push_back({-across, steep.x * along + steep.y * across, -steep.x * along + steep.y * across});
    return normals;
}

void set_corners(BoundingVolume& volume, const Triangle& near, double near_depth, const Triangle& far,
                 double far_depth) {
    for (std::size_t k = 0; k < 3; ++k) {
        volume.corner[k] = {near[k], near_depth};
        volume.corner[3 + k] = {far[k], far_depth};
    }
}

/// Turns a face so that it is counter-clockwise from outside: away from the body's middle.
void orient(const BoundingVolume& volume, glm::dvec3 middle, std::array<std::uint8_t, 3>& face) {
    const glm::dvec3 a = volume.corner[face[0]], b = volume.corner[face[1]], c = volume.corner[face[2]];
    if (glm::dot(glm::cross(b - a, c - a), a - middle) < 0) std::swap(face[1], face[2]);
}

BoundingVolume prism(const BeamSection& beam) {
    // About a beam of linear rays the reach along a direction is convex in depth: a body with the same three
    // normals at both depths that holds the caps holds all between them.
    std::vector<std::array<glm::dvec2, 3>> normals = choices(beam.near, beam.near_margin);
    for (const auto& of_far : choices(beam.far, beam.far_margin)) normals.push_back(of_far);
    // For beams without width or margin.
    if (normals.empty())
        normals.push_back(
            {glm::dvec2(0, 1), glm::dvec2(-std::sqrt(0.75), -0.5), glm::dvec2(std::sqrt(0.75), -0.5)});
    BoundingVolume volume;
    volume.kind = VolumeKind::prism;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& normal : normals) {
        const Triangle near = enclosing(beam.near, normal, beam.near_margin),
                       far = enclosing(beam.far, normal, beam.far_margin);
        const double size = std::abs(twice_area(near)) + std::abs(twice_area(far));
        if (!(size < least)) continue;
        least = size;
        set_corners(volume, near, beam.near_depth, far, beam.far_depth);
    }
    volume.face = {{{0, 1, 2}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}}};
    return volume;
}

/// The corner of the other cap farthest out from an edge; none where two are as far.
std::optional<std::uint8_t> farthest(const Triangle& other, glm::dvec2 normal, double least_lead) {
    std::array<double, 3> reaches{};
    for (std::size_t k = 0; k < 3; ++k) reaches[k] = glm::dot(other[k], normal);
    const auto best =
        static_cast<std::size_t>(std::max_element(reaches.begin(), reaches.end()) - reaches.begin());
    for (std::size_t k = 0; k < 3; ++k)
        if (k != best && reaches[best] - reaches[k] <= least_lead) return std::nullopt;
    return static_cast<std::uint8_t>(best);
}

/// The least of the triangles about one; none about one without width or margin.
std::optional<Triangle> tightest(const Triangle& t, double margin) {
    std::optional<Triangle> best;
    for (const auto& normal : choices(t, margin)) {
        const Triangle about = enclosing(t, normal, margin);
        if (has_width(about) && (!best || std::abs(twice_area(about)) < std::abs(twice_area(*best))))
            best = about;
    }
    return best;
}

std::optional<BoundingVolume> six_triangles(const BeamSection& beam) {
    const std::optional<Triangle> about_near = tightest(beam.near, beam.near_margin),
                                  about_far = tightest(beam.far, beam.far_margin);
    if (!about_near || !about_far) return std::nullopt;
    const Triangle &near = *about_near, &far = *about_far;
    BoundingVolume volume;
    volume.kind = VolumeKind::six_triangles;
    set_corners(volume, near, beam.near_depth, far, beam.far_depth);
    volume.face[0] = {0, 1, 2};
    volume.face[1] = {3, 4, 5};
    const double lead = kUnique * (perimeter(near) + perimeter(far));
    std::size_t next = 2;
    for (const int side : {0, 1}) {
        const Triangle& cap = side == 0 ? near : far;
        const Triangle& other = side == 0 ? far : near;
        for (int k = 0; k < 3; ++k) {
            const auto apex = farthest(other, outward(cap, k), lead);
            if (!apex) return std::nullopt;
            const auto corner = [&](int index, bool of_cap) {
                return static_cast<std::uint8_t>(index + (of_cap == (side == 0) ? 0 : 3));
            };
            volume.face[next++] = {corner((k + 1) % 3, true), corner((k + 2) % 3, true),
                                   corner(*apex, false)};
        }
    }
    return volume;
}

/// m^2: a convex body's is four times what it covers of a picture, mean over all views (Cauchy).
double surface(const BoundingVolume& volume) {
    double sum = 0;
    for (const auto& face : volume.face) {
        const glm::dvec3 a = volume.corner[face[0]];
        sum += 0.5 * glm::length(glm::cross(volume.corner[face[1]] - a, volume.corner[face[2]] - a));
    }
    return sum;
}

}  // namespace

BoundingVolume bounding_volume(const BeamSection& beam, VolumeKind wanted) {
    BoundingVolume volume = prism(beam);
    if (wanted == VolumeKind::six_triangles) {
        const std::optional<BoundingVolume> hull = six_triangles(beam);
        if (hull && surface(*hull) < surface(volume)) volume = *hull;
    }
    glm::dvec3 middle(0);
    for (const glm::dvec3& corner : volume.corner) middle += corner / 6.0;
    for (auto& face : volume.face) orient(volume, middle, face);
    return volume;
}

}  // namespace dapple::methods::adaptive_beams
