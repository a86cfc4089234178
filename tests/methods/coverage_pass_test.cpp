#include <gtest/gtest.h>

#include <algorithm>

#include "gpu/validated_device.h"
#include "methods/coverage_scene.h"

namespace dapple {
namespace {

using methods::CoverageBackend;
using methods::LayerResult;
using methods::SlicedBeams;

struct Rendered {
    std::vector<LayerResult> results;
    FrameStats stats;
};

Rendered run(test::CoverageFrame& frame, CoverageBackend backend) {
    Rendered r;
    SlicedBeams method(backend);
    r.results = frame.irradiance(method, r.stats);
    return r;
}

double mean(const std::vector<glm::vec3>& values) {
    double sum = 0;
    for (const glm::vec3& v : values) sum += static_cast<double>(v.x + v.y + v.z) / 3;
    return sum / static_cast<double>(values.size());
}

void expect_equal(const Rendered& cpu, const Rendered& device) {
    ASSERT_EQ(cpu.results.size(), device.results.size());
    const std::vector<glm::vec3>&a = cpu.results[0].irradiance, &b = device.results[0].irradiance;
    const double least = 1e-3 * mean(a);
    double largest = 0, largest_at_dark = 0;
    std::size_t compared = 0, beyond = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const double difference = std::abs(static_cast<double>(a[i][c]) - static_cast<double>(b[i][c]));
            if (static_cast<double>(a[i][c]) > least) {
                ++compared;
                const double relative = difference / static_cast<double>(a[i][c]);
                if (relative > 1e-5) ++beyond;
                largest = std::max(largest, relative);
            } else {
                largest_at_dark = std::max(largest_at_dark, difference);
            }
        }
    }
    std::printf("mean %g compared %zu beyond %zu largest %.3g dark %.3g on device %g clusters %g\n", mean(a),
                compared, beyond, largest, largest_at_dark,
                device.stats.counted("tiles covered on the device"),
                device.stats.counted("beam clusters found"));
    EXPECT_LE(largest, 1e-5);
}

TEST(CoveragePass, EqualsTheCpu) {
    for (const double disc : {0.0, 0.53}) {
        const scene::FrameScene scene = test::pool_scene(320, 180, 400, disc);
        test::CoverageFrame frame(test::validated_device(), scene);
        const Rendered cpu = run(frame, CoverageBackend::cpu), device = run(frame, CoverageBackend::compute);
        expect_equal(cpu, device);
    }
}

}  // namespace
}  // namespace dapple
