// How the brute-force reference goes on, repeats its bits, and divides surfaces.
#include "methods/reference/reference.h"

#include <gtest/gtest.h>

#include <map>

#include "base/checked_file.h"
#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "image/temporary_folder.h"
#include "methods/reference/deposit_cells.h"
#include "methods/reference/progress_file.h"
#include "methods/reference/receiver_charts.h"
#include "methods/reference/sine_sum.h"
#include "methods/reference/true_surface.h"
#include "methods/reference_frame.h"
#include "scene/transform.h"

namespace dapple {
namespace {

using namespace test;

TEST(Reference, ResumesToTheSameBits) {
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.water->surface.waves.waves = {{0.5, 0.3, 0.01, 0}};
    state.lights = {test::sun_from_zenith(35)};
    state.caustics.reference = {0.05, 4};
    const LayerResult whole = Frame(state).render();

    const test::TemporaryFolder folder;
    Frame broken(state);
    broken.checkpoint.file = folder / "progress";
    int calls = 0, interruptions = 0;
    broken.checkpoint.stop = [&] { return ++calls % 6 == 0; };
    std::optional<LayerResult> resumed;
    while (!resumed && interruptions < 100) {
        try {
            resumed = broken.render();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::interrupted);
            ++interruptions;
        }
    }
    ASSERT_TRUE(resumed);
    EXPECT_GT(interruptions, 2);
    EXPECT_EQ(resumed->irradiance, whole.irradiance);
    EXPECT_EQ(resumed->data[0].values, whole.data[0].values);

    // A finished file gives the answer without a ray; another job does not take it.
    broken.stats = {};
    broken.checkpoint.stop = [] { return false; };
    EXPECT_EQ(broken.render().irradiance, whole.irradiance);
    EXPECT_EQ(broken.stats.counted("reference rays"), 0);
    broken.scene.state.clip.seed = 1;
    EXPECT_NE(broken.render().irradiance, whole.irradiance);
}

TEST(Reference, ForgetsDamagedProgress) {
    const test::TemporaryFolder folder;
    reference::Progress progress;
    progress[{reference::Quantity::irradiance, 0, 1}].start(64, 3);
    progress[{reference::Quantity::irradiance, 0, 1}].add_pass({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}});
    const std::string path = folder / "progress";
    reference::write_progress(path, "job", progress);
    ASSERT_EQ(reference::read_progress(path, "job").size(), 1u);
    EXPECT_EQ((reference::read_progress(path, "job")[{reference::Quantity::irradiance, 0, 1}].mean),
              (progress[{reference::Quantity::irradiance, 0, 1}].mean));
    EXPECT_TRUE(reference::read_progress(path, "another job").empty());
    EXPECT_TRUE(reference::read_progress(folder / "none", "job").empty());
    std::vector<std::byte> bytes = read_whole_file(path);
    bytes[bytes.size() / 2] ^= std::byte{1};
    write_file_atomically(path, bytes);
    EXPECT_TRUE(reference::read_progress(path, "job").empty());
    bytes.resize(10);
    write_file_atomically(path, bytes);
    EXPECT_TRUE(reference::read_progress(path, "job").empty());
}

TEST(Reference, SameBitsOnAnyNumberOfThreadsAndInAnyBatch) {
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.clip.samples = 2;
    state.water->surface.waves.waves = {{0.5, 0.3, 0.01, 0}};
    state.lights = {test::sun_from_zenith(35)};
    state.caustics.reference = kOneRound;
    set_thread_count(1);
    const LayerResult one = Frame(state).render();
    set_thread_count(2);
    EXPECT_EQ(Frame(state).render().irradiance, one.irradiance);
    set_thread_count(0);

    Frame frame(state);
    frame.rays.emplace(frame.scene);
    std::vector<view::ReceiverLayer> layers;
    for (const int sample : {1, 0}) {
        view::LayerCounts counts;
        layers.push_back(view::trace_layer(frame.scene, *frame.rays, {sample, 0}, counts));
    }
    methods::FrameContext context{frame.scene, *frame.rays,  test::validated_device(),
                                  frame.stats, frame.chains, {}};
    Reference method;
    method.begin(context);
    std::vector<LayerResult> results(2);
    method.irradiance(context, layers, results);
    EXPECT_EQ(results[1].irradiance, one.irradiance);
    EXPECT_TRUE(results[0].data.empty());
}

