#include "methods/adaptive_beams/surface_jumps.h"

#include <cmath>

namespace dapple::methods::adaptive_beams {
namespace {

/// Of the distance between two points of a surface, by how much the plane at one of them may miss the other.
constexpr double kSmooth = 0.25;
/// Of the distance between the ends of an edge, what a jump in it has at least. Before an outline a millionth
/// of the edge has a thousandth of the change of depth.
constexpr double kOfEdge = 0.1;

/// m: along a ray, from the point that it meets to the plane in which another ray meets the surface.
double miss(const glm::dvec3& direction, const VertexPaths& met, const VertexPaths& plane) {
    const double off = glm::dot(plane.position - met.position, plane.normal);
    return std::abs(off / glm::dot(direction, plane.normal));
}

}  // namespace

bool may_jump(const LightView& view, const TracedRays& rays, const RayEdge& edge) {
    const VertexPaths &a = rays.paths[edge[0]], &b = rays.paths[edge[1]];
    const double room = kSmooth * glm::distance(a.position, b.position);
    // Not a number where a ray lies in the other's plane.
    return !(miss(view.ray(rays.uv[edge[1]]).direction, b, a) <= room &&
             miss(view.ray(rays.uv[edge[0]]).direction, a, b) <= room);
}

std::vector<std::optional<RayEdge>> surface_jumps(const PathTracer& tracer, TracedRays& rays,
                                                  const std::vector<RayEdge>& edges) {
    const auto change = [&](std::uint32_t from, std::uint32_t to) {
        return std::abs(rays.paths[to].distance - rays.paths[from].distance);
    };
    // The half in which depth changes by more. Next to an outline, where rounding decides, a ray may meet a
    // wave from behind.
    const auto nearer_first = [&](const RayEdge&, const RayEdge& ends, std::uint32_t probe) {
        return rays.paths[probe].on_body ? std::optional(change(ends[0], probe) < change(probe, ends[1]))
                                         : std::nullopt;
    };
    const std::vector<RayEdge> found = halve(tracer, rays, edges, nearer_first);
    std::vector<std::optional<RayEdge>> jumps(edges.size());
    for (std::size_t i = 0; i < edges.size(); ++i)
        if (change(found[i][0], found[i][1]) >
            kOfEdge * glm::distance(rays.paths[edges[i][0]].position, rays.paths[edges[i][1]].position))
            jumps[i] = found[i];
    return jumps;
}

}  // namespace dapple::methods::adaptive_beams
