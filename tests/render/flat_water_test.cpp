#include "render/flat_water.h"

#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"

namespace dapple {
namespace {

constexpr double kIndex = 1.333;

scene::Light lamp(double height) {
    scene::Light light;
    light.type = scene::LightType::point;
    light.position = {0, height, 0};
    return light;
}

TEST(FlatWater, SunIsSnellAndFresnel) {
    for (const double zenith : {0.0, 30.0, 60.0, 89.0}) {
        const auto flat = render::through_flat_water(test::sun_from_zenith(zenith), {1, -2, 3}, kIndex);
        ASSERT_TRUE(flat);
        const test::FlatFloor expected = test::flat_floor(zenith, 2, kIndex);
        // On a level floor; 1e-12: round-off of a few operations, and of 1 - F in the expectation.
        EXPECT_NEAR(flat->transport * -flat->direction.y, expected.irradiance, 1e-12);
        EXPECT_NEAR(flat->water_distance, expected.way, 1e-12);
        EXPECT_NEAR(flat->entry.y, 0, 1e-12);
        EXPECT_NEAR(flat->entry.x, 1 - std::sqrt(expected.way * expected.way - 4), 1e-9);
    }
}

TEST(FlatWater, LampOnTheAxis) {
    const auto flat = render::through_flat_water(lamp(1.5), {0, -2, 0}, kIndex);
    ASSERT_TRUE(flat);
    const double reflectance = std::pow((kIndex - 1) / (kIndex + 1), 2);
    EXPECT_NEAR(flat->transport, (1 - reflectance) / std::pow(1.5 + 2 / kIndex, 2), 1e-12);
}

TEST(FlatWater, LampsFluxThroughALevelPlaneIsItsTransmittedFlux) {
    // Integral of E over a disc on the floor against I T integrated over the cone that lands in it (3000
    // steps of the midpoint rule on both sides: 1e-6).
    const double height = 1.5, depth = 2, edge_sine = 0.8;
    const double edge = height * edge_sine / std::sqrt(1 - edge_sine * edge_sine) +
                        depth * edge_sine / std::sqrt(kIndex * kIndex - edge_sine * edge_sine);
    double landed = 0, sent = 0;
    constexpr int steps = 3000;
    for (int i = 0; i < steps; ++i) {
        const double r = edge * (i + 0.5) / steps;
        const auto flat = render::through_flat_water(lamp(height), {0, -depth, r}, kIndex);
        ASSERT_TRUE(flat);
        landed += flat->transport * -flat->direction.y * 2 * glm::pi<double>() * r * edge / steps;
        const double edge_angle = std::asin(edge_sine), angle = edge_angle * (i + 0.5) / steps;
        const double inside = std::asin(std::sin(angle) / kIndex);
        const double s = std::sin(angle - inside) / std::sin(angle + inside);
        const double p = std::tan(angle - inside) / std::tan(angle + inside);
        sent += (1 - 0.5 * (s * s + p * p)) * 2 * glm::pi<double>() * std::sin(angle) * edge_angle / steps;
    }
    EXPECT_NEAR(landed, sent, 1e-6 * sent);
}

TEST(FlatWater, NothingAboveThePlaneOrFromBelow) {
    EXPECT_FALSE(render::through_flat_water(test::sun_from_zenith(20), {0, 0.1, 0}, kIndex));
    EXPECT_FALSE(render::through_flat_water(lamp(-1), {0, -2, 0}, kIndex));
}

TEST(FlatWater, SpotEndsAtItsCone) {
    scene::Light spot = lamp(2);
    spot.type = scene::LightType::spot;
    spot.direction = {0, -1, 0};
    spot.cone_angle = 0.5;
    spot.falloff_angle = 0.1;
    const auto at = [](double angle) { return glm::dvec3(std::sin(angle), -std::cos(angle), 0); };
    EXPECT_EQ(render::spot_falloff(spot, at(0.39)), 1);
    EXPECT_EQ(render::spot_falloff(spot, at(0.51)), 0);
    const double middle = render::spot_falloff(spot, at(0.45));
    EXPECT_GT(middle, 0.3);
    EXPECT_LT(middle, 0.7);
}

}  // namespace
}  // namespace dapple
