// Quads and discs over flat water, level and leaning: methods that take them by their points against the sum
// over these and the integral over the emitter. area_light_test.cpp has photon splatting and the reference.
#include <gtest/gtest.h>

#include <functional>
#include <memory>

#include "methods/adaptive_beams/adaptive_beams.h"
#include "methods/caustic_mesh/caustic_mesh.h"
#include "methods/panel_over_water.h"
#include "methods/sliced_beams/sliced_beams.h"

namespace dapple {
namespace {

constexpr int kPixels = 12;
constexpr double kView = 2.4;  // m

struct Subject {
    const char* name;
    std::function<std::unique_ptr<methods::CausticMethod>()> make;
    int samples;   ///< of the emitters
    double error;  ///< of a pixel, relative, against the sum over these points
};

std::vector<double> red_of(test::Frame frame, const Subject& subject) {
    frame.rays.emplace(frame.scene);
    view::LayerCounts counts;
    const view::ReceiverLayer layer = view::trace_layer(frame.scene, *frame.rays, {}, counts);
    methods::FrameContext context{frame.scene, *frame.rays, test::validated_device(), frame.stats,
                                  frame.chains};
    const std::unique_ptr<methods::CausticMethod> method = subject.make();
    method->begin(context);
    methods::LayerResult result;
    result.irradiance.assign(layer.pixels(), glm::vec3(0));
    result.covered.assign(layer.pixels(), 0);
    method->irradiance(context, std::span(&layer, 1), std::span(&result, 1));
    std::vector<double> red;
    for (const glm::vec3& e : result.irradiance) red.push_back(static_cast<double>(e.x));
    return red;
}

double worst_pixel(const std::vector<double>& found, const std::vector<double>& expected) {
    double worst = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
        worst = std::max(worst, std::abs(found[i] / expected[i] - 1));
    return worst;
}

class Panels : public testing::TestWithParam<Subject> {
protected:
    /// `expected`: E by points of an emitter.
    template <class Expected>
    void hold(const std::vector<double>& found, const test::Panel& panel, const Expected& expected) {
        const Subject& subject = GetParam();
        const std::vector<double> by_parts = expected(panel.light, panel.parts());
        const std::vector<double> by_all = expected(panel.light, panel.points(10));
        const double error = worst_pixel(found, by_parts), whole = worst_pixel(found, by_all);
        printf("%s, %d points: worst pixel against their sum %.1e, against the emitter's integral %.1e\n",
               subject.name, subject.samples, error, whole);
        EXPECT_LT(error, subject.error);
        // The points are the middles of equal parts: their own error falls with the area of these.
        EXPECT_LT(whole, subject.error + 0.05 / subject.samples);
    }
};

TEST_P(Panels, OnAFloorBelowFlatWater) {
    for (const test::Panel& panel : test::panels_over_water(GetParam().samples)) {
        const scene::FrameState state = test::pool_under(panel.light, kView, kPixels);
        hold(red_of(test::panel_frame(state, light::Event::transmission), GetParam()), panel,
             [&](const scene::Light& emitter, const std::vector<test::EmitterPoint>& points) {
                 return test::below_flat_water(emitter, points, *state.water, 1, kView, kPixels);
             });
    }
}

TEST_P(Panels, OnACeilingAboveFlatWater) {
    for (const test::Panel& panel : test::panels_over_water(GetParam().samples)) {
        scene::FrameState state = test::pool_under(panel.light, kView, kPixels);
        state.objects = {test::level_plane("ceiling", 3, 100)};
        state.objects[0].transform.rotation = {glm::pi<double>(), 0, 0};
        state.camera.position = {0, 0.1, 0};
        state.camera.target = {0, 1, 0};
        hold(red_of(test::panel_frame(state, light::Event::reflection), GetParam()), panel,
             [&](const scene::Light& emitter, const std::vector<test::EmitterPoint>& points) {
                 std::vector<double> expected =
                     test::above_flat_water(emitter, points, *state.water, 3, kView, kPixels);
                 // Seen from below, x goes to the left.
                 for (auto row = expected.begin(); row != expected.end(); row += kPixels)
                     std::reverse(row, row + kPixels);
                 return expected;
             });
    }
}

template <class Method>
std::unique_ptr<methods::CausticMethod> made() {
    return std::make_unique<Method>();
}

// Errors are of second order in how wide beams are against their lamp's distance: sliced beams take 25 along
// the least distance, of which each brings one irradiance; the cells of the map are 6 cm; those of the coarse
// grid of adaptive beams 4 cm. By the 16 of their default they are off by 9 % (worst pixel of the quad that
// leans, which is 1.2 m above the water at its lower edge): a tolerance in place, not in brightness.
INSTANTIATE_TEST_SUITE_P(Methods, Panels,
                         testing::Values(Subject{"sliced_beams", made<methods::SlicedBeams>, 16, 4e-3},
                                         Subject{"adaptive_beams", made<methods::AdaptiveBeams>, 1, 5e-3},
                                         Subject{"caustic_mesh", made<methods::CausticMesh>, 16, 2e-3}),
                         [](const testing::TestParamInfo<Subject>& of) {
                             return std::string(of.param.name);
                         });

}  // namespace
}  // namespace dapple
