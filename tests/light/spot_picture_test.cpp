#include "light/spot_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <numeric>
#include <utility>

#include "base/hash.h"
#include "light/beam_axes.h"
#include "light/beam_checks.h"
#include "light/gobo.h"
#include "optics/optics.h"

namespace dapple {
namespace {

using light::SpotPicture;

/// Red grows to the right, green upwards, blue is 1.
glm::vec3 gradient(float u, float v) {
    return {u, v, 1};
}

SpotPicture thrown(const scene::Light& light, std::shared_ptr<const image::Texture> texture) {
    scene::FrameScene scene;
    scene.state.lights = {light};
    scene.light_textures = {std::move(texture)};
    return {scene, 0};
}

/// The place in the picture of a gradient that lights a point.
glm::dvec2 place(const scene::Light& light, const glm::dvec3& point, int width = 64, int height = 64) {
    return thrown(light, test::picture(width, height, gradient)).towards(point - light.position);
}

void expect_place(const glm::dvec2& found, const glm::dvec2& expected) {
    EXPECT_NEAR(found.x, expected.x, 1e-6);  // texels and weights are floats
    EXPECT_NEAR(found.y, expected.y, 1e-6);
}

TEST(SpotPicture, IsUprightAndNotMirroredAsTheLightSeesIt) {
    const double radius = std::tan(30 * scene::kDegree);                 // of the cone at 1 m
    const glm::dvec2 expected(0.5 + 0.25 / radius, 0.5 + 0.1 / radius);  // 0.5 m to the right, 0.2 m up
    const glm::dvec3 eye(1, 2, 3);
    const auto seen = [&](glm::dvec3 axis, glm::dvec3 right, glm::dvec3 up) {
        return place(test::spot(eye, eye + axis), eye + axis + 0.5 * right + 0.2 * up);
    };
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    expect_place(seen(-z, x, y), expected);
    expect_place(seen(z, -x, y), expected);
    expect_place(seen(x, z, y), expected);
    expect_place(seen(-x, -z, y), expected);
    // Vertical axes, and those that all but are.
    expect_place(seen(-y, x, -z), expected);
    expect_place(seen(y, x, z), expected);
    expect_place(seen(glm::normalize(glm::dvec3(1e-7, -1, 1e-7)), x, -z), expected);
    expect_place(seen(glm::normalize(glm::dvec3(0, -1, -1)), x, glm::normalize(glm::dvec3(0, 1, -1))),
                 expected);
}

TEST(SpotPicture, RollTurnsItClockwise) {
    scene::Light light = test::spot({0, 0, 0}, {0, 0, -1});
    light.roll = 90 * scene::kDegree;
    const double radius = std::tan(30 * scene::kDegree);
    // What was up is at the right now.
    expect_place(place(light, {0.2, 0, -1}), {0.5, 0.5 + 0.1 / radius});
    expect_place(place(light, {0, -0.2, -1}), {0.5 + 0.1 / radius, 0.5});
}

TEST(SpotPicture, TheConeIsTheLargestCircleInIt) {
    const scene::Light light = test::spot({0, 0, 0}, {0, 0, -1});
    const double radius = std::tan(30 * scene::kDegree);
    // A quarter of the width, less than the half texel at the edge that goes on.
    expect_place(place(light, {0.5 * radius, 0.9 * radius, -1}, 128, 64), {0.625, 0.95});
    expect_place(place(light, {0.9 * radius, 0.5 * radius, -1}, 64, 128), {0.95, 0.625});
    // Outside the outermost texels go on.
    expect_place(place(light, {2 * radius, 0, -1}), {1 - 0.5 / 64, 0.5});
    expect_place(place(light, {-1, 0, 1}), {0.5 / 64, 0.5});
}

TEST(SpotPicture, SomeLightsHaveNone) {
    EXPECT_FALSE(SpotPicture().exists());
    EXPECT_EQ(SpotPicture().towards({0, -1, 0}), glm::dvec3(1));
    scene::FrameScene scene;
    scene.state.lights = {test::spot({0, 3, 0}, {0, 0, 0}), test::spot({0, 3, 0}, {0, 0, 0})};
    scene.light_textures = {test::checkers(8, 2)};
    EXPECT_TRUE(SpotPicture(scene, 0).exists());
    EXPECT_FALSE(SpotPicture(scene, 1).exists());
}

TEST(SpotPicture, KnowsWhetherItIsGrey) {
    const scene::Light light = test::spot({0, 0, 0}, {0, 0, -1});
    EXPECT_TRUE(thrown(light, test::checkers(8, 2)).grey());
    EXPECT_TRUE(
        thrown(light, test::picture(8, 8, [](float u, float) { return glm::vec3(u, u + 1e-5f, u); })).grey());
    EXPECT_FALSE(thrown(light, test::picture(8, 8, gradient)).grey());
}

/// The mean over a triangle by 150 x 150 x 2 points.
glm::dvec3 brute_mean(const scene::Light& light, const SpotPicture& picture,
                      const std::array<glm::dvec3, 3>& ways) {
    constexpr int n = 150;
    glm::dvec3 sum(0);
    double weights = 0;
    for (int i = 0; i < 2 * n * n; ++i) {
        const int column = i / 2 % n, row = i / 2 / n;
        const double u = (column + 0.5) / n, v = (row + (i % 2 + 0.5) / 2) / n;
        if (u + v > 1) continue;
        const glm::dvec3 way = ways[0] + u * (ways[1] - ways[0]) + v * (ways[2] - ways[0]);
        const double r = glm::length(way);
        const double weight =
            optics::f64::spot_light_falloff(glm::dot(way, light.direction) / r, std::cos(light.cone_angle),
                                            std::cos(light.cone_angle - light.falloff_angle)) /
            (r * r * r);
        sum += weight * picture.towards(way);
        weights += weight;
    }
    return sum / weights;
}

TEST(SpotPicture, TheMeanOverATriangleIsThatOfItsLight) {
    const scene::Light light = test::spot({0, 2, 0}, {0.4, 0, -0.3});
    const SpotPicture picture = thrown(light, test::checkers(64, 8));
    double worst = 0, worst_small = 0;
    for (std::uint64_t i = 0; i < 60; ++i) {
        const auto random = [&](std::uint32_t k) { return hash_uniform(1, 0, i, k) - 0.5; };
        const bool small = i % 2 == 0;  // two texels, against sixteen
        const double size = small ? 0.08 : 0.6;
        const glm::dvec3 middle(0.4 + random(0), -2, -0.3 + random(1));
        const std::array<glm::dvec3, 3> ways{middle + size * glm::dvec3(random(2), random(3), random(4)),
                                             middle + size * glm::dvec3(random(5), random(6), random(7)),
                                             middle + size * glm::dvec3(random(8), random(9), random(10))};
        const double error = std::abs(picture.mean(ways).r - brute_mean(light, picture, ways).r);
        (small ? worst_small : worst) = std::max(small ? worst_small : worst, error);
    }
    printf("largest error of a mean: %.1e; of triangles of a texel or two: %.1e\n", worst, worst_small);
    // Fields are 1 and 0.1, their edges a texel wide: parts of half a texel miss a few percent of an edge
    // that crosses a small triangle, and these errors cancel in large ones.
    EXPECT_LT(worst, 0.01);
    EXPECT_LT(worst_small, 0.03);
}

/// 1 W/sr through the picture of a spot over a pool, into the cone, by 1000 x 1000 points: red, sr.
double light_in_cone(const scene::Light& light, const SpotPicture& picture) {
    constexpr int n = 1000;
    const double outer = std::cos(light.cone_angle), inner = std::cos(light.cone_angle - light.falloff_angle);
    const glm::dmat3 frame = light::mesh_frame(light.direction);
    double sum = 0;
    for (int i = 0; i < n * n; ++i) {
        // Equal solid angles.
        const int ring = i / n;
        const double cosine = 1 - (1 - outer) * (ring + 0.5) / n;
        const double angle = glm::two_pi<double>() * (i % n + 0.5) / n;
        const double sine = std::sqrt(1 - cosine * cosine);
        const glm::dvec3 way = frame * glm::dvec3(sine * std::cos(angle), sine * std::sin(angle), cosine);
        sum += optics::f64::spot_light_falloff(cosine, outer, inner) * picture.towards(way).r;
    }
    return sum * glm::two_pi<double>() * (1 - outer) / (n * n);
}

TEST(SpotPicture, BeamsOfBothChainsCarryItsLight) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::spot({0.3, 2, 0.1}, {0, 0, 0}, 25)};
    scene.light_textures = {test::checkers(64, 7)};
    const double expected = light_in_cone(scene.state.lights[0], SpotPicture(scene, 0));
    // The spot's falloff, linear between vertices, and the picture are each right in a beam, and their
    // product is in second order: at 96 cells, 44 of them across the picture, it is 1e-3 off.
    for (const auto& [cells, tolerance] : {std::pair{96, 2e-3}, std::pair{192, 5e-4}}) {
        test::add_water(scene, test::gentle_sea(), cells, cells);
        double carried = 0;
        for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
            const auto sheets = test::beams<double>(scene, event);
            EXPECT_EQ(sheets.size(), 1u);  // a grey picture parts no channels
            EXPECT_EQ(sheets[0].color, glm::dvec3(10, 20, 30));
            carried += test::flux_and_losses(sheets);
        }
        printf("%d cells: light of beams over that of the cone, less 1: %.1e\n", cells,
               carried / expected - 1);
        EXPECT_NEAR(carried / expected, 1, tolerance);
    }
}

