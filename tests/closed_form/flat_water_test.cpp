// Flat water over an open floor: E = E_perp cos(i) T exp(-sigma d / cos(t)), through the whole pipeline.
#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr double kDepth = 2;
constexpr double kPatch = 6;
constexpr double kIndex = 1.333;
constexpr int kPixels = 96;
const char* const kLetters = "RGB";

render::RenderedFrame render_frame(const scene::FrameState& state) {
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    return renderer.render(state, stats);
}

const std::vector<float>& values(const image::Image& image, const std::string& name) {
    const image::Channel* channel = image.find(name);
    if (!channel) throw std::runtime_error("no channel " + name);
    return channel->values;
}

/// A sun at `zenith_degrees` over open water; the camera looks at the part of the floor whose light enters in
/// the middle of the patch, `view` m of it.
scene::FrameState state_under(double zenith_degrees, double view) {
    scene::FrameState state = test::pool_over_floor(kPatch, kDepth, view, kPixels);
    const double shift = kDepth * std::tan(std::asin(std::sin(glm::radians(zenith_degrees)) / kIndex));
    state.camera.position.x = state.camera.target.x = shift;
    state.water->extent.kind = scene::ExtentKind::open_water;
    state.lights = {test::sun_from_zenith(zenith_degrees)};
    return state;
}

class FlatWater : public testing::TestWithParam<double> {};

INSTANTIATE_TEST_SUITE_P(SunFromZenith, FlatWater, testing::Values(0.0, 30.0, 60.0, 80.0, 89.0),
                         [](const auto& sun) { return std::to_string(static_cast<int>(sun.param)) + "deg"; });

TEST_P(FlatWater, FloorIrradianceIsTheClosedForm) {
    const scene::FrameState state = state_under(GetParam(), 1.6);
    const render::RenderedFrame frame = render_frame(state);
    EXPECT_EQ(frame.non_finite.count, 0u);
    const test::FlatFloor floor = test::flat_floor(GetParam(), kDepth, kIndex);
    double worst = 0, worst_mean = 0;
    for (int c = 0; c < 3; ++c) {
        const double expected = state.lights[0].irradiance[c] * floor.irradiance *
                                std::exp(-state.water->absorption[c] * floor.way);
        double mean = 0, worst_here = 0;
        for (const float value : values(frame.linear, std::string("E.") + kLetters[c])) {
            ASSERT_NEAR(value, expected, 0.005 * expected);
            worst_here = std::max(worst_here, std::abs(value - expected));
            mean += value;
        }
        mean /= kPixels * kPixels;
        worst = std::max(worst, worst_here / expected);
        worst_mean = std::max(worst_mean, std::abs(mean / expected - 1));
        EXPECT_NEAR(mean, expected, 1e-4 * expected);
    }
    for (const float covered : values(frame.linear, "covered")) ASSERT_EQ(covered, 1);
    printf("sun %2.0f deg from the zenith: E off by %.1e in the worst pixel, %.1e in the mean\n", GetParam(),
           worst, worst_mean);
}

TEST_P(FlatWater, OrthographicPictureIsReflectedIrradianceAfterTheWayToTheCamera) {
    const scene::FrameState state = state_under(GetParam(), 1.6);
    const render::RenderedFrame frame = render_frame(state);
    const test::FlatFloor floor = test::flat_floor(GetParam(), kDepth, kIndex);
    const double way_to_camera = kDepth + state.camera.position.y;
    for (int c = 0; c < 3; ++c) {
        const double expected = state.objects[0].material.color[c] * glm::one_over_pi<double>() *
                                state.lights[0].irradiance[c] * floor.irradiance *
                                std::exp(-state.water->absorption[c] * (floor.way + way_to_camera));
        for (const float value : values(frame.linear, std::string(1, kLetters[c]))) {
            ASSERT_NEAR(value, expected, 0.005 * expected);
        }
    }
}

TEST(FlatWaterStandIn, ServesOpenWaterBeyondTheExtentInTheBeautyOnly) {
    scene::FrameState state = state_under(30, 1.6);
    state.camera.position.x = state.camera.target.x = 12;
    const render::RenderedFrame frame = render_frame(state);
    const test::FlatFloor floor = test::flat_floor(30, kDepth, kIndex);
    const double way_to_camera = kDepth + state.camera.position.y;
    const double expected = state.objects[0].material.color.x * glm::one_over_pi<double>() *
                            state.lights[0].irradiance.x * floor.irradiance *
                            std::exp(-state.water->absorption.x * (floor.way + way_to_camera));
    // Closed form on both sides: float round-off only.
    for (const float value : values(frame.linear, "R")) ASSERT_NEAR(value, expected, 1e-5 * expected);
    for (const char* name : {"E.R", "caustics.R"})
        for (const float value : values(frame.linear, name)) ASSERT_EQ(value, 0);
}

