#include "methods/adaptive_beams/edge_search.h"

#include <utility>

namespace dapple::methods::adaptive_beams {
namespace {

/// Halvings of an edge: what is lost is then a millionth of it: lines of black pixels are rare.
constexpr int kHalvings = 20;

}  // namespace

std::vector<RayEdge> halve(const PathTracer& tracer, TracedRays& rays, const std::vector<RayEdge>& edges,
                           const LikeFirst& like_first) {
    // A working ray an end of each edge, in place of thousands that nobody asks for again.
    const std::size_t first = rays.uv.size(), count = edges.size();
    auto brackets = edges;
    std::vector<glm::dvec2> uv(count);
    std::vector<VertexPaths> traced(count);
    rays.uv.resize(first + 3 * count);
    rays.paths.resize(first + 3 * count);
    for (int step = 0; step < kHalvings; ++step) {
        for (std::size_t i = 0; i < count; ++i)
            uv[i] = 0.5 * (rays.uv[brackets[i][0]] + rays.uv[brackets[i][1]]);
        tracer.trace(uv, traced);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t probe = first + 3 * i;
            rays.uv[probe] = uv[i];
            rays.paths[probe] = std::move(traced[i]);
            const std::optional<bool> like =
                like_first(edges[i], brackets[i], static_cast<std::uint32_t>(probe));
            if (!like) continue;
            const std::size_t side = *like ? 0 : 1;
            rays.uv[probe + 1 + side] = uv[i];
            std::swap(rays.paths[probe + 1 + side], rays.paths[probe]);
            brackets[i][side] = static_cast<std::uint32_t>(probe + 1 + side);
        }
    }
    return brackets;
}

}  // namespace dapple::methods::adaptive_beams
