#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "image/exr.h"
#include "judge/compare_layout.h"
#include "judge/compare_look.h"
#include "judge/compare_plan.h"
#include "judge/compare_survey.h"
#include "judge/sequence_reader.h"
#include "run/scratch_folder.h"

namespace dapple::judge {

/// R, G, B of a pixel of a frame.
using Paint = std::function<glm::vec3(int x, int y, int frame)>;

inline void write_picture(const std::string& path, int width, int height, int frame, const Paint& paint) {
    image::Image picture;
    picture.width = width;
    picture.height = height;
    for (const char* name : {"R", "G", "B"}) picture.add(name);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const glm::vec3 rgb = paint(x, y, frame);
            for (int c = 0; c < 3; ++c) {
                picture.channels[static_cast<std::size_t>(c)]
                    .values[static_cast<std::size_t>(y * width + x)] = rgb[c];
            }
        }
    }
    image::write_exr_verified(path, picture, {.chromaticities = image::kAcesCgChromaticities});
}

/// Writes NAME.%04d.exr of ACEScg pictures and returns the pattern.
inline std::string write_clip(const testing_tools::ScratchFolder& folder, const std::string& name, int width,
                              int height, const std::vector<int>& frames, const Paint& paint) {
    for (const int frame : frames) {
        const std::string digits = std::to_string(10000 + frame).substr(1);
        write_picture(folder / (name + "." + digits + ".exr"), width, height, frame, paint);
    }
    return folder / (name + ".%04d.exr");
}

/// A picture with another colour in each pixel and frame.
inline glm::vec3 busy(int x, int y, int frame) {
    const auto wave = [&](double a, double b, double c) {
        return static_cast<float>(0.4 + 0.35 * std::sin(a * x + b * y + c * frame));
    };
    return {wave(0.31, 0.17, 0.5), wave(0.11, -0.23, 0.9), wave(-0.07, 0.29, 1.3)};
}

inline CompareListener silent() {
    return {[](const std::string&) {}, [](const std::string&, std::size_t, std::size_t) {},
            [] { return false; }};
}

/// All that a composer needs, of sequences on disk.
struct Prepared {
    Prepared(const CompareOptions& options)
        : comparison(plan_comparison(options)),
          look(options.view, options.exposure, comparison.displayed),
          found(*survey(comparison, look, options.difference_scale, silent())),
          layout(plan_layout(comparison.width, comparison.height, comparison.sequences.size(),
                             comparison.frames.size(), options.parts)) {}

    std::vector<ComparedPicture> pictures(std::size_t index) const {
        ReadOptions read;
        read.frames = {comparison.frames[index]};
        SequenceReader reader(comparison.sequences, read);
        std::vector<ComparedPicture> shown;
        for (const ReadFrame& frame : reader.next()) shown.push_back(look.show(frame));
        return shown;
    }

    Comparison comparison;
    Look look;
    Survey found;
    Layout layout;
};

}  // namespace dapple::judge
