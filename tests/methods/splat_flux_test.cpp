// What footprints of all kinds and sizes make of flat water: their mean is the closed form's, and how uneven
// they leave it follows from their widths.
#include <gtest/gtest.h>

#include "methods/splat_scene.h"

namespace dapple {
namespace {

using Name = scene::PhotonFootprint;
constexpr int kPixels = 96;

double sinc(double x) {
    return x == 0 ? 1 : std::sin(glm::pi<double>() * x) / (glm::pi<double>() * x);
}

/// Variance along a line, relative, of kernels on a lattice of spacing 1 whose Fourier transform is
/// `transform`: by Parseval, over the lattice's harmonics.
template <class Transform>
double ripple_variance(Transform transform) {
    double variance = 0;
    for (int m = 1; m < 20000; ++m) variance += 2 * std::pow(transform(m), 2);
    return variance;
}

struct Flatness {
    double mean, deviation, worst, dark;  // of E over the expected one; share of pixels without light
};

Flatness flatness(const methods::LayerResult& result, const glm::dvec3& expected) {
    Flatness f{0, 0, 0, 0};
    for (const glm::vec3& e : result.irradiance) {
        const double ratio = static_cast<double>(e.g) / expected.g;
        f.mean += ratio;
        f.deviation += (ratio - 1) * (ratio - 1);
        f.worst = std::max(f.worst, std::abs(ratio - 1));
        f.dark += ratio == 0 ? 1 : 0;
    }
    const auto count = static_cast<double>(result.irradiance.size());
    f.mean /= count;
    f.deviation = std::sqrt(f.deviation / count);
    f.dark /= count;
    return f;
}

/// The picture shows a whole number of photons each way, `across`, so that its mean is the lattice's.
scene::FrameScene pool_of(Name footprint, double scale, int across, double zenith) {
    scene::FrameScene scene = test::flat_pool(zenith, 3 * across);
    scene.state.caustics.photon_splatting = {footprint, scale};
    test::look_down(scene, kPixels, 2);
    return scene;
}

struct Size {
    Name name;
    double scale;
};

TEST(FootprintFlux, IsKeptAtAnyScaleAndItsRippleFollowsFromTheWidths) {
    for (const double zenith : {0.0, 50.0})
        for (const auto& [name, scale] :
             {Size{Name::tent, 1}, Size{Name::tent, 0.6}, Size{Name::tent, 1.7}, Size{Name::fixed, 1},
              Size{Name::fixed, 0.4}, Size{Name::photon_differential, 1},
              Size{Name::photon_differential, 2.5}, Size{Name::photon_difference, 1},
              Size{Name::photon_difference, 2}, Size{Name::point, 1}})
            // Spacings of 8.7, 4, 1.4, 1 and half a pixel.
            for (const int across : {11, 24, 67, 96, 192}) {
                if (zenith > 0 && across != 11 && across != 96) continue;  // to be quick
                SCOPED_TRACE(testing::Message() << "zenith " << zenith << ", footprint " << int(name)
                                                << " times " << scale << ", photons " << across);
                const scene::FrameScene scene = pool_of(name, scale, across, zenith);
                const Flatness flat =
                    flatness(test::splat_level(scene, -1.5), test::flat_floor(scene, zenith));
                // Positions in float, of 2^-24 of 6 m each, against pixels of 2 cm.
                EXPECT_NEAR(flat.mean, 1, 1e-4);
                const double pixel = static_cast<double>(across) / kPixels;  // of the spacing
                const bool whole = scale == std::round(scale) && name != Name::point;
                if (whole) {
                    EXPECT_LT(flat.worst, 1e-3);
                } else if (across == 11 || across == 67) {  // pixels at all phases of the lattice
                    const double variance = ripple_variance([&, name = name, scale = scale](int m) {
                        const double shape = name == Name::point  ? sinc(0.01 * m * pixel)
                                             : name == Name::tent ? std::pow(sinc(m * scale), 2)
                                                                  : sinc(m * scale);
                        return shape * sinc(m * pixel);
                    });
                    const double expected = std::sqrt(std::pow(1 + variance, 2) - 1);
                    // 96 phases stand for all; they see the edges of points coarsely.
                    EXPECT_NEAR(flat.deviation, expected,
                                (name == Name::point ? 0.06 : 0.003) * expected + 1e-4);
                    if (zenith == 0)
                        printf(
                            "footprint %d times %.1f, spacing of %4.1f pixels: ripple %.4f, by widths %.4f\n",
                            static_cast<int>(name), scale, 1 / pixel, flat.deviation, expected);
                }
            }
}

TEST(FootprintFlux, IsKeptUnderTheSunsDisc) {
    for (const auto& [name, scale] : {Size{Name::tent, 1.7}, Size{Name::fixed, 0.4},
                                      Size{Name::photon_differential, 1.3}, Size{Name::photon_difference, 1}})
        for (const int across : {24, 96}) {  // whose harmonics are the pixels'
            scene::FrameScene scene = pool_of(name, scale, across, 0);
            scene.state.lights[0].angular_diameter = 3 * scene::kDegree;  // of 3 pixels on the floor
            const Flatness flat = flatness(test::splat_level(scene, -1.5), test::flat_floor(scene, 0));
            EXPECT_NEAR(flat.mean, 1, 1e-4) << int(name) << " " << across;
        }
}

TEST(FootprintFlux, OfASeaIsKeptByAllFootprints) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::sun(25, 0)};
    scene.state.water->absorption = {0, 0, 0};
    scene.state.caustics.map.map_resolution = 256;
    test::add_water(scene, test::gentle_sea(), 150, 150);
    scene.state.objects = {test::level(-2)};
    test::look_down(scene, 256, 10);
    const auto flux = [&](Name name, double scale) {
        scene.state.caustics.photon_splatting = {name, scale};
        double sum = 0;
        for (const glm::vec3& e : test::splat_level(scene, -2).irradiance) sum += static_cast<double>(e.g);
        return sum * std::pow(10.0 / 256, 2);
    };
    const double tents = flux(Name::tent, 1);
    EXPECT_GT(tents, 10);
    // That tents catch the water's flux to 1e-4 is tested beside. Samples of single splats ripple with their
    // place, which averages out over 7e4 of them.
    for (const auto& [name, scale] : {Size{Name::fixed, 2.3}, Size{Name::photon_differential, 1},
                                      Size{Name::photon_difference, 0.7}, Size{Name::point, 1}})
        EXPECT_NEAR(flux(name, scale) / tents, 1, 4e-4) << int(name) << " " << scale;
}

