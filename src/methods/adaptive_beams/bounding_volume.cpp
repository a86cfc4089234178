#include "methods/adaptive_beams/bounding_volume.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace dapple::methods::adaptive_beams {
namespace {

using Triangle = std::array<glm::dvec2, 3>;

/// Share of a cap's size by which two candidates for a side must differ.
constexpr double kUnique = 1e-5;
/// A cap whose inscribed circle is smaller than so many margins would grow long spikes.
constexpr double kLeastInradius = 4;

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

std::array<glm::dvec2, 3> normals(const Triangle& t) {
    return {outward(t, 0), outward(t, 1), outward(t, 2)};
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
    std::array<glm::dvec2, 3> normal{glm::dvec2(0, 1), glm::dvec2(-std::sqrt(0.75), -0.5),
                                     glm::dvec2(std::sqrt(0.75), -0.5)};
    if (has_width(beam.near))
        normal = normals(beam.near);
    else if (has_width(beam.far))
        normal = normals(beam.far);
    BoundingVolume volume;
    volume.kind = VolumeKind::prism;
    set_corners(volume, enclosing(beam.near, normal, beam.near_margin), beam.near_depth,
                enclosing(beam.far, normal, beam.far_margin), beam.far_depth);
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

std::optional<BoundingVolume> six_triangles(const BeamSection& beam) {
    const auto wide = [](const Triangle& t, double margin) {
        return has_width(t) && std::abs(twice_area(t)) > kLeastInradius * margin * perimeter(t);
    };
    if (!wide(beam.near, beam.near_margin) || !wide(beam.far, beam.far_margin)) return std::nullopt;
    const Triangle near = enclosing(beam.near, normals(beam.near), beam.near_margin);
    const Triangle far = enclosing(beam.far, normals(beam.far), beam.far_margin);
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

}  // namespace

BoundingVolume bounding_volume(const BeamSection& beam, VolumeKind wanted) {
    std::optional<BoundingVolume> hull;
    if (wanted == VolumeKind::six_triangles) hull = six_triangles(beam);
    BoundingVolume volume = hull ? *hull : prism(beam);
    glm::dvec3 middle(0);
    for (const glm::dvec3& corner : volume.corner) middle += corner / 6.0;
    for (auto& face : volume.face) orient(volume, middle, face);
    return volume;
}

}  // namespace dapple::methods::adaptive_beams
