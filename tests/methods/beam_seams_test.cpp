// Seams between rasterised beams, of regular and of refined grids.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "methods/adaptive_beams/make_beams.h"
#include "methods/draw_beams.h"
#include "methods/drawn_sheets.h"

namespace dapple {
namespace {

using methods::adaptive_beams::BeamSet;
using test::draw;
using test::Drawn;
using test::kFloor;

/// Largest second difference from pixel to pixel, relative to the value.
double roughness(const std::vector<glm::vec3>& row) {
    double worst = 0;
    for (std::size_t i = 1; i + 1 < row.size(); ++i) {
        const double before = row[i - 1].g, here = row[i].g, after = row[i + 1].g;
        worst = std::max(worst, std::abs(before - 2 * here + after) / here);
    }
    return worst;
}

/// One row of pixels as wide as before, in so many of them.
scene::FrameScene row_scene(int cells, int pixels) {
    scene::FrameScene scene = test::wavy_scene(cells, 0.004);
    scene.state.clip.width = pixels;
    scene.state.clip.height = 1;
    scene.state.camera.field_of_view = 20.48 / pixels * scene::kDegree;  // of the height
    return scene;
}

/// Looks down at the floor.
void look_down(scene::FrameScene& scene) {
    scene.state.camera.target = scene.state.camera.position + glm::dvec3(0.6, -1, 0.1);
}

TEST(Seams, BetweenBeamsAreNotSeen) {
    scene::FrameScene scene = row_scene(100, 512);
    const rays::RayScene rays(scene);
    // Beams of 6 cm are some 45 pixels wide.
    const Drawn drawn = draw(scene, test::drawn_sheets(scene, rays, kFloor));
    look_down(scene);
    const Drawn floor = draw(scene, test::drawn_sheets(scene, rays, kFloor));
    const double s = roughness(drawn.sums.scattered), e = roughness(floor.sums.irradiance);
    printf("seams: second differences of %.1e of S and %.1e of E\n", s, e);
    EXPECT_GT(s, 0);
    EXPECT_LE(s, 0.002);
    EXPECT_GT(e, 0);
    EXPECT_LE(e, 0.002);
}

/// How often beams of different sizes follow each other along a row of points: by the areas of their
/// triangles on the plane depth = 0, in factors of two.
int borders_between_levels(const std::vector<BeamSet>& sets, const std::vector<glm::dvec3>& row) {
    int borders = 0;
    long before = 0;
    for (const glm::dvec3& point : row) {
        for (const BeamSet& set : sets) {
            const glm::dvec3 at = glm::transpose(set.world_from_mesh) * point;
            for (const glm::uvec3& triangle : set.triangles) {
                glm::dvec2 start[3], here[3];
                for (int k = 0; k < 3; ++k) {
                    const BeamSet::Vertex& v = set.vertices[triangle[k]];
                    start[k] = {v.a, v.b};
                    here[k] = start[k] + at.z * glm::dvec2(v.slope_a, v.slope_b) - glm::dvec2(at);
                }
                const auto cross = [](glm::dvec2 p, glm::dvec2 q) { return p.x * q.y - p.y * q.x; };
                const double w[] = {cross(here[1], here[2]), cross(here[2], here[0]),
                                    cross(here[0], here[1])};
                const auto [least, most] = std::minmax({w[0], w[1], w[2]});
                if (least < 0 && most > 0) continue;
                const long level =
                    std::lround(std::log2(std::abs(cross(start[1] - start[0], start[2] - start[0]))));
                borders += before != 0 && level != before ? 1 : 0;
                before = level;
            }
        }
    }
    return borders;
}

TEST(Seams, BetweenBeamsOfARefinedGridAreNotSeen) {
    // 16 cells and 3 levels: the grid's borders between levels too. In narrower pixels what is smooth changes
    // by less, and only seams would stay.
    for (const int pixels : {512, 8192}) {
        scene::FrameScene scene = row_scene(400, pixels);
        const rays::RayScene rays(scene);
        FrameStats stats;
        methods::FrameContext context{
            scene, rays, test::validated_device(), stats, {{0, light::Event::transmission}}};
        ASSERT_EQ(scene.state.caustics.adaptive_beams.grid, 16);
        ASSERT_EQ(scene.state.caustics.adaptive_beams.levels, 3);
        const std::vector<BeamSet> sets = methods::adaptive_beams::make_beams(context);
        const Drawn drawn = draw(scene, sets);
        look_down(scene);
        const std::vector<BeamSet> floor_sets = methods::adaptive_beams::make_beams(context);
        const Drawn floor = draw(scene, floor_sets);
        const double s = roughness(drawn.sums.scattered), e = roughness(floor.sums.irradiance);
        std::vector<glm::dvec3> middles, ends;
        for (std::size_t i = 0; i < drawn.segments.segments(); i += static_cast<std::size_t>(pixels) / 256)
            middles.emplace_back(glm::dvec3(drawn.segments.origin[i]) +
                                 0.5 * static_cast<double>(drawn.segments.length[i]) *
                                     glm::dvec3(drawn.segments.direction[i]));
        for (std::size_t i = 0; i < floor.receivers.pixels(); i += static_cast<std::size_t>(pixels) / 256)
            ends.emplace_back(floor.receivers.position[i]);
        const int borders = borders_between_levels(sets, middles),
                  floor_borders = borders_between_levels(floor_sets, ends);
        printf(
            "seams of a refined grid, %d pixels across %d and %d borders of levels: second differences of "
            "%.1e of S and %.1e of E\n",
            pixels, borders, floor_borders, s, e);
        EXPECT_GT(borders, 3);
        EXPECT_GT(floor_borders, 3);
        const double limit = pixels == 512 ? 0.002 : 0.0002;
        EXPECT_GT(s, 0);
        EXPECT_LE(s, limit);
        EXPECT_GT(e, 0);
        EXPECT_LE(e, limit);
        // The same beams with one area function each, as in the paper, show what is looked for.
        const Drawn paper = draw(scene, floor_sets, methods::adaptive_beams::VolumeKind::six_triangles,
                                 methods::adaptive_beams::Shading::paper);
        const double paper_e = roughness(paper.sums.irradiance);
        printf("as in the paper: %.1e of E\n", paper_e);
        EXPECT_GT(paper_e, 0.01);
    }
}

}  // namespace
}  // namespace dapple
