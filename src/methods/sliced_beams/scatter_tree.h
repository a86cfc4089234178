#pragma once
#include <vector>

#include "layout/scatter.h"
#include "methods/sliced_beams/scatter_sheet.h"

namespace dapple::methods::sliced_beams {

/// A sheet's beams among which no object may stand, as ScatterPass has them on the device.
struct ScatterTree {
    std::vector<layout::ScatterSlab> slabs;
    std::vector<layout::ScatterNode> nodes;  ///< slab by slab, each node before its children
    std::vector<layout::ScatterBeam> beams;  ///< in the order of the finest nodes
    std::vector<layout::ScatterRay> rays;    ///< a vertex of the water
    std::vector<float> stops;                ///< m of depth, the same, where an object stops it
    float largest = 0;                       ///< m, as ScatterBounds::largest()

    explicit ScatterTree(const ScatterSheet<float>& sheet);

    static double bytes_a_vertex() { return sizeof(layout::ScatterRay) + sizeof(float); }
    static double bytes_a_beam() {
        return sizeof(layout::ScatterBeam) +
               sizeof(layout::ScatterNode) * ScatterBounds<float>::nodes_a_cluster() / kClusterBeams;
    }
};

}  // namespace dapple::methods::sliced_beams
