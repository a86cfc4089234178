#pragma once
#include <vector>

#include "view/segment_layer.h"

namespace dapple::test {

/// Ends of a camera segment, m.
struct Ends {
    glm::dvec3 from, to;
};

/// A picture of one row, a primary segment a pixel; those whose middles lie below y = 0 are in the water.
inline view::SegmentLayer row_of_segments(const std::vector<Ends>& ends) {
    view::SegmentLayer layer;
    layer.width = static_cast<int>(ends.size());
    layer.height = 1;
    for (const auto& [from, to] : ends) {
        layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
        layer.origin.emplace_back(from);
        layer.direction.emplace_back(glm::normalize(to - from));
        layer.length.push_back(static_cast<float>(glm::length(to - from)));
        layer.in_water.push_back(from.y + to.y < 0 ? 1 : 0);
        layer.primary.push_back(1);
    }
    layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
    return layer;
}

}  // namespace dapple::test
