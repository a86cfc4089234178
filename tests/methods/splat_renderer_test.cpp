#include "methods/photon_splatting/splat_renderer.h"

#include <gtest/gtest.h>

#include "light/caustic_map.h"
#include "light/landing.h"
#include "methods/coverage_scene.h"
#include "methods/photon_splatting/splat_builder.h"
#include "methods/splat_scene.h"
#include "view/camera_paths.h"

namespace dapple {
namespace {

using Renderers = std::vector<std::unique_ptr<methods::SplatRenderer>>;

struct Drawn {
    std::vector<std::vector<methods::LayerResult>> results;  ///< a renderer each
    std::size_t points = 0, quads = 0;
};

/// Light that the water sends down, of a map of the scene's resolution. `largest_point`: pixels.
Drawn draw(const scene::FrameScene& scene, const Renderers& renderers, float largest_point,
           std::span<const view::ReceiverLayer> layers) {
    const rays::RayScene rays(scene);
    const media::Media media(scene);
    const methods::SplatStyle style = methods::splat_style(scene.state.caustics);
    FrameStats stats;
    light::CausticMapper mapper(test::validated_device());
    const light::BeamMesh mesh =
        mapper.trace(scene, rays, 0, {light::Event::transmission}, scene.state.caustics.map, stats)[0];
    const light::Landings landings = light::land(mesh, rays);
    Drawn drawn;
    for (const auto& renderer : renderers) {
        methods::build_splats(scene, media, mesh, landings, style, largest_point,
                              [&](const methods::Splats& some) { renderer->add(some); });
        drawn.results.emplace_back(layers.size());
        renderer->render(scene, style, layers, drawn.results.back(), stats);
        drawn.points = renderer->points();
        drawn.quads = renderer->quads();
    }
    return drawn;
}

TEST(SplatRenderer, DrawsTheSameFromBuffersOfAnySize) {
    scene::FrameScene scene = test::flat_pool(20, 60);
    test::add_water(scene, test::gentle_sea(), 60, 60);
    test::look_down(scene, 32, 2);
    const std::vector<view::ReceiverLayer> layers = {test::receivers_on_level(scene, -1.5)};
    Renderers renderers;
    // A band of eight rows of this map has some hundred splats.
    for (const std::size_t largest : {std::size_t{1} << 20, 37 * sizeof(layout::Splat)})
        renderers.push_back(methods::device_splat_renderer(test::validated_device(), largest));
    const Drawn drawn = draw(scene, renderers, 64, layers);
    EXPECT_GT(drawn.points, 200u);
    EXPECT_EQ(drawn.results[0][0].irradiance, drawn.results[1][0].irradiance);
    EXPECT_GT(drawn.results[0][0].irradiance[500].g, 0);
}

class HostAndDevice : public testing::TestWithParam<std::tuple<scene::PhotonFootprint, bool, bool>> {};

TEST_P(HostAndDevice, DrawTheSame) {
    const auto [footprint, paper, orthographic] = GetParam();
    scene::FrameScene scene = test::pool_scene(171, 90, 64, 0.3);
    scene.state.clip.samples = 4;
    scene.state.caustics.map.map_resolution = 150;
    scene.state.caustics.map.paper_faithful = paper;
    scene.state.caustics.photon_splatting.footprint = footprint;
    if (orthographic) scene.state.camera.projection = scene::Projection::orthographic;
    const rays::RayScene rays(scene);
    view::LayerCounts counts;
    std::vector<view::ReceiverLayer> layers;
    for (int sample = 0; sample < 5; ++sample)
        layers.push_back(view::trace_layer(scene, rays, {sample % 4, 0}, counts));
    Renderers renderers;
    renderers.push_back(methods::host_splat_renderer());
    renderers.push_back(methods::device_splat_renderer(test::validated_device()));
    const Drawn drawn = draw(scene, renderers, 6, layers);
    EXPECT_GT(drawn.points, 1000u);
    EXPECT_GT(drawn.quads, 0u);
    double off = 0, sum = 0;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const methods::LayerResult &host = drawn.results[0][k], &device = drawn.results[1][k];
        EXPECT_EQ(host.covered, device.covered);
        for (std::size_t i = 0; i < layers[k].pixels(); ++i) {
            off += static_cast<double>(glm::distance(host.irradiance[i], device.irradiance[i]));
            sum += static_cast<double>(glm::length(device.irradiance[i]));
        }
    }
    printf("off by %.1e, %zu points, %zu quads\n", off / sum, drawn.points, drawn.quads);
    // Rounding of kernels' coordinates, and the device's normals, coded to 2e-4.
    EXPECT_LT(off, 2e-4 * sum);
    EXPECT_GT(sum, 0);
    // A splat forgotten is a splat not drawn.
    renderers[0]->clear();
    EXPECT_EQ(renderers[0]->points() + renderers[0]->quads(), 0u);
    FrameStats stats;
    std::vector<methods::LayerResult> dark(1);
    renderers[0]->render(scene, methods::splat_style(scene.state.caustics), {layers.data(), 1}, dark, stats);
    EXPECT_EQ(dark[0].irradiance, std::vector<glm::vec3>(layers[0].pixels(), glm::vec3(0)));
}

INSTANTIATE_TEST_SUITE_P(OfStyles, HostAndDevice,
                         testing::Combine(testing::Values(scene::PhotonFootprint::tent,
                                                          scene::PhotonFootprint::fixed,
                                                          scene::PhotonFootprint::photon_difference),
                                          testing::Bool(), testing::Bool()));

TEST(PhotonSplatting, DrawsByTheTypeOfTheDevice) {
    scene::FrameScene scene = test::flat_pool(20, 300);
    test::add_water(scene, test::gentle_sea(), 100, 100);
    test::look_down(scene, 64, 2);
    const std::vector<view::ReceiverLayer> layers = {test::receivers_on_level(scene, -1.5)};
    const auto irradiance = [&](methods::RasterBackend backend) {
        FrameStats stats;
        return test::splat(scene, {{0, light::Event::transmission}}, layers, stats, backend)[0].irradiance;
    };
    const auto host = irradiance(methods::RasterBackend::host),
               device = irradiance(methods::RasterBackend::device);
    EXPECT_NE(host, device);  // by rounding
    const bool on_cpu = test::validated_device().info().type == gpu::DeviceType::cpu;
    EXPECT_EQ(irradiance(methods::RasterBackend::automatic), on_cpu ? host : device);
}

}  // namespace
}  // namespace dapple
