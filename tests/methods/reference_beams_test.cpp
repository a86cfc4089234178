// What the reference's camera beams find of a way of light, among them one that a surface fans out widely.
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include "methods/reference/camera_beams.h"
#include "methods/reference_volume_frame.h"

namespace dapple {
namespace {

using namespace reference;

TEST(CameraBeams, OneThatFansOutLeavesTheOthersTheirVoxels) {
    scene::FrameScene scene;
    scene.state = test::water_with_eye({0, -1, 0}, {1, 0, 0}, 1, 1);
    scene.state.water->absorption = {0, 0, 0};
    scene.state.water->scattering = glm::dvec3(1e-6);  // dims nothing
    scene.state.water->phase = {};
    const OwnMedia media(scene);

    // Eight that tile a square rod along x, one above the other, and one that is 20 m wide after 1 m.
    constexpr float kSide = 0.02f;
    std::vector<CameraBeam> beams;
    for (int i = 0; i < 8; ++i) {
        CameraBeam beam{};
        beam.origin = {0, -2 + kSide * static_cast<float>(i), 0};
        beam.direction = {1, 0, 0};
        beam.u_origin = {0, kSide, 0};
        beam.v_origin = {0, 0, kSide};
        beam.length = 2;
        beam.factor = glm::vec3(1);
        beam.in_water = 1;
        beams.push_back(beam);
    }
    CameraBeam fan = beams[4];
    fan.u_direction = {0, 20, 0};
    fan.v_direction = {0, 0, 20};
    fan.segment = 1;
    beams.push_back(fan);
    const std::vector<CameraBeams> classes = CameraBeams::by_width(std::move(beams), glm::dvec2(0.5));
    EXPECT_EQ(classes.size(), 2u);

    LightWay way;
    way.position = {1, 0, 0.003};
    way.direction = {0, -1, 0};
    way.length = 6;
    way.power = glm::dvec3(1);
    way.in_water = true;
    MediaProbe along_light(media), to_eye(media);
    for (std::uint64_t number = 0; number < 20; ++number) {
        RandomStream random{1, 1, number};
        std::vector<ScatteringEvent> events;
        for (const CameraBeams& some : classes) some.add_events(way, along_light, to_eye, random, events);
        double sums[2] = {0, 0};
        for (const ScatteringEvent& event : events) sums[event.segment] += event.radiance.x;
        // W sigma p dt / |J|: each event lies in one beam of the rod, and in the fan, whatever its place, so
        // that nothing is left to chance. Beams are float.
        const double unit = 1e-6 / (4 * glm::pi<double>());
        EXPECT_NEAR(sums[0] / (unit * 8 / static_cast<double>(kSide)), 1, 1e-4) << number;
        const double side = 20 + static_cast<double>(kSide);
        EXPECT_NEAR(sums[1] / (unit * 6 / (side * side)), 1, 1e-4) << number;
    }
}

}  // namespace
}  // namespace dapple