TEST(Reference, SumOfSinesIsThatOfTheSea) {
    scene::Water water;
    water.surface.waves.depth = 3;
    for (int i = 0; i < 24; ++i) {
        const double length = 0.15 * std::pow(8, i / 23.0);
        water.surface.waves.waves.push_back({length, 2.4 * i, 0.003 * length, 1.7 * i});
    }
    const ocean::WaterSurface sea(water);
    const reference::SineSum sum(water.surface.waves, 12.34);
    std::vector<double> x, z;
    for (int i = 0; i < 1000; ++i) {
        x.push_back(20 * hash_uniform(1, 0, static_cast<std::uint64_t>(i), 0) - 10);
        z.push_back(20 * hash_uniform(1, 0, static_cast<std::uint64_t>(i), 1) - 10);
    }
    std::vector<double> h(1000), sx(1000), sz(1000);
    sum.evaluate(x, z, h, sx, sz);
    for (std::size_t i = 0; i < 1000; ++i) {
        const ocean::SurfaceSample exact = sea.sample(x[i], z[i], 12.34);
        ASSERT_NEAR(h[i], exact.height, 1e-12);
        ASSERT_NEAR(sx[i], exact.slope.x, 1e-12);
        ASSERT_NEAR(sz[i], exact.slope.y, 1e-12);
    }
}

TEST(Reference, PatchesOfASeaAreNearlyExact) {
    // Over 6 by 4 m; and repeated so over 30 by 20 m, with rings, which leave none of its waves out.
    for (const double periods : {1.0, 5.0}) {
        scene::FrameState state = small_pool(1, 1, 1, 1);
        const glm::dvec2 size = periods * glm::dvec2(6, 4);
        state.water->extent.size = size;
        state.water->surface.type = scene::WaterSurfaceType::spectrum;
        state.water->surface.spectrum.cutoff_length = 0.5;
        if (periods > 1) {
            state.water->surface.spectrum.period = 5;
            state.water->rings.inner_size = 5;
        }
        state.time = 3;
        scene::FrameScene scene;
        scene.state = state;
        const reference::TrueSurface surface(scene);
        const ocean::WaterSurface sea(*state.water);
        double largest = 0, height_error = 0, largest_slope = 0, slope_error = 0;
        for (int i = 0; i < 300; ++i) {
            const double x = size.x * (hash_uniform(1, 0, static_cast<std::uint64_t>(i), 0) - 0.5);
            const double z = size.y * (hash_uniform(1, 0, static_cast<std::uint64_t>(i), 1) - 0.5);
            double h = 0, sx = 0, sz = 0;
            surface.evaluate({&x, 1}, {&z, 1}, {&h, 1}, {&sx, 1}, {&sz, 1});
            const ocean::SurfaceSample exact = sea.sample(x, z, 3);
            largest = std::max(largest, std::abs(exact.height));
            largest_slope = std::max(largest_slope, length(exact.slope));
            height_error = std::max(height_error, std::abs(h - exact.height));
            slope_error = std::max(slope_error, length(glm::dvec2(sx, sz) - exact.slope));
            EXPECT_LT(length(exact.slope), surface.steepest());
        }
        printf("height %.1e of %.1e, slope %.1e of %.1e\n", height_error, largest, slope_error,
               largest_slope);
        // 100 cells a shortest wave: (k cell)^4 / 384 = 4e-8 and (k cell)^3 / 125 = 2e-6 of its own share.
        EXPECT_LT(height_error, 1e-7 * largest);
        EXPECT_LT(slope_error, 2e-6 * largest_slope);
        EXPECT_GT(reference::surface_bytes(*state.water), 1200 * 800 * 4 * 8.0);
    }
}

