// E of sliced_beams as a picture against stored references, whose own noise stands in their files
// (tools/make_references makes them).
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "accuracy/scenes.h"
#include "gpu/validated_device.h"
#include "image/exr.h"
#include "methods/sliced_beams/sliced_beams.h"
#include "source_dir.h"

namespace dapple {
namespace {

using test::Distance;
using test::Picture;

struct Reference {
    int side = 0;
    std::vector<float> irradiance;  ///< W/m^2 for a sun of irradiance 1
    double noise = 0;               ///< relative, L1
};
Reference stored(const std::string& name) {
    const image::Image file = image::read_exr(DAPPLE_SOURCE_DIR "/tests/accuracy/data/" + name + ".exr");
    Reference reference{file.width, file.find("E")->values};
    for (const auto& [key, value] : file.metadata)
        if (key == "noise") reference.noise = std::stod(value);
    return reference;
}

Picture take_beams(const scene::FrameState& state) {
    methods::SlicedBeams method;
    return test::take_picture(state, method, test::validated_device());
}

Distance compare(const Picture& picture, const Reference& reference) {
    EXPECT_EQ(picture.layer.width, reference.side);
    return test::distance(
        reference.irradiance.size(), [&](std::size_t i) { return picture.result.irradiance[i].g; },
        [&](std::size_t i) { return reference.irradiance[i]; });
}

TEST(Irradiance, OfALevelFloorConvergesWithOrderTwo) {
    const Reference reference = stored("floor");
    // A third of the smallest figure below.
    ASSERT_GT(reference.noise, 0);
    ASSERT_LE(reference.noise, 0.001 / 3);
    std::vector<double> errors;
    for (const int cells : {16, 32, 64, 128, 256}) {
        const Distance d = compare(take_beams(test::level_floor(cells)), reference);
        printf("%3d cells per shortest wave: L1 %.3e%s, rms %.2e, bias %+.1e (reference's noise %.0e)\n",
               cells, d.l1,
               errors.empty() ? ""
                              : (" (order " + std::to_string(std::log2(errors.back() / d.l1)) + ")").c_str(),
               d.rms, d.bias, reference.noise);
        if (cells >= 64) {
            EXPECT_LE(std::abs(d.bias), 1e-4) << cells;
        }
        if (cells == 64) {
            EXPECT_LE(d.l1, 0.01);
        }
        if (cells == 256) {
            EXPECT_LE(d.l1, 0.001);
        }
        errors.push_back(d.l1);
    }
    // Over the last two halvings of the cell, on which the two figures stand.
    EXPECT_GE(std::log2(errors[2] / errors[4]) / 2, 1.9);
}

class PerspectivePicture : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Floors, PerspectivePicture, testing::Values("sloped_floor", "curved_floor"),
                         [](const auto& floor) { return std::string(floor.param); });

TEST_P(PerspectivePicture, FromTheAirIsRight) {
    const std::string name = GetParam();
    const Reference reference = stored(name);
    ASSERT_GT(reference.noise, 0);
    ASSERT_LE(reference.noise, 0.02 / 3);
    const Picture picture =
        take_beams(name == "sloped_floor" ? test::sloped_floor(64) : test::curved_floor(64));
    EXPECT_TRUE(std::ranges::all_of(picture.result.covered, [](auto covered) { return covered == 1; }));
    const Distance d = compare(picture, reference);
    printf("%s: L1 %.4f, rms %.4f, bias %+.1e (reference's noise %.4f)\n", name.c_str(), d.l1, d.rms, d.bias,
           reference.noise);
    EXPECT_LE(d.l1, 0.02);
}

TEST(ColumnInThePool, CastsItsShadow) {
    const Reference reference = stored("column");
    ASSERT_GT(reference.noise, 0);
    ASSERT_LE(reference.noise, 0.02 / 3);
    const Picture picture = take_beams(test::column_in_pool(64));
    const Distance d = compare(picture, reference);
    // Without the pixels at the column's edges, whose E here is that of the object in the middle, in the
    // reference the mean of both.
    double error = 0, sum = 0;
    // The umbra: nothing arrived in the reference, nor in the pixels around.
    int umbra = 0, floor_umbra = 0, lit = 0;
    const int side = reference.side;
    for (int y = 1; y + 1 < side; ++y) {
        for (int x = 1; x + 1 < side; ++x) {
            float most = 0;
            bool one_object = true;
            const auto i = static_cast<std::size_t>(y * side + x);
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const auto beside = static_cast<std::size_t>((y + dy) * side + x + dx);
                    most = std::max(most, reference.irradiance[beside]);
                    one_object &= picture.layer.object[beside] == picture.layer.object[i];
                }
            }
            if (one_object) {
                error +=
                    static_cast<double>(std::abs(picture.result.irradiance[i].g - reference.irradiance[i]));
                sum += static_cast<double>(reference.irradiance[i]);
            }
            if (most > 0) continue;
            ++umbra;
            if (picture.layer.object[i] == 0) ++floor_umbra;
            if (picture.result.irradiance[i].g != 0) ++lit;
        }
    }
    printf(
        "column: L1 %.4f (%.4f without the pixels at its edges), rms %.4f, bias %+.1e (reference's noise "
        "%.4f); of %d pixels in the umbra (%d on "
        "the floor) %d have light\n",
        d.l1, error / sum, d.rms, d.bias, reference.noise, umbra, floor_umbra, lit);
    EXPECT_GT(floor_umbra, 20);
    EXPECT_EQ(lit, 0);
    EXPECT_LE(d.l1, 0.02);
}

}  // namespace
}  // namespace dapple
