#pragma once
#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "image/code_values.h"
#include "image/png.h"
#include "metrics/picture.h"
#include "run/child_process.h"
#include "run/scratch_folder.h"

namespace dapple::metrics::testing_pictures {

/// What ffmpeg's psnr and ssim filters say of two 8-bit pictures: their averages over R, G and B, to six
/// decimals. Its plain code is asked: the vector code of ffmpeg 5.1 errs where a row has 4 n + 1 windows.
struct FfmpegFigures {
    double psnr = 0;
    double ssim = 0;
};

inline void write_picture(const Picture& picture, const std::string& path) {
    image::Image image;
    image.width = picture.width;
    image.height = picture.height;
    const char* const names[3] = {"R", "G", "B"};
    for (std::size_t c = 0; c < 3; ++c) image.add(names[c]).values = picture.rgb[c];
    image::write_png(path, picture.width, picture.height, image::to_rgb8(image));
}

inline double number_after(const std::string& text, const std::string& pattern) {
    std::smatch match;
    if (!std::regex_search(text, match, std::regex(pattern + R"((-?[0-9.]+))"))) {
        ADD_FAILURE() << "ffmpeg said: " << text;
        return 0;
    }
    return std::stod(match[1]);
}

inline FfmpegFigures ffmpeg_figures(const Picture& picture, const Picture& reference) {
    const testing_tools::ScratchFolder folder;
    write_picture(picture, folder / "picture.png");
    write_picture(reference, folder / "reference.png");
    const testing_tools::Outcome outcome = testing_tools::run_program(
        {"ffmpeg", "-nostdin", "-hide_banner", "-cpuflags", "0", "-i", folder / "picture.png", "-i",
         folder / "reference.png", "-lavfi",
         "[0]format=gbrp,split[a][b];[1]format=gbrp,split[c][d];[a][c]psnr;[b][d]ssim", "-f", "null", "-"},
        folder / "output.txt");
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    return {number_after(outcome.output, "PSNR .*average:"), number_after(outcome.output, "SSIM .*All:")};
}

}  // namespace dapple::metrics::testing_pictures
