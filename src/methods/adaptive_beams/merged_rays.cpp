#include "methods/adaptive_beams/merged_rays.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr std::size_t kTile = 64;
/// Triangles that hold fewer texels are left to their corners.
constexpr double kLeastTexels = 8;
/// rad: where normals are within this of what the corners give, root mean square, waves are resolved. Over a
/// way of ten widths of a beam of n = 4 / 3, its width would be off by a fortieth.
constexpr double kResolved = 0.01;

/// What the texels in a triangle say.
struct Footprint {
    double texels = 0;                   // 0: too few, or not all on the body
    double deviation = 0;                // rad^2, sum over texels
    glm::dvec2 entry{0};                 // sum over texels, by light::Event
    std::array<glm::dvec3, 3> normal{};  // sums weighted by the barycentric coordinates
};

Footprint footprint_of(const std::array<glm::dvec2, 3>& corner, const std::array<glm::dvec3, 3>& normal,
                       std::span<const SurfaceTexel> texels, int side) {
    Footprint found;
    const glm::dvec2 ab = corner[1] - corner[0], ac = corner[2] - corner[0];
    const double area = ab.x * ac.y - ab.y * ac.x;
    if (0.5 * std::abs(area) < kLeastTexels) return found;
    const glm::dvec2 low = glm::min(corner[0], glm::min(corner[1], corner[2]));
    const glm::dvec2 high = glm::max(corner[0], glm::max(corner[1], corner[2]));
    const glm::ivec2 first = glm::clamp(glm::ivec2(low), 0, side - 1);
    const glm::ivec2 last = glm::clamp(glm::ivec2(high), 0, side - 1);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            const glm::dvec2 at = glm::dvec2(x, y) + 0.5 - corner[0];
            const double of_b = (at.x * ac.y - at.y * ac.x) / area;
            const double of_c = (ab.x * at.y - ab.y * at.x) / area;
            const double of_a = 1 - of_b - of_c;
            if (std::min({of_a, of_b, of_c}) < 0) continue;
            const SurfaceTexel& texel = texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(side) +
                                               static_cast<std::size_t>(x)];
            if (!texel.on_body) return {};
            const glm::dvec3 here(texel.normal);
            const glm::dvec3 off =
                here - glm::normalize(of_a * normal[0] + of_b * normal[1] + of_c * normal[2]);
            ++found.texels;
            found.deviation += glm::dot(off, off);
            found.entry += glm::dvec2(texel.entry);
            found.normal[0] += of_a * here;
            found.normal[1] += of_b * here;
            found.normal[2] += of_c * here;
        }
    return found;
}

/// What the triangles about a vertex say together.
struct Ring {
    bool whole = true;  // all of them have texels
    double texels = 0, deviation = 0;
    glm::dvec3 normal{0};
};

}  // namespace

std::vector<glm::dvec2> merge_waves(const PathTracer& tracer, const ProjectedGrid& grid,
                                    std::span<const SurfaceTexel> texels, int side, TracedRays& rays) {
    const std::vector<ProjectedGrid::Triangle>& triangles = grid.triangles();
    std::vector<Footprint> footprints(triangles.size());
    parallel_for(triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            std::array<glm::dvec2, 3> corner;
            std::array<glm::dvec3, 3> normal;
            bool met = true;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t vertex = triangles[t].vertices[i];
                corner[i] = grid.uv(vertex) * static_cast<double>(side);
                normal[i] = rays.paths[vertex].normal;
                met = met && rays.paths[vertex].on_body;
            }
            if (met) footprints[t] = footprint_of(corner, normal, texels, side);
        }
    });
    std::vector<Ring> rings(grid.vertices());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            Ring& ring = rings[triangles[t].vertices[i]];
            ring.whole = ring.whole && footprints[t].texels > 0;
            ring.texels += footprints[t].texels;
            ring.deviation += footprints[t].deviation;
            ring.normal += footprints[t].normal[i];
        }
    std::vector<std::uint32_t> merged;
    std::vector<glm::dvec2> uv;
    std::vector<glm::dvec3> normals;
    for (std::uint32_t v = 0; v < rings.size(); ++v) {
        const Ring& ring = rings[v];
        if (!ring.whole || !(ring.deviation > kResolved * kResolved * ring.texels)) continue;
        merged.push_back(v);
        uv.push_back(grid.uv(v));
        normals.push_back(glm::normalize(ring.normal));
    }
    std::vector<VertexPaths> traced(merged.size());
    tracer.trace(uv, normals, traced);
    for (std::size_t i = 0; i < merged.size(); ++i) {
        rays.paths[merged[i]] = std::move(traced[i]);
        rays.paths[merged[i]].merged = true;
    }

    std::vector<glm::dvec2> entry(triangles.size(), glm::dvec2(1));
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (!(footprints[t].texels > 0)) continue;
        for (int event = 0; event < 2; ++event) {
            double corners = 0;
            for (const std::uint32_t vertex : triangles[t].vertices)
                corners += rays.paths[vertex].paths[static_cast<std::size_t>(event)].entry.x / 3;
            if (corners > 0) entry[t][event] = footprints[t].entry[event] / (footprints[t].texels * corners);
        }
    }
    return entry;
}

}  // namespace dapple::methods::adaptive_beams
