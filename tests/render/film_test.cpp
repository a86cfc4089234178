#include "render/film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>

namespace dapple {
namespace {

/// Two pixels: a receiver and the sky.
view::ReceiverLayer layer_of(int sample, int branch) {
    view::ReceiverLayer layer;
    layer.width = 2;
    layer.height = 1;
    layer.sample = sample;
    layer.branch = branch;
    layer.flags = {view::kReceiver, view::kEnvironment};
    layer.object = {0, 0};
    layer.throughput = {glm::vec3(0.5f, 0.25f, 1), glm::vec3(0.8f)};
    layer.position.assign(2, glm::vec3(1, 2, 3));
    layer.shading_normal.assign(2, glm::vec3(0, 1, 0));
    layer.depth = {4, std::numeric_limits<float>::infinity()};
    return layer;
}

render::LayerShading shading_of(float caustic) {
    render::LayerShading shading;
    shading.albedo.assign(2, glm::vec3(0.6f));
    shading.direct.assign(2, glm::vec3(1));
    shading.sky.assign(2, glm::vec3(2));
    shading.flat_water.assign(2, glm::vec3(0));
    shading.caustics.irradiance = {glm::vec3(caustic), glm::vec3(0)};
    shading.caustics.covered = {1, 0};
    return shading;
}

float value(const image::Image& image, const std::string& channel, std::size_t pixel) {
    return image.find(channel)->values[pixel];
}

TEST(Film, ComposesPathsAndAveragesSamples) {
    render::Film film(2, 1, 2, {{0.1, 0.2, 0.3}});
    film.add(layer_of(0, 0), shading_of(3), {10, 0, 0});
    film.add(layer_of(1, 0), shading_of(5), {10, 0, 0});
    render::NonFinite non_finite;
    const image::Image image = film.finish(non_finite);
    EXPECT_EQ(non_finite.count, 0u);
    const float response = 0.5f * 0.6f / glm::pi<float>();
    EXPECT_NEAR(value(image, "R", 0), response * (4 + 1 + 2), 1e-6);
    EXPECT_NEAR(value(image, "G", 0), 0.5f * response * (4 + 1 + 2), 1e-6);
    EXPECT_NEAR(value(image, "caustics.R", 0), response * 4, 1e-6);
    EXPECT_NEAR(value(image, "direct.R", 0), response * 1, 1e-6);
    EXPECT_NEAR(value(image, "sky.R", 0), response * 2, 1e-6);
    EXPECT_NEAR(value(image, "G", 1), 0.8f * 0.2f, 1e-6);
    EXPECT_NEAR(value(image, "environment.G", 1), 0.8f * 0.2f, 1e-6);
    EXPECT_EQ(value(image, "A", 0), 1);
    EXPECT_EQ(value(image, "A", 1), 0);
    EXPECT_EQ(value(image, "E.R", 0), 4);
    EXPECT_EQ(value(image, "covered", 0), 1);
    EXPECT_EQ(value(image, "covered", 1), 0);
    EXPECT_EQ(value(image, "P.X", 0), 11);
    EXPECT_EQ(value(image, "Z", 0), 4);
    EXPECT_EQ(value(image, "Z", 1), 0);
}

TEST(Film, SecondBranchAddsLightButNoData) {
    render::Film film(2, 1, 1, {{0, 0, 0}});
    film.add(layer_of(0, 0), shading_of(3), {});
    view::ReceiverLayer second = layer_of(0, 1);
    second.position.assign(2, glm::vec3(99));
    film.add(second, shading_of(0), {});
    render::NonFinite non_finite;
    const image::Image image = film.finish(non_finite);
    EXPECT_NEAR(value(image, "direct.R", 0), 2 * 0.5f * 0.6f / glm::pi<float>(), 1e-6);
    EXPECT_EQ(value(image, "P.X", 0), 1);
    EXPECT_EQ(value(image, "E.R", 0), 3);
    EXPECT_EQ(value(image, "A", 0), 1);
}

TEST(Film, AMethodsDataAreThoseOfTheFirstSampleAndBranch) {
    const auto shading = [](float value) {
        render::LayerShading made = shading_of(1);
        made.caustics.data = {{"paths.count", {value, 0}}, {"E.variance.R", {0.5f, value}}};
        return made;
    };
    render::Film film(2, 1, 2, {{0, 0, 0}});
    film.add(layer_of(0, 0), shading(3), {});
    film.add(layer_of(0, 1), shading(7), {});
    film.add(layer_of(1, 0), shading(8), {});
    render::NonFinite non_finite;
    const image::Image image = film.finish(non_finite);
    EXPECT_EQ(value(image, "paths.count", 0), 3);
    EXPECT_EQ(value(image, "paths.count", 1), 0);
    EXPECT_EQ(value(image, "E.variance.R", 0), 0.5f);
    EXPECT_EQ(value(image, "E.variance.R", 1), 3);
    EXPECT_EQ(image.channels.size(), render::Film::kOwnChannels + 2);
}

TEST(Film, AddsWhatMediaScatterAndItsLayersWhereThePlanHasThem) {
    const auto with_volume = [](float direct, float caustics) {
        render::LayerShading shading = shading_of(0);
        shading.volume_direct.assign(2, glm::vec3(direct, 0, 0));
        shading.volume_caustics.assign(2, glm::vec3(0, caustics, caustics));
        return shading;
    };
    render::Film film(2, 1, 2, {{0, 0, 0}}, true);
    film.add(layer_of(0, 0), with_volume(1, 2), {});
    film.add(layer_of(0, 1), with_volume(10, 20), {});
    film.add(layer_of(1, 0), with_volume(3, 4), {});
    render::NonFinite non_finite;
    const image::Image image = film.finish(non_finite);
    EXPECT_EQ(image.channels.size(), render::Film::kOwnChannels + render::Film::kVolumeChannels);
    for (const std::size_t pixel : {0u, 1u}) {  // also of the path that met no surface
        EXPECT_EQ(value(image, "volume_direct.R", pixel), 7);
        EXPECT_EQ(value(image, "volume_direct.G", pixel), 0);
        EXPECT_EQ(value(image, "volume_caustics.G", pixel), 13);
        EXPECT_EQ(value(image, "volume.R", pixel), 7);
        EXPECT_EQ(value(image, "volume.B", pixel), 13);
    }
    EXPECT_EQ(value(image, "R", 1), 7);
    const float surface = value(image, "direct.B", 0) + value(image, "sky.B", 0);
    EXPECT_NEAR(value(image, "B", 0), surface + 13, 1e-5);

    render::Film without(2, 1, 1, {{0, 0, 0}});
    without.add(layer_of(0, 0), shading_of(0), {});
    EXPECT_EQ(without.finish(non_finite).find("volume.R"), nullptr);
}

TEST(Film, NonFiniteValuesAreReplacedCountedAndPlaced) {
    render::Film film(2, 1, 1, {{0, 0, 0}});
    render::LayerShading shading = shading_of(1);
    shading.direct[0].y = std::numeric_limits<float>::quiet_NaN();
    film.add(layer_of(0, 0), shading, {});
    render::NonFinite non_finite;
    const image::Image image = film.finish(non_finite);
    EXPECT_EQ(non_finite.count, 2u);
    EXPECT_EQ(non_finite.first, "G 0,0");
    EXPECT_EQ(value(image, "G", 0), 0);
    EXPECT_EQ(value(image, "direct.G", 0), 0);
}

}  // namespace
}  // namespace dapple
