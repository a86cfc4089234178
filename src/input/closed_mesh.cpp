#include "input/closed_mesh.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <vector>

#include "base/error.h"

namespace dapple::input {
namespace {

bool before(const glm::dvec3& a, const glm::dvec3& b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    return a.z < b.z;
}

/// Of each vertex the first one in its place: files part them where texture or normals do.
std::vector<glm::uint> welded(const std::vector<glm::dvec3>& positions) {
    std::vector<glm::uint> order(positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](glm::uint a, glm::uint b) {
        if (positions[a] == positions[b]) return a < b;
        return before(positions[a], positions[b]);
    });
    std::vector<glm::uint> first(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && positions[order[i]] == positions[order[i - 1]];
        first[order[i]] = same ? first[order[i - 1]] : order[i];
    }
    return first;
}

/// A triangle's side, the lower vertex first; `way` is -1 where the triangle runs along it the other way.
struct Edge {
    glm::uint low, high;
    int way;
};

std::string place_of(const glm::dvec3& position) {
    char text[96];
    std::snprintf(text, sizeof text, "(%.4g, %.4g, %.4g)", position.x, position.y, position.z);
    return text;
}

}  // namespace

void require_closed(const scene::TriangleMesh& mesh, const std::string& path) {
    const std::vector<glm::uint> vertex = welded(mesh.positions);
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    double volume = 0;  // six times
    for (const glm::uvec3& triangle : mesh.triangles) {
        volume += dot(mesh.positions[triangle.x] - mesh.positions[0],
                      cross(mesh.positions[triangle.y] - mesh.positions[0],
                            mesh.positions[triangle.z] - mesh.positions[0]));
        for (int side = 0; side < 3; ++side) {
            const glm::uint a = vertex[triangle[side]], b = vertex[triangle[(side + 1) % 3]];
            if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
        }
    }
    const auto same = [](const Edge& a, const Edge& b) { return a.low == b.low && a.high == b.high; };
    std::sort(edges.begin(), edges.end(),
              [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
    std::size_t open = 0;
    Edge first{};
    for (std::size_t begin = 0; begin < edges.size();) {
        int sum = 0;
        std::size_t end = begin;
        for (; end < edges.size() && same(edges[end], edges[begin]); ++end) sum += edges[end].way;
        if (sum != 0 && open++ == 0) first = edges[begin];
        begin = end;
    }
    if (open > 0) {
        throw Error(ExitCode::input_unreadable,
                    clipped(path) + ": glass needs a closed mesh, but " + std::to_string(open) +
                        " of its edges have no second triangle that fits, such as that from " +
                        place_of(mesh.positions[first.low]) + " to " + place_of(mesh.positions[first.high]));
    }
    if (!(volume > 0)) {
        throw Error(ExitCode::input_unreadable,
                    clipped(path) +
                        ": glass needs a mesh whose triangles are counter-clockwise seen from "
                        "outside; these face inwards, turn them over");
    }
}

}  // namespace dapple::input
