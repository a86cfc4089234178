#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "adaptive_scene.h"
#include "base/hash.h"
#include "methods/adaptive_beams/refinement.h"

namespace dapple::methods::adaptive_beams {
namespace {

/// A grid has no crack: every edge inside the square has two triangles, one at its border has one, the whole
/// is a disc (Euler: vertices - edges + triangles = 1), and areas add up to the square's. A vertex that hung
/// on an edge of a larger triangle would leave edges with one triangle.
void expect_no_cracks(const ProjectedGrid& grid) {
    std::set<std::uint32_t> used;
    double area = 0;
    for (const ProjectedGrid::Triangle& t : grid.triangles()) {
        const glm::dvec2 a = grid.uv(t.vertices[0]), b = grid.uv(t.vertices[1]), c = grid.uv(t.vertices[2]);
        area += 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        used.insert(t.vertices.begin(), t.vertices.end());
        // Right-angled, with two equal sides: exactly, on whole numbers times a power of two.
        EXPECT_EQ(glm::distance(a, c), glm::distance(b, c));
        EXPECT_EQ(glm::dot(a - c, b - c), 0);
    }
    EXPECT_NEAR(area, 1, 1e-12);
    for (const ProjectedGrid::Edge& edge : grid.edges()) {
        const glm::dvec2 a = grid.uv(edge.vertices[0]), b = grid.uv(edge.vertices[1]);
        const bool border = (a.x == b.x && (a.x == 0 || a.x == 1)) || (a.y == b.y && (a.y == 0 || a.y == 1));
        EXPECT_EQ(edge.triangles[1] == ProjectedGrid::kNone, border);
    }
    EXPECT_EQ(used.size() + grid.triangles().size(), grid.edges().size() + 1);
}

/// A grid without the triangles that were discarded: edges inside the square that have one triangle only have
/// both ends off the body, and no vertex hangs in the middle of an edge.
void expect_holes_only_off_body(const RefinedGrid& refined) {
    const ProjectedGrid& grid = refined.grid;
    std::set<std::pair<double, double>> used;
    for (const ProjectedGrid::Triangle& t : grid.triangles())
        for (const std::uint32_t v : t.vertices) used.emplace(grid.uv(v).x, grid.uv(v).y);
    std::size_t holes = 0;
    for (const ProjectedGrid::Edge& edge : grid.edges()) {
        const glm::dvec2 a = grid.uv(edge.vertices[0]), b = grid.uv(edge.vertices[1]), middle = 0.5 * (a + b);
        EXPECT_FALSE(used.contains({middle.x, middle.y})) << middle.x << " " << middle.y;
        const bool border = (a.x == b.x && (a.x == 0 || a.x == 1)) || (a.y == b.y && (a.y == 0 || a.y == 1));
        if (border || edge.triangles[1] != ProjectedGrid::kNone) continue;
        ++holes;
        for (const std::uint32_t v : edge.vertices) EXPECT_FALSE(refined.rays.paths[v].on_body);
    }
    EXPECT_GT(holes, 10u);
}

/// Light that meets the body does so in a triangle.
void expect_all_of_body(const RefinedGrid& refined, const PathTracer& tracer) {
    constexpr std::uint64_t kSide = 100;
    std::vector<glm::dvec2> uv;
    for (std::uint64_t i = 0; i < kSide * kSide; ++i)
        uv.push_back((glm::dvec2(i % kSide, i / kSide) + glm::dvec2(hash_uniform(8, 0, i, 0), 0.5)) /
                     static_cast<double>(kSide));
    const std::vector<glm::dvec2> entries = tracer.entries(uv);
    const auto in_triangle = [&](glm::dvec2 p, const ProjectedGrid::Triangle& t) {
        bool inside = true;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec2 a = refined.grid.uv(t.vertices[i]), b = refined.grid.uv(t.vertices[(i + 1) % 3]);
            inside = inside && (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) >= 0;
        }
        return inside;
    };
    std::size_t met = 0;
    for (std::size_t i = 0; i < uv.size(); ++i) {
        if (entries[i].x + entries[i].y <= 0) continue;
        ++met;
        const std::vector<ProjectedGrid::Triangle>& triangles = refined.grid.triangles();
        EXPECT_TRUE(std::any_of(triangles.begin(), triangles.end(),
                                [&](const ProjectedGrid::Triangle& t) { return in_triangle(uv[i], t); }))
            << uv[i].x << " " << uv[i].y;
    }
    EXPECT_GT(met, uv.size() / 2);
}

TEST(AdaptiveGrid, HasNoCracksWhereverItIsSplit) {
    for (const int cells : {1, 4}) {
        ProjectedGrid grid(cells, 4);
        expect_no_cracks(grid);
        for (int level = 0; level < 4; ++level) {
            // A tenth of the edges, by chance.
            std::vector<std::uint8_t> marks(grid.edges().size());
            for (std::size_t e = 0; e < marks.size(); ++e)
                marks[e] = hash_uniform(7, static_cast<std::uint64_t>(level), e, 0) < 0.1;
            grid.split(marks);
            expect_no_cracks(grid);
        }
    }
}

TEST(AdaptiveGrid, SplitsEverythingInFour) {
    ProjectedGrid grid(4, 2);
    for (int level = 0; level < 2; ++level) {
        grid.split(std::vector<std::uint8_t>(grid.edges().size(), 1));
        EXPECT_EQ(grid.triangles().size(), 32U << (2 * level + 2));
    }
    EXPECT_EQ(grid.vertices(), 17U * 17U);
    expect_no_cracks(grid);
}

TEST(AdaptiveGrid, HasNoCracksOverWavesAndABall) {
    scene::FrameScene scene;
    test::add_water(scene, 0.01);
    scene.state.objects.push_back(test::glass_ball({0.3, 1.5, 0.2}, 0.5, 1.5));
    scene.state.objects.push_back(test::floor_at(-2, 40));
    scene.state.lights.push_back(test::sun_at(60));
    const rays::RayScene rays(scene);
    const media::Media media(scene);
    for (const int body : {light::kWater, 0}) {
        const LightView view = LightViews(scene).of(0, scene.state.lights[0].direction, 1, body).at(0);
        const PathTracer tracer(scene, rays, media, view, body, 3);
        FrameStats stats;
        RefinedGrid refined = refine(scene, tracer, body, 16, 3, nullptr, stats);
        // What the ball hides of the water, and the corners of the view about the ball.
        EXPECT_GT(stats.counted("cells discarded"), 50);
        expect_holes_only_off_body(refined);
        expect_all_of_body(refined, tracer);
        EXPECT_GE(refined.rays.uv.size(), refined.grid.vertices());
        // Something is split down to the last level, and something is not.
        EXPECT_GT(refined.grid.triangles().size(), 4U * 512);
        EXPECT_LT(refined.grid.triangles().size(), 64U * 512);
    }
}

/// Solid angle of a rectangle from a point `height` above its corner.
double corner_angle(double a, double b, double height) {
    return std::atan(a * b / (height * std::sqrt(a * a + b * b + height * height)));
}

TEST(AdaptiveGrid, ViewsSendWhatTheLightDoes) {
    scene::FrameScene scene;
    test::add_water(scene, 0);
    scene.state.lights.push_back(test::sun_at(30));
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0.5, 1, -0.3};
    scene.state.lights.push_back(lamp);
    const auto sum = [](const LightView& view) {
        const ProjectedGrid grid(8, 0);
        double extent = 0;
        for (const ProjectedGrid::Triangle& t : grid.triangles())
            extent += view.extent(grid.uv(t.vertices[0]), grid.uv(t.vertices[1]), grid.uv(t.vertices[2]));
        return extent;
    };
    // A view of the water is narrower than it by a millionth at each side.
    const double room = 5e-6;
    const auto sun = LightViews(scene).of(0, scene.state.lights[0].direction, 1, light::kWater);
    ASSERT_EQ(sun.size(), 1U);
    EXPECT_NEAR(sum(sun[0]) / (16 * std::sin(30 * scene::kDegree)), 1, room);
    const auto point = LightViews(scene).of(1, {}, 1, light::kWater);
    ASSERT_EQ(point.size(), 1U);
    double angle = 0;
    for (const double a : {1.5, 2.5})
        for (const double b : {1.7, 2.3}) angle += corner_angle(a, b, 1);
    EXPECT_NEAR(sum(point[0]) / angle, 1, room);

    // A lamp so near that one view does not hold the pool: faces of a cube, all about it but upwards.
    scene.state.lights[1].position.y = 0.1;
    const auto faces = LightViews(scene).of(1, {}, 1, light::kWater);
    EXPECT_EQ(faces.size(), 5U);
    for (const LightView& face : faces) EXPECT_NEAR(sum(face), 4 * std::numbers::pi / 6, 1e-12);

    // A ball seen from afar: the view is the square about its outline.
    scene.state.objects.push_back(test::glass_ball({3, 2, 1}, 0.5, 1.5));
    const auto ball = LightViews(scene).of(0, scene.state.lights[0].direction, 1, 0);
    ASSERT_EQ(ball.size(), 1U);
    EXPECT_NEAR(sum(ball[0]), 1, room);
}

}  // namespace
}  // namespace dapple::methods::adaptive_beams
