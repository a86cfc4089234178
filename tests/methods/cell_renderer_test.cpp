#include "methods/caustic_mesh/cell_renderer.h"

#include <gtest/gtest.h>

#include "methods/coverage_scene.h"
#include "methods/flat_water_light.h"
#include "view/camera_paths.h"

namespace dapple {
namespace {

namespace caustic_mesh = methods::caustic_mesh;

TEST(CellRenderer, BandsLargerThanABufferAreDrawn) {
    const scene::FrameScene scene = test::flat_pool(20, 8, 16);
    const view::ReceiverLayer layer = test::receivers_on(scene, test::kPoolFloor, true);
    layout::MeshCell cell{};
    cell.corner_0 = layer.position[0] + glm::vec3(-1, 0, -1);
    cell.corner_1 = layer.position[0] + glm::vec3(3, 0, -1);
    cell.corner_2 = layer.position[0] + glm::vec3(3, 0, 3);
    cell.corner_3 = layer.position[0] + glm::vec3(-1, 0, 3);
    cell.normal = cell.facing = {0, 1, 0};
    cell.tolerance = 0.1f;
    cell.in_water = 1;
    cell.center = {8, 8};
    cell.edge_a = {8, 0};
    cell.edge_b = {0, 8};
    layout::MeshCell outside = cell;  // of the picture
    outside.center = {-1000, -1000};
    cell.irradiance_0 = cell.irradiance_1 = cell.irradiance_2 = cell.irradiance_3 = {1, 2, 3};

    constexpr std::size_t kMost = 100;
    const std::unique_ptr<caustic_mesh::CellRenderer> renderer =
        caustic_mesh::device_cell_renderer(test::validated_device(), kMost * sizeof(layout::MeshCell));
    caustic_mesh::Cells cells;
    cells.points.resize(3);
    cells.points[1].assign(3 * kMost, outside);
    cells.points[1].push_back(cell);
    cells.points[2].push_back(cell);
    renderer->add(cells);
    EXPECT_EQ(renderer->points(), 3 * kMost + 2);
    methods::LayerResult result;
    FrameStats stats;
    renderer->render(scene, true, {&layer, 1}, {&result, 1}, stats);
    EXPECT_NEAR(result.irradiance[0].g, 4.0f, 1e-5f);  // of the two cells
}

class HostAndDeviceCells : public testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(HostAndDeviceCells, DrawTheSame) {
    const auto [paper, orthographic] = GetParam();
    scene::FrameScene scene = test::pool_scene(171, 90, 64, 0.3);
    scene.state.clip.samples = 4;
    scene.state.lights[0].angular_diameter = 0.53 * scene::kDegree;
    scene.state.caustics.map.map_resolution = 100;
    scene.state.caustics.map.paper_faithful = paper;
    if (orthographic) scene.state.camera.projection = scene::Projection::orthographic;
    const rays::RayScene rays(scene);
    view::LayerCounts counts;
    std::vector<view::ReceiverLayer> layers;
    for (int sample = 0; sample < 5; ++sample)
        layers.push_back(view::trace_layer(scene, rays, {sample % 4, 0}, counts));
    std::vector<std::vector<methods::LayerResult>> drawn;
    for (const auto backend :
         {methods::RasterBackend::host, methods::RasterBackend::device, methods::RasterBackend::automatic}) {
        FrameStats stats;
        drawn.push_back(test::draw_mesh(scene, light::Event::transmission, layers, stats, backend));
        EXPECT_GT(stats.counted("mesh cells"), 1000);
        EXPECT_GT(stats.counted("large mesh cells"), 10);
    }
    double off = 0, sum = 0;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        EXPECT_EQ(drawn[0][k].covered, drawn[1][k].covered);
        for (std::size_t i = 0; i < layers[k].pixels(); ++i) {
            off += static_cast<double>(glm::distance(drawn[0][k].irradiance[i], drawn[1][k].irradiance[i]));
            sum += static_cast<double>(glm::length(drawn[1][k].irradiance[i]));
        }
    }
    printf("off by %.1e\n", off / sum);
    EXPECT_LT(off, 1e-5 * sum);  // rounding of corners from receivers, over their distances
    EXPECT_GT(sum, 0);
    const bool on_cpu = test::validated_device().info().type == gpu::DeviceType::cpu;
    for (std::size_t k = 0; k < layers.size(); ++k)
        EXPECT_EQ(drawn[2][k].irradiance, drawn[on_cpu ? 0 : 1][k].irradiance);
}

INSTANTIATE_TEST_SUITE_P(OfStyles, HostAndDeviceCells, testing::Combine(testing::Bool(), testing::Bool()));

}  // namespace
}  // namespace dapple
