// Light in media through the whole of a frame: segments, S, direct light, film.
#include <gtest/gtest.h>

#include <cmath>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "media/media.h"
#include "render/frame_renderer.h"
#include "view/camera.h"
#include "view/view_scene.h"

namespace dapple {
namespace {

constexpr int kWidth = 24;
constexpr int kHeight = 16;

struct Rendered {
    image::Image image;
    FrameStats stats;
    float at(const std::string& channel, std::size_t pixel) const {
        return image.find(channel)->values[pixel];
    }
};

Rendered render(const scene::FrameState& state) {
    static render::FrameRenderer renderer(test::validated_device());
    Rendered rendered;
    rendered.image = renderer.render(state, rendered.stats).linear;
    return rendered;
}

scene::FrameState murky_water() {
    scene::FrameState state = test::pool_over_floor(120, 6, 1, kWidth);
    state.clip.height = kHeight;
    state.camera.projection = scene::Projection::perspective;
    state.camera.position = {0, -2, 0};
    state.camera.target = {1, -2, 0};
    state.camera.up = {0, 1, 0};
    state.camera.field_of_view = glm::radians(110.0);
    state.water->absorption = {0.3, 0.15, 0.1};
    state.water->scattering = {0.05, 0.1, 0.2};
    state.water->phase.type = scene::PhaseType::henyey_greenstein;
    state.water->phase.anisotropy = 0.6;
    state.objects[0].size = {400, 1, 400};
    state.lights = {test::sun_from_zenith(40)};
    return state;
}

/// Flat water, a directional sun, even water: single scattering in closed form. The camera looks level, so
/// half of its rays meet the surface from below and are mirrored, some totally.
TEST(VolumeFrame, OfEvenWaterUnderTheSunIsItsClosedForm) {
    const scene::FrameState state = murky_water();
    const Rendered found = render(state);
    const view::Camera camera(state.camera, kWidth, kHeight);
    const double index = state.water->refractive_index;
    const double sin_t = std::sin(glm::radians(40.0)) / index, cos_t = std::sqrt(1 - sin_t * sin_t);
    const glm::dvec3 light(sin_t, -cos_t, 0);
    const double facing = test::flat_floor(40, 1, index).irradiance / cos_t;
    for (std::size_t pixel = 0; pixel < std::size_t{kWidth} * kHeight; ++pixel) {
        glm::dvec3 origin, way;
        const std::size_t column = pixel % kWidth, row = pixel / kWidth;
        camera.ray({static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5}, origin, way);
        const auto seen = [&](const glm::dvec3& direction, double depth, double length, int c) {
            const double sigma = state.water->extinction()[c];
            const double g = 0.6, cosine = -dot(light, direction);
            const double phase =
                (1 - g * g) / (4 * glm::pi<double>() * std::pow(1 + g * g - 2 * g * cosine, 1.5));
            const double a = sigma * (1 - direction.y / cos_t);
            return state.water->scattering[c] * phase * facing * state.lights[0].irradiance[c] *
                   std::exp(-sigma * depth / cos_t) * (-std::expm1(-a * length) / a);
        };
        for (int c = 0; c < 3; ++c) {
            double expected;
            if (way.y < 0) {
                expected = seen(way, 2, -4 / way.y, c);
            } else {
                const double up = 2 / way.y;
                const double mirrored = 1 - std::max(0.0, test::cross_surface(way.y, index, 1).transmittance);
                expected = seen(way, 2, up, c) + mirrored * std::exp(-up * state.water->extinction()[c]) *
                                                     seen(way * glm::dvec3(1, -1, 1), 0, 6 / way.y, c);
            }
            const std::string name = std::string("volume_caustics.") + "RGB"[c];
            // The quadrature of intervals leaves 1e-5, floats of the beams' places as much a metre, over
            // tens.
            EXPECT_NEAR(found.at(name, pixel), expected, 1e-3 * expected) << name << " " << pixel;
        }
        EXPECT_EQ(found.at("volume_direct.R", pixel), 0);
    }
}

/// Fog and murky water, a sun above and a lamp below, things that cast shadows.
scene::FrameState mixed() {
    scene::FrameState state = murky_water();
    state.clip.width = 48;
    state.clip.height = 32;
    state.clip.samples = 2;
    state.water->extent.size = {12, 12};
    state.camera.position = {-5, 1.5, 0.5};
    state.camera.target = {0, -0.5, 0};
    state.camera.field_of_view = glm::radians(50.0);
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0.5, -1, -1};
    lamp.intensity = {6, 5, 4};
    state.lights.push_back(lamp);
    scene::Medium fog;
    fog.type = scene::MediumType::box;
    fog.side = scene::MediumSide::air;
    fog.extinction = {0.3, 0.3, 0.3};
    fog.size = {4, 2, 6};
    fog.transform.position = {1, 1, 0};
    state.media = {fog};
    scene::Object column;
    column.shape = scene::Shape::box;
    column.size = {0.6, 8, 0.6};
    column.transform.position = {0.2, -2, 0.8};
    state.objects.push_back(column);
    return state;
}

TEST(VolumeFrame, ThePartsAddUpToThePicture) {
    const Rendered found = render(mixed());
    double direct = 0, caustics = 0;
    for (std::size_t pixel = 0; pixel < found.image.pixels(); ++pixel) {
        for (const char c : {'R', 'G', 'B'}) {
            const auto part = [&](const std::string& name) { return found.at(name + "." + c, pixel); };
            EXPECT_NEAR(part("volume"), part("volume_direct") + part("volume_caustics"), 1e-6);
            const float sum =
                part("direct") + part("caustics") + part("sky") + part("environment") + part("volume");
            EXPECT_NEAR(found.at(std::string(1, c), pixel), sum, 1e-5 * (1 + sum));
        }
        direct += static_cast<double>(found.at("volume_direct.G", pixel));
        caustics += static_cast<double>(found.at("volume_caustics.G", pixel));
    }
    EXPECT_GT(direct, 0);
    EXPECT_GT(caustics, 0);
    EXPECT_GT(found.stats.counted("camera segments"), 48 * 32 * 2);
    EXPECT_EQ(found.stats.counted("camera segments"), found.stats.counted("camera segments asked for"));
}

TEST(VolumeFrame, WithoutMediaThereAreNoLayersOfThem) {
    scene::FrameState state = mixed();
    state.media.clear();
    state.water->scattering = {0, 0, 0};
    const Rendered found = render(state);
    EXPECT_EQ(found.image.find("volume.R"), nullptr);
    EXPECT_EQ(found.image.find("volume_direct.R"), nullptr);
    EXPECT_EQ(found.stats.counted("camera segments"), 0);
}

TEST(VolumeFrame, HalfResolutionIsCloseAndAsksLess) {
    scene::FrameState state = murky_water();
    state.clip.width = 97;
    state.clip.height = 65;
    scene::Object column;
    column.shape = scene::Shape::box;
    column.size = {0.8, 12, 0.8};
    column.transform.position = {5, -2, 0.7};
    state.objects.push_back(column);
    const Rendered full = render(state);
    state.caustics.volume_resolution = scene::VolumeResolution::half;
    const Rendered half = render(state);
    double difference = 0, sum = 0, largest = 0;
    for (std::size_t pixel = 0; pixel < full.image.pixels(); ++pixel) {
        const double a = static_cast<double>(full.at("volume_caustics.G", pixel));
        const double b = static_cast<double>(half.at("volume_caustics.G", pixel));
        difference += std::abs(a - b);
        sum += a;
        largest = std::max(largest, std::abs(a - b) / a);
    }
    const double share =
        half.stats.counted("camera segments asked for") / half.stats.counted("camera segments");
    RecordProperty("share", std::to_string(share));
    RecordProperty("difference", std::to_string(difference / sum));
    // Segments that lie between their neighbors' to 1 % scatter as much as their mean, but where the edge of
    // the column's shadow in the water runs between: there one of two pixels is off by half a step.
    EXPECT_LT(difference / sum, 0.005);
    EXPECT_LT(largest, 0.25);
    EXPECT_LT(share, 0.5);
    EXPECT_GT(share, 0.25);
    EXPECT_EQ(full.at("caustics.G", 6000), half.at("caustics.G", 6000)) << "surfaces are none of it";
}

/// At half resolution the method knows nothing of most pixels: 0 would say that they are certain.
TEST(VolumeFrame, HalfResolutionWritesNoVarianceOfS) {
    scene::FrameState state = murky_water();
    state.clip.width = 9;
    state.clip.height = 7;
    state.water->extent.size = {12, 12};
    state.caustics.method = "reference";
    state.caustics.reference.standard_error = 10;  // one round
    EXPECT_NE(render(state).image.find("S.variance.G"), nullptr);
    state.caustics.volume_resolution = scene::VolumeResolution::half;
    const Rendered half = render(state);
    EXPECT_EQ(half.image.find("S.variance.G"), nullptr);
    EXPECT_NE(half.image.find("E.variance.G"), nullptr);
}

}  // namespace
}  // namespace dapple
