// Splats seen by several samples a pixel: each stands for its own cell of the pixel
// (view::Camera::sample_cell).
#include <gtest/gtest.h>

#include <numeric>

#include "light/caustic_map.h"
#include "methods/splat_scene.h"

namespace dapple {
namespace {

using test::flat_pool;
using test::level;
using test::look_down;
using test::receivers_on_level;
using test::splat;

/// E's green of the floor below waves, mean over the samples of each of `side` x `side` pixels of the middle
/// 2 m, under a camera that stands askew.
std::vector<double> pixel_means(scene::FrameScene scene, scene::PhotonFootprint footprint, int side,
                                int samples) {
    look_down(scene, side, 2);
    scene.state.camera.up = {std::sin(0.6), 0, -std::cos(0.6)};
    scene.state.clip.samples = samples;
    scene.state.caustics.photon_splatting.footprint = footprint;
    std::vector<view::ReceiverLayer> layers;
    for (int sample = 0; sample < samples; ++sample)
        layers.push_back(receivers_on_level(scene, -1.5, sample));
    FrameStats stats;
    std::vector<double> mean(layers[0].pixels());
    for (const methods::LayerResult& result : splat(scene, {{0, light::Event::transmission}}, layers, stats))
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += static_cast<double>(result.irradiance[i].g) / samples;
    return mean;
}

TEST(SampleCells, AreThePixelsOfAFinerPicture) {
    // Waves that focus 1.5 m down, so that the floor is full of lines narrower than the coarser pixels.
    scene::FrameScene scene = flat_pool(20, 300);
    test::add_water(scene, test::gentle_sea(0.006), 120, 120);
    constexpr int kSide = 32;
    for (const auto footprint : {scene::PhotonFootprint::tent, scene::PhotonFootprint::photon_difference,
                                 scene::PhotonFootprint::point})
        for (const int finer : {2, 4}) {
            SCOPED_TRACE(testing::Message() << "footprint " << int(footprint) << ", " << finer);
            const std::vector<double> fine = pixel_means(scene, footprint, finer * kSide, 1);
            const std::vector<double> pixels = pixel_means(scene, footprint, kSide, 1);
            const std::vector<double> samples = pixel_means(scene, footprint, kSide, finer * finer);
            double apart = 0, apart_from_pixels = 0, sum = 0;
            for (std::size_t i = 0; i < samples.size(); ++i) {
                const std::size_t column = i % kSide, row = i / kSide, f = static_cast<std::size_t>(finer);
                double mean = 0;
                for (std::size_t k = 0; k < f * f; ++k)
                    mean += fine[(f * row + k / f) * f * kSide + f * column + k % f];
                mean /= static_cast<double>(f * f);
                apart += std::abs(samples[i] - mean);
                apart_from_pixels += std::abs(samples[i] - pixels[i]);
                sum += mean;
            }
            // The same kernels at the same places but for rounding: float positions, 2^-24 of 6 m, against
            // cells of 1.6 cm or more.
            EXPECT_LT(apart / sum, 1e-4);
            // A whole pixel's box blurs the lines by more.
            EXPECT_GT(apart_from_pixels / sum, 0.003);
        }
}

TEST(SampleCells, KeepTheFluxOfASeaByAnyNumberOfSamples) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::sun(25, 0)};
    scene.state.lights[0].irradiance = {1, 1, 1};
    scene.state.water->absorption = {0, 0, 0};
    scene.state.objects = {level(-1.5)};
    scene.state.caustics.map.map_resolution = 400;
    test::add_water(scene, test::gentle_sea(0.0032), 120, 120);
    FrameStats stats;
    light::CausticMapper mapper(test::validated_device());
    const light::BeamMesh mesh = mapper.trace(scene, rays::RayScene(scene), 0, {light::Event::transmission},
                                              scene.state.caustics.map, stats)[0];
    const double flux = std::accumulate(mesh.flux.begin(), mesh.flux.end(), 0.0);
    for (const auto footprint : {scene::PhotonFootprint::tent, scene::PhotonFootprint::point}) {
        scene.state.caustics.photon_splatting.footprint = footprint;
        for (const int samples : {1, 2, 3, 4}) {
            look_down(scene, 128, 10);  // all light, in pixels wider than photons are apart
            scene.state.clip.samples = samples;
            std::vector<view::ReceiverLayer> layers;
            for (int sample = 0; sample < samples; ++sample)
                layers.push_back(receivers_on_level(scene, -1.5, sample));
            double sum = 0;
            for (const methods::LayerResult& result :
                 splat(scene, {{0, light::Event::transmission}}, layers, stats))
                for (const glm::vec3& e : result.irradiance) sum += static_cast<double>(e.g) / samples;
            // Splats that lie oblique to the picture ripple by some percent of their flux with their place;
            // of 1.6e5 of them 1e-4 is left.
            const bool point = footprint == scene::PhotonFootprint::point;
            EXPECT_NEAR(sum * std::pow(10.0 / 128, 2) / flux, 1, point ? 1e-6 : 3e-4) << samples;
        }
    }
}

}  // namespace
}  // namespace dapple
