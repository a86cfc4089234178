#include <gtest/gtest.h>

#include <algorithm>

#include "gpu/validated_device.h"
#include "methods/coverage_scene.h"

namespace dapple {
namespace {

using methods::CoverageBackend;
using methods::LayerResult;
using methods::SlicedBeams;

/// What one way of computing coverage made of a frame.
struct Rendered {
    std::vector<LayerResult> results;
    FrameStats stats;

    double on_device() const { return stats.counted("tiles covered on the device"); }
};

Rendered render(test::CoverageFrame& frame, CoverageBackend backend) {
    Rendered rendered;
    SlicedBeams method(backend);
    rendered.results = frame.irradiance(method, rendered.stats);
    return rendered;
}

double mean(const std::vector<glm::vec3>& values) {
    double sum = 0;
    for (const glm::vec3& v : values) sum += static_cast<double>(v.x + v.y + v.z) / 3;
    return sum / static_cast<double>(values.size());
}

/// Arithmetic is the same operation by operation; only sums run in another order. Some 100 terms of one sign,
/// each rounded to 6e-8, stay far below 1e-5, the figure to be held. Below 1e-3 of the mean, where a receiver
/// hangs on the rim of a beam or two, that part of the figure is the bound.
void expect_equal(const Rendered& cpu, const Rendered& device) {
    const std::vector<glm::vec3>&a = cpu.results[0].irradiance, &b = device.results[0].irradiance;
    ASSERT_EQ(a.size(), b.size());
    ASSERT_EQ(cpu.results[0].covered, device.results[0].covered);
    const double least = 1e-3 * mean(a);
    ASSERT_GT(least, 0);
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 3; ++c)
            largest =
                std::max(largest, std::abs(static_cast<double>(a[i][c]) - static_cast<double>(b[i][c])) /
                                      std::max(least, static_cast<double>(a[i][c])));
    EXPECT_LE(largest, 1e-5);
    EXPECT_EQ(cpu.on_device(), 0);
}

class CoveragePassOfAPool : public ::testing::TestWithParam<double> {};

TEST_P(CoveragePassOfAPool, EqualsTheCpu) {
    const scene::FrameScene scene = test::pool_scene(320, 180, 400, GetParam());
    test::CoverageFrame frame(test::validated_device(), scene);
    const Rendered cpu = render(frame, CoverageBackend::cpu);
    const Rendered device = render(frame, CoverageBackend::compute);
    expect_equal(cpu, device);
    // The column and the sphere stand in the light of less than two thirds of the 40 x 23 tiles.
    EXPECT_GT(device.on_device(), 40 * 23 / 3);
    // And what is left to the CPU is there too: pairs hidden by them.
    EXPECT_GT(device.stats.counted("caustic shadow rays"), 0);
}
INSTANTIATE_TEST_SUITE_P(SunsDisc, CoveragePassOfAPool, ::testing::Values(0.0, 0.53));  // deg

TEST(CoveragePass, EqualsTheCpuOnACurvedSurface) {
    scene::FrameScene scene = test::pool_scene(160, 90, 400, 0);
    scene.state.objects = {scene.state.objects[4]};
    scene.state.objects[0].radius = 20;
    scene.state.objects[0].transform.position.y = -21.5;
    test::CoverageFrame frame(test::validated_device(), scene);
    const Rendered device = render(frame, CoverageBackend::compute);
    expect_equal(render(frame, CoverageBackend::cpu), device);
    EXPECT_EQ(device.stats.counted("caustic shadow rays"), 0);
    EXPECT_GT(device.on_device(), 100);
}

TEST(CoveragePass, EqualsTheCpuOverManyBatches) {
    scene::FrameScene scene = test::pool_scene(480, 480, 200, 0);  // 3600 tiles, of which 1024 are a batch
    scene.state.objects.resize(1);
    test::CoverageFrame frame(test::validated_device(), scene);
    const Rendered device = render(frame, CoverageBackend::compute);
    expect_equal(render(frame, CoverageBackend::cpu), device);
    EXPECT_GT(device.on_device(), 1024);
}

TEST(CoveragePass, GivesTheSameBitsAgainAndForLayersTogether) {
    const scene::FrameScene scene = test::pool_scene(160, 90, 200, 0);
    test::CoverageFrame frame(test::validated_device(), scene);
    const Rendered first = render(frame, CoverageBackend::compute);
    ASSERT_GT(first.on_device(), 0);
    frame.layers().push_back(frame.layers()[0]);
    const Rendered both = render(frame, CoverageBackend::compute);
    EXPECT_EQ(first.results[0].irradiance, both.results[0].irradiance);
    EXPECT_EQ(first.results[0].irradiance, both.results[1].irradiance);
}

TEST(SlicedBeams, CountsPathsUnlessToldNotTo) {
    scene::FrameScene scene = test::pool_scene(64, 36, 100, 0);
    test::CoverageFrame frame(test::validated_device(), scene);
    frame.layers()[0].branch = 0;
    const Rendered counted = render(frame, CoverageBackend::cpu);
    ASSERT_EQ(counted.results[0].data.size(), 3u);
    scene.state.caustics.sliced_beams.path_counts = false;
    const Rendered plain = render(frame, CoverageBackend::cpu);
    EXPECT_TRUE(plain.results[0].data.empty());
    EXPECT_EQ(plain.results[0].irradiance, counted.results[0].irradiance);
}

TEST(CoveragePass, IsChosenByTheTypeOfTheDevice) {
    const scene::FrameScene scene = test::pool_scene(64, 36, 100, 0);
    gpu::Device& device = test::validated_device();
    test::CoverageFrame frame(device, scene);
    const bool computes = render(frame, CoverageBackend::automatic).on_device() > 0;
    EXPECT_EQ(computes, device.info().type != gpu::DeviceType::cpu);
    EXPECT_GT(render(frame, CoverageBackend::compute).on_device(), 0);
}

}  // namespace
}  // namespace dapple
