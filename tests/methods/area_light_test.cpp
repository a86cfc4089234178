// Quads and discs over water: photon splatting and the reference against integrals over the emitter and each
// other.
#include <gtest/gtest.h>

#include "closed_form/gentle_sea.h"
#include "light/emitters.h"
#include "methods/reference_frame.h"
#include "methods/splat_scene.h"

namespace dapple {
namespace {

using test::Frame;
using test::LayerResult;
using test::relative_l1;

/// A pool of 6 m, 1 m deep, its floor seen from above, under a panel.
scene::FrameState pool_under(const scene::Light& panel, double view, int pixels) {
    scene::FrameState state = test::pool_over_floor(6, 1, view, pixels);
    state.lights = {panel};
    state.caustics.reference = test::kOneRound;
    state.caustics.map.map_resolution = 128;
    return state;
}

std::vector<scene::Light> panels(int samples) {
    return {test::quad_panel({0.2, 1.5, 0.1}, {1.2, 0.6}, samples),
            test::disc_panel({-0.2, 2, 0.3}, 0.5, samples)};
}

std::vector<light::Chain> chains_of(const scene::FrameState& state) {
    std::vector<light::Chain> chains;
    for (std::size_t i = 0; i < state.lights.size(); ++i)
        chains.push_back({static_cast<int>(i), light::Event::transmission});
    return chains;
}

LayerResult by_reference(const scene::FrameState& state) {
    Frame frame(scene::with_emitter_parts(state));
    frame.chains = chains_of(frame.scene.state);
    return frame.render();
}

using scene::PhotonFootprint;

/// `widened`: by what each part of the emitter stands for.
LayerResult by_photons(const scene::FrameState& state, bool widened = true,
                       PhotonFootprint footprint = PhotonFootprint::tent) {
    Frame frame(scene::with_emitter_parts(state));
    frame.scene.state.caustics.photon_splatting.footprint = footprint;
    if (!widened)
        for (scene::Light& light : frame.scene.state.lights)
            light.part.spread_u = light.part.spread_v = glm::dvec3(0);
    const std::vector<view::ReceiverLayer> layers = {test::receivers_on_level(frame.scene, -1)};
    return test::splat(frame.scene, chains_of(frame.scene.state), layers, frame.stats)[0];
}

/// The red of E on the floor of a pool 1 m deep below flat water, the means of pixels: the light of lamps, by
/// their distance, summed up over the emitter.
std::vector<double> below_flat_water(const scene::FrameState& state, double view, int pixels) {
    const scene::Light& panel = state.lights[0];
    const scene::Water& water = *state.water;
    const double height = panel.position.y;
    constexpr double kStep = 2e-3;  // m; linear between
    std::vector<double> by_distance;
    for (int i = 0; i < 2500; ++i)
        by_distance.push_back(
            test::across_flat_water(height, 1, 1, water.refractive_index, std::max(1e-6, i * kStep),
                                    [&](double air, double in_water) {
                                        return height / air * std::exp(-water.absorption.x * in_water);
                                    }));
    const auto value = [&](double x, double z) {
        return panel.radiance.x *
               test::over_panel(
                   panel,
                   [&](glm::dvec3 from) {
                       const double at = std::hypot(x - from.x, z - from.z) / kStep;
                       const auto i = static_cast<std::size_t>(at);
                       return glm::mix(by_distance[i], by_distance[i + 1], at - std::floor(at));
                   },
                   16);
    };
    return test::pixel_means(view, pixels, value);
}

TEST(AreaLight, OverFlatWaterByTheReference) {
    for (const scene::Light& panel : panels(2)) {
        const scene::FrameState state = pool_under(panel, 3, 16);
        test::expect_agreement(test::agreement(by_reference(state), below_flat_water(state, 3, 16)));
    }
}

constexpr PhotonFootprint kFootprints[] = {PhotonFootprint::tent, PhotonFootprint::photon_difference};

TEST(AreaLight, OverFlatWaterByPhotons) {
    for (const scene::Light& panel : panels(16)) {
        const scene::FrameState state = pool_under(panel, 3, 16);
        const std::vector<double> expected = below_flat_water(state, 3, 16);
        for (const PhotonFootprint footprint : kFootprints) {
            const LayerResult found = by_photons(state, true, footprint);
            double worst = 0;
            for (std::size_t i = 0; i < expected.size(); ++i)
                worst =
                    std::max(worst, std::abs(static_cast<double>(found.irradiance[i].x) / expected[i] - 1));
            printf("footprint %d: worst pixel %.1e\n", static_cast<int>(footprint), worst);
            // Boxes follow light that falls off by steps, of which a pixel's edge cuts one: 0.05 of a
            // photon's 4.7 cm a metre.
            EXPECT_LT(worst, footprint == PhotonFootprint::tent ? 1.5e-3 : 2.5e-3);
        }
    }
}

TEST(AreaLight, FluxOnACatchingFloorByPhotons) {
    for (const scene::Light& panel : panels(16)) {
        scene::FrameState state = pool_under(panel, 16, 128);
        state.water->absorption = glm::dvec3(0);
        double fluxes[2] = {0, 0};
        for (std::size_t k = 0; k < 2; ++k)
            for (const glm::vec3& e : by_photons(state, true, kFootprints[k]).irradiance)
                fluxes[k] += static_cast<double>(e.x) * std::pow(16.0 / 128, 2);
        // pi L A is sent down: what meets the pool by the cosines at both ends, times what the water lets
        // through.
        constexpr int kSteps = 64;
        const double expected =
            panel.radiance.x *
            test::over_panel(
                panel,
                [&](glm::dvec3 from) {
                    double sum = 0;
                    for (int i = 0; i < kSteps * kSteps; ++i) {
                        const glm::dvec2 at =
                            6.0 * ((glm::dvec2(i % kSteps, i / kSteps) + 0.5) / double{kSteps} - 0.5);
                        const glm::dvec3 way = glm::dvec3(at.x, 0, at.y) - from;
                        const double square = glm::dot(way, way), cosine = from.y / std::sqrt(square);
                        sum += cosine * cosine / square *
                               (1 - test::refract(std::acos(cosine), 1, 1.333).reflectance);
                    }
                    return sum * 36 / (kSteps * kSteps);
                },
                12);
        for (const double flux : fluxes) {
            printf("flux %.4f of %.4f W\n", flux, expected);
            EXPECT_NEAR(flux / expected, 1, 1e-3);
        }
    }
}

TEST(AreaLight, UnderWavesFewPointsDoWhereTheyWidenSplats) {
    scene::FrameState state = pool_under(test::quad_panel({0.1, 2, 0}, {0.4, 0.4}, 1), 1.2, 24);
    state.water->extent.size = {2.4, 2.4};
    state.water->surface.type = scene::WaterSurfaceType::waves;
    state.water->surface.waves = test::gentle_waves();
    for (scene::Wave& wave : state.water->surface.waves.waves) wave.amplitude *= 3;
    state.water->mesh_cells = 128;
    state.caustics.map.map_resolution = 128;
    const auto points = [&](int samples, bool widened, PhotonFootprint footprint = PhotonFootprint::tent) {
        state.lights[0].samples = samples;
        return by_photons(state, widened, footprint);
    };
    const LayerResult truth = points(100, false);
    state.lights[0].samples = 1;
    const LayerResult reference = by_reference(state);
    std::vector<double> expected;
    for (const glm::vec3& e : truth.irradiance) expected.push_back(static_cast<double>(e.x));
    test::expect_agreement(test::agreement(reference, expected));
    for (const int samples : {4, 16}) {
        const double with = relative_l1(points(samples, true), truth);
        const double without = relative_l1(points(samples, false), truth);
        printf("%d points: L1 widened %.2f %%, as they are %.2f %%\n", samples, 100 * with, 100 * without);
        EXPECT_LT(with, 0.02 / samples);
        // Measured 0.49: half a variance and more is that of the second order, which the widening holds.
        EXPECT_LT(with, 0.6 * without);
        const double differences =
            relative_l1(points(samples, true, PhotonFootprint::photon_difference), truth);
        printf("  by photon differences %.2f %%\n", 100 * differences);
        EXPECT_LT(differences, 0.02 / samples);
    }
}

}  // namespace
}  // namespace dapple