/// The paper's share of light 1.5 m below flat water, for Fresnel's and that of the media.
double paper_share(double zenith) {
    const double i = glm::radians(zenith), t = std::asin(std::sin(i) / test::kIndex);
    const double straight = std::pow((test::kIndex - 1) / (test::kIndex + 1), 2);
    const double fresnel = straight + (1 - straight) * std::pow(1 - std::cos(i), 5);
    const double left = 1 - 1.5 / std::cos(t) / 60;  // equation 13, above gamma
    return (1 - fresnel) * (1 - (left - 0.95) / 0.05);
}

TEST(PaperFootprint, OverFlatWaterTilesWhereTheSunIsOverheadAndLeavesGapsElsewhere) {
    for (const double zenith : {0.0, 50.0})
        for (const Name name : {Name::fixed, Name::photon_differential, Name::photon_difference}) {
            SCOPED_TRACE(testing::Message() << "zenith " << zenith << ", footprint " << int(name));
            scene::FrameScene scene = pool_of(name, 1, 67, zenith);
            scene.state.caustics.map.paper_faithful = true;
            const double i = glm::radians(zenith), t = std::asin(std::sin(i) / test::kIndex);
            const bool kougianos = name != Name::photon_difference;
            const glm::dvec3 expected =
                kougianos ? scene.state.lights[0].irradiance * std::cos(i) * paper_share(zenith)
                          : test::flat_floor(scene, zenith);
            const Flatness flat = flatness(test::splat_level(scene, -1.5), expected);
            // Squares of the light's cell, stretched by 1 / cos(t), on a lattice stretched by 1 / cos(i).
            const double dark = kougianos ? 1 - std::cos(i) / std::cos(t) : 0;
            // Points of pixels are in or out of a quad: of 96 phases one may differ, at each edge.
            // Equation 19's epsilon makes quads smaller and brighter by 1e-4.
            EXPECT_NEAR(flat.mean, 1, zenith == 0 || !kougianos ? 2e-4 : 0.04);
            EXPECT_NEAR(flat.dark, dark, 0.04);
            printf(
                "paper's footprint %d, sun %2.0f deg from the zenith: mean %.4f, %.1f %% dark, expected "
                "%.1f\n",
                static_cast<int>(name), zenith, flat.mean, 100 * flat.dark, 100 * dark);
        }
}

TEST(PaperFootprint, OfCompressionIsRightOnFlatWaterAndTooBrightAtFoci) {
    scene::FrameScene scene = pool_of(Name::point, 1, 67, 50);
    scene.state.caustics.map.paper_faithful = true;
    EXPECT_NEAR(flatness(test::splat_level(scene, -1.5), test::flat_floor(scene, 50)).mean, 1, 0.01);
    test::add_water(scene, test::gentle_sea(), 300, 300);
    const double paper = flatness(test::splat_level(scene, -1.5), glm::dvec3(1)).mean;
    scene.state.caustics.map.paper_faithful = false;
    // By the mean of the ratio over the light, which is above one wherever there is a caustic.
    EXPECT_GT(paper, 1.1 * flatness(test::splat_level(scene, -1.5), glm::dvec3(1)).mean);
}

TEST(PaperFootprint, LightsWhateverLiesBehindIt) {
    for (const bool paper : {false, true}) {
        scene::FrameScene scene = pool_of(Name::photon_difference, 1, 67, 0);
        scene.state.caustics.map.paper_faithful = paper;
        FrameStats stats;
        std::vector<view::ReceiverLayer> layers(5, test::receivers_on_level(scene, -1.5));
        for (std::size_t i = 0; i < layers[0].pixels(); ++i) {
            layers[1].position[i].y -= 0.2f;    // through a grid, on what lies below: it leaks
            layers[2].position[i].y += 0.1f;    // a shelf above the floor
            layers[3].position[i].y += 0.005f;  // within the bias, and on the plane
            layers[4].shading_normal[i] = {0, -1, 0};
        }
        const auto results = test::splat(scene, {{0, light::Event::transmission}}, layers, stats);
        for (std::size_t k = 0; k < layers.size(); ++k) {
            std::size_t lit = 0;
            for (const glm::vec3& e : results[k].irradiance) lit += e.g > 0 ? 1 : 0;
            const bool expected = k == 0 || k == 3 || (k == 1 && paper);
            EXPECT_EQ(lit, expected ? layers[0].pixels() : 0) << k << " " << paper;
        }
    }
}

}  // namespace
}  // namespace dapple
