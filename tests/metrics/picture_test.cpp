#include "metrics/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "base/error.h"

namespace dapple::metrics {
namespace {

image::Image two_pixels(std::array<float, 2> red, std::array<float, 2> green, std::array<float, 2> blue) {
    image::Image image;
    image.width = 2;
    image.height = 1;
    image.add("R").values = {red[0], red[1]};
    image.add("G").values = {green[0], green[1]};
    image.add("B").values = {blue[0], blue[1]};
    return image;
}

TEST(Picture, LuminanceIsThatOfThePrimaries) {
    image::Image image = two_pixels({1, 0}, {0, 1}, {0, 0});
    // ITU-R BT.709, item 3.2; to its four printed digits.
    const Picture rec709 = picture_of(image, "", "a.exr");
    EXPECT_NEAR(rec709.luminance[0], 0.2126, 5e-5);
    EXPECT_NEAR(rec709.luminance[1], 0.7152, 5e-5);
    // S-2014-004: luminance of ACEScg, printed 0.2722287168, 0.6740817658; in float.
    image.chromaticities = image::kAcesCgChromaticities;
    const Picture aces = picture_of(image, "", "a.exr");
    EXPECT_NEAR(aces.luminance[0], 0.2722287, 1e-6);
    EXPECT_NEAR(aces.luminance[1], 0.6740818, 1e-6);
}

TEST(Picture, WhiteStaysWhiteInRec709) {
    image::Image image = two_pixels({1, 1}, {1, 0}, {1, 0});
    image.chromaticities = image::kAcesCgChromaticities;
    Picture picture = picture_of(image, "", "a.exr");
    to_rec709(picture, image);
    for (const std::vector<float>& plane : picture.rgb) EXPECT_NEAR(plane[0], 1, 2e-6);
    // AP1's red lies outside Rec.709: 1.705, -0.130, -0.024 by the matrix that ACES prints (Bradford too).
    EXPECT_NEAR(picture.rgb[0][1], 1.7050, 1e-3);
    EXPECT_NEAR(picture.rgb[1][1], -0.1302, 1e-3);
    EXPECT_NEAR(picture.rgb[2][1], -0.0240, 1e-3);
}

TEST(Picture, LeavesOutWhatIsNotFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    Picture a = picture_of(two_pixels({nan, 1}, {2, 2}, {3, 3}), "", "a.exr");
    EXPECT_THAT(a.excluded, testing::ElementsAre(0));
    EXPECT_EQ(a.counted(), 1u);
    EXPECT_EQ(a.rgb[1][0], 0);
    Picture b = picture_of(two_pixels({1, 1}, {1, inf}, {1, 1}), "", "b.exr");
    exclude_together(a, b);
    EXPECT_THAT(a.excluded, testing::ElementsAre(0, 1));
    EXPECT_EQ(a.excluded, b.excluded);
    EXPECT_EQ(a.rgb[0][1], 0);
    EXPECT_EQ(b.luminance[0], 0);
}

TEST(Picture, NamesTheLayersThereAre) {
    image::Image image = two_pixels({1, 2}, {1, 2}, {1, 2});
    image.add("E.R");
    image.add("Z").values = {5, 6};
    EXPECT_EQ(picture_of(image, "Z", "a.exr").luminance[1], 6);
    try {
        picture_of(image, "caustics", "a.exr");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        EXPECT_THAT(error.what(), testing::HasSubstr("no layer 'caustics'; there are B, E, G, R, Z"));
    }
}

}  // namespace
}  // namespace dapple::metrics
