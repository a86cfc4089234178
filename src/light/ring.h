#pragma once
#include <cstdint>
#include <vector>

#include "light/map_plan.h"

namespace dapple::light {

/// Along one axis, both ends included; empty where high < low.
struct TexelRange {
    std::int64_t low = 0, high = -1;
};

/// A map's texels but for those in the hole, as at most four rectangles. This is what algorithm 1 of
/// Kougianos and Moustakas 2021 maps threads to: its regions 0 to 2 are the first rectangle, the two at the
/// sides, and the last.
std::vector<TexelBox> ring(int columns, int rows, TexelRange hole_x, TexelRange hole_z);

/// Indices of the triangles, in their order, that the light may throw onto `plan.parts`.
std::vector<glm::uvec3> triangles_of_ring(const MapPlan& plan, const scene::TriangleMesh& water);

}  // namespace dapple::light
