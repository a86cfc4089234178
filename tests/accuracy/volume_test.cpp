// S of sliced_beams as a picture against a stored reference, whose own noise stands in its file
// (tools/make_references makes it), and its smoothness from beam to beam.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "accuracy/scattered.h"
#include "gpu/validated_device.h"
#include "image/exr.h"
#include "methods/sliced_beams/sliced_beams.h"
#include "source_dir.h"

namespace dapple {
namespace {

std::vector<double> beams(const scene::FrameState& state) {
    methods::SlicedBeams method;
    return test::take_scattered(state, method, test::validated_device()).radiance;
}

TEST(Volume, OfAColumnInMurkyWaterIsRight) {
    const image::Image file = image::read_exr(DAPPLE_SOURCE_DIR "/tests/accuracy/data/murky_column.exr");
    const std::vector<float>& truth = file.find("S")->values;
    double noise = 0;
    for (const auto& [key, value] : file.metadata)
        if (key == "noise") noise = std::stod(value);
    ASSERT_EQ(file.width, test::kMurkySide);
    ASSERT_GT(noise, 0);
    ASSERT_LE(noise, 0.01 / 3);
    struct Setting {
        int cells, samples, directions;
    };
    // The last has the figure; those before it show what each number costs.
    for (const Setting& s : {Setting{8, 4, 4}, {16, 4, 4}, {16, 4, 1}, {16, 16, 1}, {16, 16, 4}}) {
        scene::FrameState state = test::murky_column(s.cells);
        state.clip.samples = s.samples;
        state.caustics.sliced_beams.volume_sun_samples = s.directions;
        const std::vector<double> values = beams(state);
        const test::Distance d = test::distance(
            truth.size(), [&](std::size_t i) { return values[i]; }, [&](std::size_t i) { return truth[i]; });
        printf(
            "%2d cells per shortest wave, %2d samples, %d directions: L1 %.4f, rms %.4f, bias %+.1e "
            "(reference's noise %.4f)\n",
            s.cells, s.samples, s.directions, d.l1, d.rms, d.bias, noise);
        if (s.cells == 16 && s.samples == 16 && s.directions == 4) {
            EXPECT_LE(d.l1, 0.01);
            // Pixels' errors go together, so that means are not much better known than pixels.
            EXPECT_LE(std::abs(d.bias), 0.004);
        }
    }
}

/// Largest second difference from pixel to pixel, relative to the value.
double roughness(const std::vector<double>& row) {
    double worst = 0;
    for (std::size_t i = 1; i + 1 < row.size(); ++i)
        worst = std::max(worst, std::abs(row[i - 1] - 2 * row[i] + row[i + 1]) / row[i]);
    return worst;
}

TEST(Volume, HasNoSeamsBetweenBeams) {
    scene::FrameState state;
    state.clip.width = 512;
    state.clip.height = 1;
    state.clip.samples = 1;
    state.water.emplace();
    state.water->extent.size = {8, 8};
    state.water->mesh_cells = 100;
    state.water->absorption = glm::dvec3(0.05);
    state.water->scattering = glm::dvec3(0.1);
    state.lights = {test::point_like_sun(60)};
    state.camera.position = {-0.5, -0.9, 0.3};
    state.camera.target = {0.6, -1.3, -0.5};
    state.camera.field_of_view = 0.12 * scene::kDegree;  // of the height, a 512th of the width
    state.objects.push_back(test::floor_plane({0, -test::kFloorDepth, 0}));
    // Beams of 8 cm are some 30 pixels wide.
    const double flat = roughness(beams(state));
    // A wave of 100 cells, without foci above the floor: within a beam's width S changes by little.
    scene::Water waved = test::sinusoids(2, 4, 6, 0.002);
    state.water->surface = waved.surface;
    const double waves = roughness(beams(state));
    printf("seams: second differences of %.1e of S below flat water, %.1e below waves\n", flat, waves);
    EXPECT_LE(flat, 0.002);
    EXPECT_GT(flat, 0);
    EXPECT_LE(waves, 0.002);
}

}  // namespace
}  // namespace dapple