TEST(FlatWaterStandIn, ServesWhatAMirrorShows) {
    // A mirror under the camera's eyes, 45 degrees, shows the floor beside it.
    scene::FrameState state = state_under(0, 0.2);
    state.caustics.method = "photon_splatting";  // which serves direct views only
    scene::Object mirror = test::level_plane("mirror", -1, 0.6);
    mirror.transform.rotation.z = glm::radians(45.0);
    mirror.material.mirror = true;
    mirror.material.color = glm::dvec3(1);
    state.objects.push_back(mirror);
    scene::Object wall = test::level_plane("wall", -1, 4);
    wall.transform.rotation.z = glm::radians(-80.0);
    wall.transform.position.x = -2;
    state.objects.push_back(wall);
    const render::RenderedFrame frame = render_frame(state);
    for (const float covered : values(frame.linear, "covered")) ASSERT_EQ(covered, 0);
    for (const float value : values(frame.linear, "E.R")) ASSERT_EQ(value, 0);
    for (const float value : values(frame.linear, "R")) ASSERT_GT(value, 0);
}

TEST_P(FlatWater, PerspectivePictureDimsWithTheWayOfEachPixel) {
    scene::FrameState state = state_under(GetParam(), 0);
    state.camera.projection = scene::Projection::perspective;
    state.camera.field_of_view = glm::radians(50.0);
    const render::RenderedFrame frame = render_frame(state);
    const test::FlatFloor floor = test::flat_floor(GetParam(), kDepth, kIndex);
    const double height = kDepth + state.camera.position.y;
    const double pixel_size = 2 * std::tan(0.5 * state.camera.field_of_view) / kPixels;
    for (int y = 0; y < kPixels; ++y) {
        for (int x = 0; x < kPixels; ++x) {
            const double u = (x + 0.5 - 0.5 * kPixels) * pixel_size,
                         v = (y + 0.5 - 0.5 * kPixels) * pixel_size;
            const double way_to_camera = height * std::sqrt(1 + u * u + v * v);
            for (int c = 0; c < 3; ++c) {
                const double expected = state.objects[0].material.color[c] * glm::one_over_pi<double>() *
                                        state.lights[0].irradiance[c] * floor.irradiance *
                                        std::exp(-state.water->absorption[c] * (floor.way + way_to_camera));
                const auto& picture = values(frame.linear, std::string(1, kLetters[c]));
                ASSERT_NEAR(picture[static_cast<std::size_t>(y * kPixels + x)], expected, 0.005 * expected);
            }
        }
    }
}

TEST_P(FlatWater, PictureFromAboveIsTheStandInThroughTheSurface) {
    // Nothing stands above the water, so that no light path needs the method.
    scene::FrameState state = test::pool_over_floor(kPatch, kDepth, 1.6, kPixels);
    const double shift = kDepth * std::tan(std::asin(std::sin(glm::radians(GetParam())) / kIndex));
    state.camera.position = {shift, 1, 0};
    state.camera.target = {shift, 0, 0};
    state.caustics.method = "photon_splatting";  // which serves direct views only
    state.water->extent.kind = scene::ExtentKind::open_water;
    state.lights = {test::sun_from_zenith(GetParam())};
    const render::RenderedFrame frame = render_frame(state);
    const test::FlatFloor floor = test::flat_floor(GetParam(), kDepth, kIndex);
    const double outwards = 4 / (kIndex * std::pow(kIndex + 1, 2));  // (1 - F) / n^2 at normal incidence
    for (int c = 0; c < 3; ++c) {
        const double expected = state.objects[0].material.color[c] * glm::one_over_pi<double>() *
                                state.lights[0].irradiance[c] * floor.irradiance * outwards *
                                std::exp(-state.water->absorption[c] * (floor.way + kDepth));
        for (const float value : values(frame.linear, std::string(1, kLetters[c]))) {
            ASSERT_NEAR(value, expected, 1e-5 * expected);  // some ten roundings to float
        }
    }
    // The stand-in is in the beauty only.
    for (const char* name : {"E.G", "caustics.G", "covered"})
        for (const float value : values(frame.linear, name)) ASSERT_EQ(value, 0) << name;
}

}  // namespace
}  // namespace dapple
