// Settings that are chosen for a target error, and the errors that are told of them, against a closed form
// (closed_form/sinusoid.h) and sliced_beams. DAPPLE_LONG: also those that render for minutes.
#include "render/settle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "closed_form/sinusoid.h"
#include "gpu/validated_device.h"
#include "render/frame_renderer.h"

namespace dapple::render {
namespace {

constexpr int kPixels = 200;
/// An estimate may be off by this factor: three maps tell an error to 1.3 (error_estimate.h), and the parts
/// by mesh and pixels add up as squares whatever they have in common.
constexpr double kFactor = 1.5;

scene::FrameState pool(double depth, double target, const char* method = "photon_splatting") {
    scene::FrameState state = test::sinusoid_pool(depth * test::kSinusoidFocus, kPixels, 16);
    state.water->mesh_cells = 600;  // 100 a wave: 0.03 %
    state.caustics.method = method;
    state.caustics.target_error = target;
    return state;
}

SettledCaustics settled(const scene::FrameState& state) {
    SettleRequest request;
    request.pilots = {state};
    request.choose_footprint = state.caustics.method == "photon_splatting";
    request.choose_passes = true;
    return FrameRenderer(test::validated_device()).settle(request);
}

std::vector<float> irradiance(const scene::FrameState& state) {
    FrameStats stats;
    return FrameRenderer(test::validated_device()).render(state, stats).linear.find("E.R")->values;
}

double true_error(scene::FrameState state, const SettledCaustics& found, double depth) {
    apply(found, state.caustics);
    return test::sinusoid_error(irradiance(state), depth * test::kSinusoidFocus, kPixels);
}

void expect_told_truly(double told, double measured, const std::string& what) {
    EXPECT_LT(told, kFactor * measured) << what;
    EXPECT_GT(told, measured / kFactor) << what;
}

#if DAPPLE_LONG
TEST(Settle, ReachesTargetsWithTheErrorThatItTells) {
    for (const auto& [method, depth] :
         {std::pair("photon_splatting", 0.5), {"photon_splatting", 2.0}, {"caustic_mesh", 2.0}}) {
        int coarser = 0;
        for (const double target : {0.1, 0.03, 0.01}) {
            const scene::FrameState state = pool(depth, target, method);
            const SettledCaustics found = settled(state);
            const double measured = true_error(state, found, depth);
            const std::string what = std::string(method) + ": " + plan_line(found, state.caustics).reason;
            printf("%s: true %.4f\n", what.c_str(), measured);
            EXPECT_TRUE(found.reached()) << what;
            EXPECT_GE(found.map_resolution, coarser) << what;
            coarser = found.map_resolution;
            expect_told_truly(found.error(), measured, what);
        }
    }
}

#endif

TEST(Settle, KnowsWhatTheMeshOfTheWaterMakes) {
    scene::FrameState state = pool(0.5, 0.005, "caustic_mesh");
    state.water->mesh_cells = 60;  // ten a wave
    const SettledCaustics found = settled(state);
    EXPECT_FALSE(found.reached());
    const PlanLine line = plan_line(found, state.caustics);
    EXPECT_EQ(line.decision, "partly");
    EXPECT_NE(line.reason.find("a finer mesh of the water would"), std::string::npos) << line.reason;
    expect_told_truly(found.error(), true_error(state, found, 0.5), line.reason);
    EXPECT_GT(found.pilots[0].by_mesh, 0.8 * found.error());
}

#if DAPPLE_LONG
/// Splats hold the box of a sample's cell along the vectors of their lattice: oblique to the picture they
/// blur, the less the more samples a pixel has.
TEST(Settle, KnowsHowPixelsWidenSplats) {
    for (const int samples : {1, 4, 16}) {
        scene::FrameState state = pool(2, 0.01);
        state.camera.up = {std::sin(0.6), 0, -std::cos(0.6)};
        state.clip.width = 100;
        state.clip.height = 40;
        state.camera.view_height = 0.2;  // all of it within the patch
        state.water->extent.size.y = 1;
        state.clip.samples = samples;
        const SettledCaustics found = settled(state);
        scene::FrameState exact = state;
        exact.caustics.method = "sliced_beams";
        const std::vector<float> truth = irradiance(exact);
        apply(found, state.caustics);
        const std::vector<float> splats = irradiance(state);
        double apart = 0, sum = 0;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            apart += std::abs(static_cast<double>(splats[i] - truth[i]));
            sum += static_cast<double>(truth[i]);
        }
        const std::string reason = plan_line(found, state.caustics).reason;
        printf("%d samples: %s: true %.4f\n", samples, reason.c_str(), apart / sum);
        expect_told_truly(found.error(), apart / sum, reason);
        EXPECT_GT(found.pilots[0].by_pixels, 0) << reason;
    }
}

#endif

TEST(Settle, ChoosesPassesOfAFilterThatIsAskedFor) {
    scene::FrameState state = pool(2, 0.2);
    state.caustics.denoise.filter = scene::DenoiseFilter::fixed;
    state.caustics.denoise.radius = 1;
    const SettledCaustics found = settled(state);
    const std::string reason = plan_line(found, state.caustics).reason;
    printf("%s: true %.4f\n", reason.c_str(), true_error(state, found, 2));
    EXPECT_NE(reason.find("denoise.passes " + std::to_string(found.denoise_passes)), std::string::npos);
    expect_told_truly(found.error(), true_error(state, found, 2), reason);
    state.caustics.target_error = 0.01;  // the filter blurs by more
    const SettledCaustics missed = settled(state);
    EXPECT_FALSE(missed.reached());
}

TEST(Settle, FindsTheSameAgain) {
    const scene::FrameState state = pool(2, 0.03);
    const SettledCaustics first = settled(state), second = settled(state);
    EXPECT_EQ(first.map_resolution, second.map_resolution);
    EXPECT_EQ(first.footprint, second.footprint);
    EXPECT_EQ(first.error(), second.error());
}

TEST(Settle, TakesTheWorstOfThePilots) {
    SettleRequest request;
    request.pilots = {pool(0.5, 0.03), pool(2, 0.03)};
    const SettledCaustics both = FrameRenderer(test::validated_device()).settle(request);
    request.pilots = {pool(0.5, 0.03)};
    const SettledCaustics easy = FrameRenderer(test::validated_device()).settle(request);
    EXPECT_EQ(both.pilots.size(), 2U);
    EXPECT_GT(both.map_resolution, easy.map_resolution);
    EXPECT_LT(both.pilots[0].error, both.pilots[1].error);
}

TEST(Settle, WithoutCausticsInViewKeepsTheDefault) {
    scene::FrameState state = pool(0.5, 0.03);
    state.objects.clear();
    const SettledCaustics found = settled(state);
    EXPECT_EQ(found.map_resolution, scene::CausticMapParameters().map_resolution);
    EXPECT_EQ(found.error(), 0);
}

TEST(Settle, StopsAndKeepsToItsMemory) {
    SettleRequest request;
    request.pilots = {pool(0.5, 0.001)};
    request.most_memory = 10 << 20;
    try {
        FrameRenderer(test::validated_device()).settle(request);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::out_of_memory_budget);
        EXPECT_NE(std::string(error.what()).find("map_resolution of 64"), std::string::npos) << error.what();
    }
    request.most_memory = UINT64_MAX;
    int asked = 0;
    request.stop = [&] { return ++asked == 3; };
    try {
        FrameRenderer(test::validated_device()).settle(request);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::interrupted);
    }
}

TEST(PilotFrames, AreTheFirstTheMiddleAndTheLast) {
    scene::Clip clip;
    clip.first_frame = 11;
    clip.last_frame = 20;
    EXPECT_EQ(pilot_frames(clip), (std::vector<std::int64_t>{11, 15, 20}));
    clip.last_frame = 12;
    EXPECT_EQ(pilot_frames(clip), (std::vector<std::int64_t>{11, 12}));
    clip.last_frame = 11;
    EXPECT_EQ(pilot_frames(clip), (std::vector<std::int64_t>{11}));
}

}  // namespace
}  // namespace dapple::render
