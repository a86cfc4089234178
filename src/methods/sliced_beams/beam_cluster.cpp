#include "methods/sliced_beams/beam_cluster.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {
namespace {

template <class Real>
void add_beam(BeamCluster<Real>& cluster, std::uint32_t (&known)[BeamCluster<Real>::kMost],
              std::uint32_t beam, const SheetCoverage<Real>& coverage, const BeamWays<Real>& ways) {
    const glm::uvec3& triangle = coverage.triangles()[beam];
    typename BeamCluster<Real>::Beam& added = cluster.beam[cluster.beams++];
    added.triangle = beam;
    added.shade = ways.shade(beam);
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t vertex = triangle[k];
        const auto& ray = coverage.sheet().rays[vertex];
        const std::uint32_t* const end = known + cluster.vertices;
        const std::uint32_t* const place = std::find<const std::uint32_t*>(known, end, vertex);
        added.corner[k] = static_cast<std::uint8_t>(place - known);
        if (place == end) {
            known[cluster.vertices] = vertex;
            cluster.ray[cluster.vertices++] = {ray.a, ray.b, ray.slope_a, ray.slope_b,
                                               coverage.sheet().start[vertex]};
        }
        cluster.first_start = std::min(cluster.first_start, coverage.sheet().start[vertex]);
        cluster.last_start = std::max(cluster.last_start, coverage.sheet().start[vertex]);
        const Real stretch = std::sqrt(1 + ray.slope_a * ray.slope_a + ray.slope_b * ray.slope_b);
        cluster.least_stretch = std::min(cluster.least_stretch, stretch);
        cluster.most_stretch = std::max(cluster.most_stretch, stretch);
        if (added.shade & BeamWays<Real>::kCut)
            cluster.first_stop = std::min(cluster.first_stop, ways.stop(vertex));
    }
    for (int k = 0; k < 3; ++k) {
        const std::uint8_t from = added.corner[(k + 1) % 3], to = added.corner[(k + 2) % 3];
        int e = 0;
        for (; e < cluster.edges; ++e) {
            const auto& edge = cluster.edge[e];
            if ((edge.from == from && edge.to == to) || (edge.from == to && edge.to == from)) break;
        }
        if (e == cluster.edges) cluster.edge[cluster.edges++] = {from, to};
        added.edge[k] = static_cast<std::uint8_t>(e);
        added.turned[k] = cluster.edge[e].from == from ? 0 : 1;
    }
}

}  // namespace

template <class Real>
std::vector<BeamCluster<Real>> beam_clusters(const SheetCoverage<Real>& coverage,
                                             const BeamWays<Real>& ways) {
    const BeamPyramid<Real>& pyramid = coverage.pyramid();
    if (pyramid.empty()) return {};
    const std::size_t columns = pyramid.columns(0);
    std::vector<BeamCluster<Real>> clusters(pyramid.rows(0) * columns);
    parallel_for(clusters.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t row = i / columns, column = i % columns;
            std::uint32_t vertices[BeamCluster<Real>::kMost];
            for (const std::uint32_t beam :
                 pyramid.beams({0, static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column)}))
                if (beam != kNoBeam && coverage.sheet().flux[beam] > 0 &&
                    !(ways.shade(beam) & BeamWays<Real>::kDark))
                    add_beam(clusters[i], vertices, beam, coverage, ways);
        }
    });
    return clusters;
}

template std::vector<BeamCluster<float>> beam_clusters(const SheetCoverage<float>&, const BeamWays<float>&);
template std::vector<BeamCluster<double>> beam_clusters(const SheetCoverage<double>&,
                                                        const BeamWays<double>&);

}  // namespace dapple::methods::sliced_beams
