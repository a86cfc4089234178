// adaptive_beams beside sliced_beams, which follows every triangle of the water: distances over the levels of
// refinement.
#include <gtest/gtest.h>

#include "accuracy/scattered.h"
#include "gpu/validated_device.h"
#include "methods/adaptive_beams/adaptive_beams.h"
#include "methods/sliced_beams/sliced_beams.h"

namespace dapple {
namespace {

/// The column's pool in murky water by a sun without a disc, for both methods the same light.
scene::FrameState pool() {
    scene::FrameState state = test::murky_column(12);
    state.clip.samples = 4;
    state.lights[0].angular_diameter = 0;
    return state;
}

TEST(Adaptive, ComesNearerToSlicedBeamsWithEveryLevel) {
    const scene::FrameState state = pool();
    methods::SlicedBeams sliced;
    const std::vector<double> s = test::take_scattered(state, sliced, test::validated_device()).radiance;
    const test::Picture e = test::take_picture(state, sliced, test::validated_device());
    double s_before = 1e30, e_before = 1e30;
    for (const int levels : {0, 1, 2, 3, 4}) {
        scene::FrameState refined = state;
        refined.caustics.adaptive_beams.levels = levels;
        methods::AdaptiveBeams adaptive;
        const test::ScatteredPicture picture =
            test::take_scattered(refined, adaptive, test::validated_device());
        const test::Distance of_s = test::distance(
            s.size(), [&](std::size_t i) { return picture.radiance[i]; },
            [&](std::size_t i) { return s[i]; });
        const test::Picture floor = test::take_picture(refined, adaptive, test::validated_device());
        const test::Distance of_e = test::distance(
            floor.layer.pixels(), [&](std::size_t i) { return floor.result.irradiance[i].g; },
            [&](std::size_t i) { return floor.result.covered[i] ? e.result.irradiance[i].g : 0.0f; });
        printf("%d levels, %6.0f beams, %.2e fragments: S: L1 %.4f, bias %+.1e; E: L1 %.4f, bias %+.1e\n",
               levels, picture.stats.counted("beams drawn"), picture.stats.counted("beam fragments"), of_s.l1,
               of_s.bias, of_e.l1, of_e.bias);
        if (levels % 2 == 0) {
            EXPECT_LT(of_s.l1, s_before);
            EXPECT_LT(of_e.l1, e_before);
            s_before = of_s.l1;
            e_before = of_e.l1;
        }
    }
}

}  // namespace
}  // namespace dapple
