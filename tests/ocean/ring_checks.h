#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <utility>
#include <vector>

#include "ocean/ring_layout.h"
#include "scene/mesh.h"

namespace dapple::ocean {

inline double projected_area(const scene::TriangleMesh& mesh, glm::uvec3 t) {
    const glm::dvec3& a = mesh.positions[t.x];
    return 0.5 * glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a).y;
}

/// Every triangle faces the air, every side within the extent has two triangles that run along it in opposite
/// ways, and no vertex is left over. `undisplaced`: the mesh ends at the extent's edges, and covers it once.
inline void expect_one_sheet(const scene::TriangleMesh& mesh, const scene::Extent& extent, bool undisplaced) {
    const glm::dvec2 low = extent.center - 0.5 * extent.size, high = low + extent.size;
    double area = 0;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;  // each way
    for (const glm::uvec3& t : mesh.triangles) {
        const double projected = projected_area(mesh, t);
        ASSERT_GT(projected, 0);
        area += projected;
        for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
    }
    std::vector<bool> used(mesh.positions.size());
    double edge = 0;
    std::map<std::uint32_t, int> ends;  // of sides with one triangle
    for (const auto& [side, count] : sides) {
        ASSERT_EQ(count, 1);
        used[side.first] = true;
        if (sides.count({side.second, side.first}) == 1) continue;
        ++ends[side.first];
        --ends[side.second];
        const glm::dvec3 &a = mesh.positions[side.first], &b = mesh.positions[side.second];
        if (undisplaced) {
            const bool along_x = a.z == b.z && (a.z == low.y || a.z == high.y);
            const bool along_z = a.x == b.x && (a.x == low.x || a.x == high.x);
            ASSERT_TRUE(along_x || along_z) << "else it lies along the extent's edge";
        }
        edge += std::abs(a.x - b.x) + std::abs(a.z - b.z);
    }
    for (const auto& [vertex, open] : ends) ASSERT_EQ(open, 0) << "the edge is closed";
    EXPECT_EQ(std::count(used.begin(), used.end(), false), 0) << "vertices of no triangle";
    if (!undisplaced) return;
    // Round-off of some 30 000 additions, at most as many times 2e-16 each.
    EXPECT_NEAR(area, extent.size.x * extent.size.y, 1e-11 * extent.size.x * extent.size.y);
    EXPECT_NEAR(edge, 2 * (extent.size.x + extent.size.y), 1e-9);
}

/// The finest level that has a vertex over a place (x, z).
inline int finest_level(const RingLayout& layout, const scene::Extent& extent, glm::dvec2 viewpoint,
                        glm::dvec2 place) {
    for (int level = 0;; ++level) {
        const glm::dvec2 line = (place - extent.center + 0.5 * extent.size) / layout.cell(level);
        const bool on_lattice = glm::length(line - glm::round(line)) < 1e-6;
        if (on_lattice && layout.box(level, viewpoint).holds(glm::ivec2(glm::round(line)))) return level;
    }
}

/// Heights of a mesh as a function of the place, by the triangle there.
class HeightField {
public:
    explicit HeightField(const scene::TriangleMesh& mesh) : mesh_(mesh) {}
    double at(glm::dvec2 place, glm::dvec2* slope = nullptr) const {
        for (const glm::uvec3& t : mesh_.triangles) {
            const glm::dvec3 &a = mesh_.positions[t.x], &b = mesh_.positions[t.y], &c = mesh_.positions[t.z];
            const glm::dvec2 pa(a.x, a.z), ab = glm::dvec2(b.x, b.z) - pa, ac = glm::dvec2(c.x, c.z) - pa,
                                           ap = place - pa;
            const double whole = ab.x * ac.y - ab.y * ac.x;
            const double v = (ap.x * ac.y - ap.y * ac.x) / whole, w = (ab.x * ap.y - ab.y * ap.x) / whole;
            if (!(v >= 0 && w >= 0 && v + w <= 1)) continue;
            if (slope) {
                const auto of = [&](std::uint32_t i) {
                    const glm::dvec3& n = mesh_.normals[i];
                    return glm::dvec2(-n.x, -n.z) / n.y;
                };
                *slope = (1 - v - w) * of(t.x) + v * of(t.y) + w * of(t.z);
            }
            return (1 - v - w) * a.y + v * b.y + w * c.y;
        }
        return std::nan("");
    }

private:
    const scene::TriangleMesh& mesh_;
};

}  // namespace dapple::ocean
