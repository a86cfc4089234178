#include "methods/sliced_beams/scatter_tree.h"

#include <algorithm>

namespace dapple::methods::sliced_beams {
namespace {

using Ways = BeamWays<float>;
using NodeId = BeamPyramid<float>::NodeId;

/// Depths beyond all others, m: the device need not know infinity.
constexpr float kFar = 1e30f;

float finite(float depth) {
    return std::clamp(depth, -kFar, kFar);
}

struct Leaf {
    std::uint32_t first = 0, count = 0;  ///< of ScatterTree::beams
};

void add_beams(const ScatterSheet<float>& sheet, const BeamCluster<float>& cluster, ScatterTree& tree) {
    for (int i = 0; i < cluster.beams; ++i) {
        const auto& beam = cluster.beam[i];
        if (beam.shade & (Ways::kMixedAfter | Ways::kMixedBefore)) continue;
        const glm::uvec3& corner = sheet.coverage().triangles()[beam.triangle];
        const light::BeamSheet<float>& from = sheet.coverage().sheet();
        const std::vector<float>& start = from.start;
        const bool cut = (beam.shade & Ways::kCut) != 0;
        const auto stop = [&](std::uint32_t vertex) {
            return cut ? finite(sheet.ways().stop(vertex)) : kFar;
        };
        tree.beams.push_back({{corner.x, corner.y, corner.z},
                              2 * from.flux[beam.triangle] * from.tint_of(beam.triangle),
                              std::max({start[corner.x], start[corner.y], start[corner.z]}),
                              std::min({stop(corner.x), stop(corner.y), stop(corner.z)})});
    }
}

/// Adds a node with all that lies below it; nothing where that holds no beams.
void add_nodes(const BeamPyramid<float>& pyramid, const ScatterBounds<float>::Slab& slab, NodeId id,
               const std::vector<Leaf>& leaves, std::vector<layout::ScatterNode>& nodes) {
    if (pyramid.dark(id)) return;
    const std::size_t at = pyramid.index(id);
    const Leaf leaf = id.level == 0 ? leaves[at] : Leaf{};
    if (id.level == 0 && leaf.count == 0) return;
    const auto& bounds = slab.levels[id.level][at];
    const std::size_t place = nodes.size();
    nodes.push_back({{bounds.low_a, bounds.high_a, bounds.low_b, bounds.high_b},
                     {bounds.low_grows_a, bounds.high_grows_a, bounds.low_grows_b, bounds.high_grows_b},
                     bounds.first_start,
                     bounds.last_start,
                     finite(bounds.stop),
                     0,
                     leaf.first,
                     leaf.count});
    if (id.level > 0) {
        pyramid.visit_children(id, [&](NodeId child) { add_nodes(pyramid, slab, child, leaves, nodes); });
        if (nodes.size() == place + 1) nodes.pop_back();
    }
    if (nodes.size() > place) nodes[place].next = static_cast<std::uint32_t>(nodes.size());
}

}  // namespace

ScatterTree::ScatterTree(const ScatterSheet<float>& sheet) : largest(sheet.bounds().largest()) {
    const BeamPyramid<float>& pyramid = sheet.coverage().pyramid();
    const light::BeamSheet<float>& beam_sheet = sheet.coverage().sheet();
    std::vector<Leaf> leaves;
    for (const BeamCluster<float>& cluster : sheet.clusters()) {
        Leaf& leaf = leaves.emplace_back();
        leaf.first = static_cast<std::uint32_t>(beams.size());
        add_beams(sheet, cluster, *this);
        leaf.count = static_cast<std::uint32_t>(beams.size()) - leaf.first;
    }
    if (beams.empty()) return;
    for (const auto& slab : sheet.bounds().slabs()) {
        add_nodes(pyramid, slab, pyramid.root(), leaves, nodes);
        slabs.push_back({slab.from, finite(slab.to), static_cast<std::uint32_t>(nodes.size())});
    }
    for (std::size_t i = 0; i < beam_sheet.rays.size(); ++i) {
        const auto& ray = beam_sheet.rays[i];
        const auto vertex = static_cast<std::uint32_t>(i);
        rays.push_back({{ray.a, ray.b, ray.slope_a, ray.slope_b}, beam_sheet.start[i]});
        stops.push_back(sheet.ways().empty() ? kFar : finite(sheet.ways().stop(vertex)));
    }
}

}  // namespace dapple::methods::sliced_beams
