#include "methods/sliced_beams/scatter_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {

template <class Real>
ScatterBounds<Real>::ScatterBounds(const light::BeamSheet<Real>& sheet, const BeamPyramid<Real>& pyramid,
                                   std::span<const glm::uvec3> triangles, std::span<const Real> stops)
    : sheet_(sheet), pyramid_(pyramid) {
    if (pyramid.empty()) return;
    const Real nearest = pyramid.nearest();
    // Where nothing lies below the water any depth will do.
    const Real farthest = std::max(pyramid.farthest(), nearest + Real(1));
    for (int i = 0; i <= kSlabs; ++i) {
        Slab& slab = slabs_.emplace_back();
        slab.from = nearest + (farthest - nearest) * static_cast<Real>(i) / kSlabs;
        slab.to = i == kSlabs ? std::numeric_limits<Real>::infinity()
                              : nearest + (farthest - nearest) * static_cast<Real>(i + 1) / kSlabs;
        build(slab, triangles, stops);
    }
    const Node& root = slabs_.back().levels.back().front();
    largest_ = std::max({std::abs(root.low_a), std::abs(root.high_a), std::abs(root.low_b),
                         std::abs(root.high_b), std::abs(farthest)});
}

template <class Real>
typename ScatterBounds<Real>::Node ScatterBounds<Real>::united(const Node& x, const Node& y, Real height) {
    Node n;
    n.low_a = std::min(x.low_a, y.low_a);
    n.high_a = std::max(x.high_a, y.high_a);
    n.low_b = std::min(x.low_b, y.low_b);
    n.high_b = std::max(x.high_b, y.high_b);
    // Both ends' extremes, joined: all that lies between is bounded, too. Without an end, the fastest growth.
    const auto grows = [&](Real at, Real x_at, Real x_grows, Real y_at, Real y_grows, auto&& extreme) {
        if (!std::isfinite(height)) return extreme(x_grows, y_grows);
        return (extreme(x_at + height * x_grows, y_at + height * y_grows) - at) / height;
    };
    const auto least = [](Real p, Real q) { return std::min(p, q); };
    const auto most = [](Real p, Real q) { return std::max(p, q); };
    n.low_grows_a = grows(n.low_a, x.low_a, x.low_grows_a, y.low_a, y.low_grows_a, least);
    n.high_grows_a = grows(n.high_a, x.high_a, x.high_grows_a, y.high_a, y.high_grows_a, most);
    n.low_grows_b = grows(n.low_b, x.low_b, x.low_grows_b, y.low_b, y.low_grows_b, least);
    n.high_grows_b = grows(n.high_b, x.high_b, x.high_grows_b, y.high_b, y.high_grows_b, most);
    n.first_start = std::min(x.first_start, y.first_start);
    n.last_start = std::max(x.last_start, y.last_start);
    n.stop = std::max(x.stop, y.stop);
    return n;
}

template <class Real>
void ScatterBounds<Real>::build(Slab& slab, std::span<const glm::uvec3> triangles,
                                std::span<const Real> stops) const {
    const Real height = slab.to - slab.from;
    const auto ray_node = [&](std::uint32_t vertex, Real stop) {
        const auto& ray = sheet_.rays[vertex];
        const Real a = ray.a + slab.from * ray.slope_a, b = ray.b + slab.from * ray.slope_b;
        return Node{a,
                    a,
                    b,
                    b,
                    ray.slope_a,
                    ray.slope_a,
                    ray.slope_b,
                    ray.slope_b,
                    sheet_.start[vertex],
                    sheet_.start[vertex],
                    stop};
    };
    slab.levels.resize(pyramid_.levels());
    for (std::size_t level = 0; level < slab.levels.size(); ++level) {
        std::vector<Node>& nodes = slab.levels[level];
        const std::size_t columns = pyramid_.columns(level);
        nodes.resize(pyramid_.rows(level) * columns);
        parallel_for(nodes.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const NodeId id{static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(i / columns),
                                static_cast<std::uint32_t>(i % columns)};
                nodes[i] = Node{};
                nodes[i].stop = -std::numeric_limits<Real>::infinity();
                bool first = true;
                const auto add = [&](const Node& part) {
                    nodes[i] = first ? part : united(nodes[i], part, height);
                    first = false;
                };
                if (level > 0) {
                    pyramid_.visit_children(id, [&](NodeId child) {
                        if (!pyramid_.dark(child)) add(slab.levels[level - 1][pyramid_.index(child)]);
                    });
                    continue;
                }
                for (const std::uint32_t beam : pyramid_.beams(id)) {
                    if (beam == kNoBeam || !(sheet_.flux[beam] > 0)) continue;
                    const Real stop = stops.empty() ? std::numeric_limits<Real>::infinity() : stops[beam];
                    for (int k = 0; k < 3; ++k) add(ray_node(triangles[beam][k], stop));
                }
            }
        });
    }
}

template <class Real>
void ScatterBounds<Real>::leave_out(std::vector<std::uint8_t> clusters) {
    left_out_.clear();
    if (pyramid_.empty()) return;
    left_out_.push_back(std::move(clusters));
    for (std::size_t level = 1; level < pyramid_.levels(); ++level) {
        const std::size_t columns = pyramid_.columns(level);
        const std::vector<std::uint8_t>& finer = left_out_.back();
        std::vector<std::uint8_t> nodes(pyramid_.rows(level) * columns, 1);
        for (std::size_t i = 0; i < nodes.size(); ++i)
            pyramid_.visit_children(
                {static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(i / columns),
                 static_cast<std::uint32_t>(i % columns)},
                [&](NodeId child) { nodes[i] &= finer[pyramid_.index(child)]; });
        left_out_.push_back(std::move(nodes));
    }
}

template class ScatterBounds<float>;
template class ScatterBounds<double>;

}  // namespace dapple::methods::sliced_beams
