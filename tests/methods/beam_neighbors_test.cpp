#include "methods/sliced_beams/beam_neighbors.h"

#include <gtest/gtest.h>

#include "closed_form/beam_sheets.h"
#include "light/water_grids.h"

namespace dapple {
namespace {

using methods::sliced_beams::BeamNeighbors;
using methods::sliced_beams::Neighbor;

// The tests' own grids have the diagonals that the arithmetic stands on.
TEST(BeamNeighbors, InAGridArithmeticAgreesWithATableOfEdges) {
    scene::FrameScene other = test::water_scene({2, 1});
    test::add_water(other, {}, 7, 4);
    for (const auto& water : {test::scene_of_flat_water({3, 2}, 5, 9).water, other.water}) {
        const auto& triangles = water->mesh.triangles;
        const BeamNeighbors grid(water->rows, water->columns, triangles), table(0, 0, triangles);
        int inner = 0;
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            for (int edge = 0; edge < 3; ++edge) {
                const Neighbor found = grid.across(t, edge), expected = table.across(t, edge);
                EXPECT_EQ(found.triangle, expected.triangle) << t << ' ' << edge;
                EXPECT_EQ(found.vertex, expected.vertex) << t << ' ' << edge;
                inner += expected.triangle != methods::sliced_beams::kNoBeam ? 1 : 0;
            }
        }
        // Three edges a triangle, less those of the outline.
        const int cells_x = water->columns - 1, cells_z = water->rows - 1;
        EXPECT_EQ(inner, 6 * cells_x * cells_z - 2 * (cells_x + cells_z));
    }
}

}  // namespace
}  // namespace dapple
