#include "judge/compare_look.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

#include "base/error.h"
#include "image/code_values.h"
#include "report/heat_map.h"

namespace dapple::judge {
namespace {

color::Grader make_grader(const color::ViewSettings& view) {
    try {
        return color::Grader(view);
    } catch (const Error& error) {
        // Here display, view and look come from the command line, not from a timeline.
        if (error.code() == ExitCode::timeline_invalid) throw Error(ExitCode::usage, error.what());
        throw;
    }
}

metrics::Picture rows_of(const metrics::Picture& picture, int first, int count) {
    metrics::Picture rows;
    rows.width = picture.width;
    rows.height = count;
    const auto begin = static_cast<std::ptrdiff_t>(first) * picture.width;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto from = picture.rgb[c].begin() + begin;
        rows.rgb[c].assign(from, from + static_cast<std::ptrdiff_t>(count) * picture.width);
    }
    return rows;
}

image::Image image_of(metrics::Picture picture) {
    image::Image image;
    image.width = picture.width;
    image.height = picture.height;
    const char* const names[] = {"R", "G", "B"};
    for (std::size_t c = 0; c < 3; ++c) {
        image.channels.push_back({names[c], image::PixelType::float32, std::move(picture.rgb[c])});
    }
    return image;
}

}  // namespace

Look::Look(const color::ViewSettings& view, double exposure, bool displayed)
    : grader_(make_grader(view)), displayed_(displayed) {
    grade_.exposure = exposure;
    grader_.prepare(grade_);
}

image::Image Look::graded(const ReadFrame& frame, int first, int count) const {
    assert(frame.picture && first >= 0 && first + count <= frame.picture->height);
    metrics::Picture picture = rows_of(*frame.picture, first, count);
    if (frame.display_referred) return image_of(std::move(picture));
    if (const auto working = grader_.working_chromaticities()) {
        metrics::change_primaries(picture, frame.chromaticities.value_or(metrics::kRec709), *working);
    }
    return grader_.apply(image_of(std::move(picture)), grade_).picture;
}

std::vector<std::uint8_t> Look::rows(const ReadFrame& frame, int first, int count) const {
    return image::to_rgb8(graded(frame, first, count));
}

metrics::Picture Look::light(const ReadFrame& frame) const {
    assert(frame.picture);
    metrics::Picture light;
    light.width = frame.picture->width;
    light.height = frame.picture->height;
    light.excluded = frame.picture->excluded;
    light.luminance = frame.picture->luminance;
    if (!displayed_ || frame.display_referred) return light;
    const image::Image picture = graded(frame, 0, light.height);
    const std::vector<float>*red = &picture.find("R")->values, *green = &picture.find("G")->values,
          *blue = &picture.find("B")->values;
    for (std::size_t i = 0; i < light.luminance.size(); ++i) {
        light.luminance[i] = 0.2126f * (*red)[i] + 0.7152f * (*green)[i] + 0.0722f * (*blue)[i];
    }
    for (const std::uint32_t pixel : light.excluded) light.luminance[pixel] = 0;
    return light;
}

ComparedPicture Look::show(const ReadFrame& frame) const {
    ComparedPicture shown;
    if (!frame.picture) {
        shown.blank =
            "frame " + std::to_string(frame.frame) + (frame.missing ? " is missing" : " is unreadable");
        return shown;
    }
    shown.rgb = rows(frame, 0, frame.picture->height);
    shown.light = light(frame);
    return shown;
}

std::string Look::description() const {
    const color::ViewDescription& view = grader_.description();
    std::string text = view.display + ", " + view.view;
    if (!view.look.empty()) text += ", " + view.look;
    if (grade_.exposure != 0) text += ", exposure " + report::short_number(grade_.exposure);
    return text;
}

}  // namespace dapple::judge
