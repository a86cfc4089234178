// Beams whose channels are dimmed unlike before the surface: each channel is what it is where all are dimmed
// as it.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "closed_form/segment_row.h"
#include "gpu/validated_device.h"
#include "methods/coverage_scene.h"

namespace dapple {
namespace {

using light::Event;
using methods::CoverageBackend;
using test::Ends;

/// Murky water under red-brown smoke, which is denser over a half of it.
scene::FrameScene smoky_pool(int width, int height, int cells, const glm::dvec3& extinction) {
    scene::FrameScene scene = test::pool_scene(width, height, cells, 0);
    scene.state.water->absorption = {0.2, 0.1, 0.05};
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    for (const double middle : {0.0, 11.5}) {
        scene::Medium& smoke = scene.state.media.emplace_back();
        smoke.type = scene::MediumType::box;
        smoke.side = scene::MediumSide::air;
        smoke.size = {20, 0.5, 20};
        smoke.transform.position = {middle, 1, 0};
        smoke.extinction = extinction;
        smoke.albedo = {0.9, 0.8, 0.7};
    }
    return scene;
}

const glm::dvec3 kExtinction(0.3, 0.9, 2.1);

/// The largest difference in parts of the larger of a value and the channel's mean. `grey(channel)`: where
/// all channels are dimmed as that one.
template <class Grey>
double difference(const std::vector<glm::vec3>& coloured, Grey&& grey) {
    double largest = 0;
    for (int c = 0; c < 3; ++c) {
        const std::vector<glm::vec3> expected = grey(c);
        double mean = 0;
        for (const glm::vec3& e : expected)
            mean += static_cast<double>(e[c] / static_cast<float>(expected.size()));
        EXPECT_GT(mean, 0);
        for (std::size_t i = 0; i < expected.size(); ++i)
            largest = std::max(largest, static_cast<double>(std::abs(coloured[i][c] - expected[i][c])) /
                                            std::max(mean, static_cast<double>(expected[i][c])));
    }
    return largest;
}

struct Case {
    CoverageBackend backend;
    int width, height, cells;
    const char* walked;  ///< what is to be more than 0 of its stats
};

class TintedBeams : public testing::TestWithParam<Case> {};

TEST_P(TintedBeams, GiveEachChannelsIrradiance) {
    const Case& given = GetParam();
    const auto irradiance = [&](const glm::dvec3& extinction) {
        const scene::FrameScene scene = smoky_pool(given.width, given.height, given.cells, extinction);
        test::CoverageFrame frame(test::validated_device(), scene);
        methods::SlicedBeams method(given.backend);
        FrameStats stats;
        std::vector<glm::vec3> found = frame.irradiance(method, stats)[0].irradiance;
        EXPECT_GT(stats.counted(given.walked), 0);
        return found;
    };
    const auto grey = [&](int channel) { return irradiance(glm::dvec3(kExtinction[channel])); };
    // Sums of some hundred floats, each rounded to 6e-8: 2e-7 measured.
    EXPECT_LE(difference(irradiance(kExtinction), grey), 2e-6);
}

INSTANTIATE_TEST_SUITE_P(Surfaces, TintedBeams,
                         testing::Values(Case{CoverageBackend::cpu, 160, 90, 160, "beam clusters found"},
                                         Case{CoverageBackend::cpu, 24, 14, 500, "nodes added whole"},
                                         Case{CoverageBackend::compute, 160, 90, 160,
                                              "tiles covered on the device"}));

class TintedScatter : public testing::TestWithParam<CoverageBackend> {};

TEST_P(TintedScatter, IsThatOfEachChannel) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<Ends> ends;
    for (int i = 0; i < 200; ++i) {
        const double y = i % 2 == 0 ? -1 : 1;
        const auto end = [&] {
            return glm::dvec3(2.8 * uniform(random), y + 0.8 * uniform(random), 2.8 * uniform(random));
        };
        ends.push_back({end(), end()});
    }
    const view::SegmentLayer layer = test::row_of_segments(ends);
    const auto scattered = [&](const glm::dvec3& extinction) {
        const scene::FrameScene scene = smoky_pool(8, 8, 160, extinction);
        const rays::RayScene rays(scene);
        FrameStats stats;
        methods::FrameContext context{
            scene, rays, test::validated_device(), stats, {{0, Event::transmission}, {0, Event::reflection}}};
        methods::SlicedBeams method(GetParam());
        method.begin(context);
        std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
        method.in_scatter(context, layer, radiance);
        EXPECT_EQ(stats.counted("segments walked on the device") > 0, GetParam() == CoverageBackend::compute);
        return radiance;
    };
    const std::vector<glm::vec3> coloured = scattered(kExtinction);
    const std::vector<glm::vec3> grey[3] = {scattered(glm::dvec3(kExtinction.r)),
                                            scattered(glm::dvec3(kExtinction.g)),
                                            scattered(glm::dvec3(kExtinction.b))};
    for (const bool in_water : {true, false}) {
        const auto part = [&](const std::vector<glm::vec3>& all) {
            std::vector<glm::vec3> some;
            for (std::size_t i = 0; i < all.size(); ++i)
                if ((layer.in_water[i] != 0) == in_water) some.push_back(all[i]);
            return some;
        };
        // Rules of quadrature of the water differ (moments of a cluster, or beam by beam), by 1e-6. Light's
        // columns through the smoke are as fine as the densest channel needs, to 5e-3 of optical depth.
        EXPECT_LE(difference(part(coloured), [&](int channel) { return part(grey[channel]); }),
                  in_water ? 5e-6 : 5e-3)
            << in_water;
    }
}
INSTANTIATE_TEST_SUITE_P(Devices, TintedScatter,
                         testing::Values(CoverageBackend::cpu, CoverageBackend::compute));

}  // namespace
}  // namespace dapple