TEST(SpotPicture, ColoursTintBeams) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::spot({0, 2, 0}, {0, 0, 0}, 25)};
    // Red on the right, which is at +x.
    scene.light_textures = {test::picture(
        64, 64, [](float u, float) { return u > 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1); })};
    test::add_water(scene, {}, 64, 64);
    const auto sheets = test::beams<double>(scene, light::Event::transmission);
    ASSERT_EQ(sheets.size(), 1u);
    EXPECT_EQ(sheets[0].color, glm::dvec3(10, 20, 30));
    const auto lit = [&](double side) {
        glm::dvec3 sum(0);
        for (std::size_t t = 0; t < sheets[0].flux.size(); ++t) {
            const glm::uvec3 c = scene.water->mesh.triangles[t];
            const auto& p = scene.water->mesh.positions;
            // 0.1 m is more than a cell and the texel that the edge is wide.
            if (side * (p[c.x].x + p[c.y].x + p[c.z].x) / 3 > 0.1) sum += sheets[0].power(t);
        }
        return sum;
    };
    EXPECT_GT(lit(1).r, 1);
    EXPECT_EQ(lit(1).g, 0);
    EXPECT_EQ(lit(1).b, 0);
    EXPECT_EQ(lit(-1).r, 0);
    EXPECT_EQ(lit(-1).g, 0);
    EXPECT_NEAR(lit(-1).b, 3 * lit(1).r, 3e-6 * lit(1).r);  // float texels
}

}  // namespace
}  // namespace dapple