TEST(Reference, ChartsOfSpheresHaveTheirAreas) {
    scene::FrameState state;
    scene::Object ball;
    ball.shape = scene::Shape::sphere;
    ball.radius = 0.5;
    ball.transform.position = {1, 2, 3};
    ball.transform.rotation = {0.3, 0.4, 0.5};
    for (const glm::dvec3 scale : {glm::dvec3(2), glm::dvec3(1, 0.3, 2)}) {
        ball.transform.scale = scale;
        scene::FrameScene scene;
        scene.state.objects = {ball};
        const reference::ReceiverCharts charts(scene);
        const glm::dmat4 world = scene::world_from_object(ball.transform);
        const auto point = [&](double longitude, double latitude) {
            const glm::dvec3 unit(std::cos(latitude) * std::cos(longitude), std::sin(latitude),
                                  std::cos(latitude) * std::sin(longitude));
            return glm::dvec3(world * glm::dvec4(0.5 * unit, 1));
        };
        // A fine grid of quadrangles: area over density gives the measure of each of 64 cells, on the
        // outside.
        std::map<std::uint64_t, double> measure;
        constexpr int across = 1024, up = 512;
        for (int i = 0; i < across; ++i) {
            for (int j = 0; j < up; ++j) {
                const double step = glm::pi<double>() / up;
                const double longitude = i * step, latitude = (j - 0.5 * up) * step;
                const glm::dvec3 a = point(longitude, latitude), b = point(longitude + step, latitude),
                                 c = point(longitude, latitude + step),
                                 d = point(longitude + step, latitude + step);
                const glm::dvec3 middle = point(longitude + 0.5 * step, latitude + 0.5 * step);
                const reference::ChartPlace place =
                    charts.place(0, 0, middle, middle - ball.transform.position);
                measure[place.key >> (2 * (charts.digits() - 3))] +=
                    0.5 * length(cross(d - a, c - b)) / place.density;
            }
        }
        ASSERT_EQ(measure.size(), 64u);
        // Rows of quadrangles straddle the edges between cells: up to 1 part in 200 of a cell near the poles.
        for (const auto& [cell, sum] : measure) EXPECT_NEAR(sum, 1.0 / 64, 0.01 / 64) << cell;
        // The inside is another chart.
        const glm::dvec3 some = point(0.2, 0.3);
        EXPECT_NE(charts.place(0, 0, some, some - ball.transform.position).key,
                  charts.place(0, 0, some, ball.transform.position - some).key);
    }
}

TEST(Reference, CellsFollowThePaths) {
    // 64 x 64 paths in the middle quarter of a chart, one a cell; and one far off.
    std::vector<reference::PathEnd> ends;
    const auto key = [](std::uint64_t x, std::uint64_t y, int level) {
        std::uint64_t digits = 0;
        for (int i = level - 1; i >= 0; --i) digits = digits << 2 | (x >> i & 1) | (y >> i & 1) << 1;
        return digits << (2 * (30 - level)) | std::uint64_t{1} << (2 * (29 - level));
    };
    for (std::uint32_t i = 0; i < 4096; ++i) ends.push_back({key(64 + i % 64, 64 + i / 64, 8), i});
    const reference::DepositCells cells(ends, 1, 30);
    for (std::uint32_t i = 0; i < 4096; ++i) {
        const auto cell = cells.find(key(64 + i % 64, 64 + i / 64, 8));
        ASSERT_EQ(cell.per_measure, std::pow(4.0, 8));
        ASSERT_EQ(std::vector(cell.pixels.begin(), cell.pixels.end()), std::vector{i});
    }
    EXPECT_TRUE(cells.find(key(63, 64, 8)).pixels.empty());
    EXPECT_TRUE(cells.find(key(200, 3, 8)).pixels.empty());
    // The order of the paths does not matter, and paths that end in one point share a cell.
    std::reverse(ends.begin(), ends.end());
    ends.push_back(ends.front());
    const auto shared = reference::DepositCells(ends, 1, 30).find(ends.front().key);
    EXPECT_EQ(shared.pixels.size(), 2u);
}

}  // namespace
}  // namespace dapple
