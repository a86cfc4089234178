#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "app/verbs.h"
#include "base/parallel.h"
#include "image/exr.h"
#include "judge/compare.h"
#include "run/interruption.h"

namespace dapple::app {
namespace {

struct Arguments {
    judge::CompareOptions options;
    std::string frames;
    std::string fps;
    std::string parts;
    std::string labels;
    double difference_scale = 0;
    int slice_row = 0;
    int threads = 0;
};

template <class Number>
std::optional<Number> number_in(std::string_view text) {
    Number number{};
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (fault != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// "24", "23.976" or "24000/1001".
scene::Rational rate_of(const std::string& text) {
    constexpr double kLeast = 0.01, kMost = 1000;
    scene::Rational rate{0, 1};
    if (const std::size_t slash = text.find('/'); slash != std::string::npos) {
        const auto numerator = number_in<std::int32_t>(std::string_view(text).substr(0, slash));
        const auto denominator = number_in<std::int32_t>(std::string_view(text).substr(slash + 1));
        if (numerator && denominator && *denominator > 0) rate = {*numerator, *denominator};
    } else if (const auto fps = number_in<double>(text); fps && *fps >= kLeast && *fps <= kMost) {
        rate = judge::exact_rate(*fps);
    }
    if (!(rate.value() >= kLeast && rate.value() <= kMost)) {
        throw Error(ExitCode::usage,
                    "--fps is 0.01 to 1000 frames a second, as in 24, 23.976 or 24000/1001, not '" +
                        clipped(text) + "'");
    }
    return rate;
}

std::vector<std::string> items_of(const std::string& list) {
    std::vector<std::string> items;
    std::istringstream stream(list);
    for (std::string item; std::getline(stream, item, ',');) items.push_back(item);
    return items;
}

judge::CompareParts parts_of(const std::string& list) {
    judge::CompareParts parts{false, false, false, false, false};
    const std::pair<const char*, bool*> names[] = {{"side", &parts.side},
                                                   {"wipe", &parts.wipe},
                                                   {"difference", &parts.difference},
                                                   {"slice", &parts.slice},
                                                   {"flicker", &parts.flicker}};
    for (const std::string& item : items_of(list)) {
        bool known = false;
        for (const auto& [name, wanted] : names) {
            if (item == name) *wanted = known = true;
        }
        if (!known) {
            throw Error(ExitCode::usage, "--parts takes side, wipe, difference, slice and flicker, not '" +
                                             clipped(item) + "'");
        }
    }
    return parts;
}

/// At most a line a second, so that logs stay readable.
class Progress {
public:
    void operator()(const std::string& stage, std::size_t done, std::size_t total) {
        const auto now = std::chrono::steady_clock::now();
        if (now - last_ < std::chrono::seconds(1)) return;
        last_ = now;
        std::printf("%s: %zu of %zu frames\n", stage.c_str(), done, total);
        std::fflush(stdout);
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

ExitCode compare(const Arguments& arguments) {
    const run::Interruption interruption;
    set_thread_count(arguments.threads);
    image::set_exr_threads(thread_count());
    Progress progress;
    const judge::CompareListener listener{
        .note =
            [](const std::string& line) {
                std::printf("%s\n", line.c_str());
                std::fflush(stdout);
            },
        .progress = [&progress](const std::string& stage, std::size_t done,
                                std::size_t total) { progress(stage, done, total); },
        .stop = [&interruption] { return interruption.requested(); }};
    if (judge::compare(arguments.options, listener) == judge::CompareEnd::stopped) {
        throw Error(ExitCode::interrupted, "interrupted: nothing was written");
    }
    return ExitCode::done;
}

}  // namespace

void add_compare_verb(CLI::App& app, Run& run) {
    const auto arguments = std::make_shared<Arguments>();
    judge::CompareOptions& options = arguments->options;
    CLI::App* verb =
        app.add_subcommand("compare", "Show sequences beside one another, as a video and a sheet");
    verb->add_option(
            "sequences", options.sequences,
            "Two to four: a pattern (clip.%04d.exr, clip.####.exr), a folder, a manifest.json, a picture")
        ->required()
        ->expected(2, 4);
    verb->add_option("-o,--output", options.video, "Video to write (MP4)");
    verb->add_option("--sheet", options.sheet, "Contact sheet to write (PNG)");
    verb->add_option("--sheet-frames", options.sheet_frames, "Frames on the sheet, at most (default 6)")
        ->check(CLI::Range(1, 64));
    CLI::Option* frames = verb->add_option("-f,--frames", arguments->frames,
                                           "Frames, as in 1-10, 1-10x3; default: those of all clips");
    CLI::Option* labels = verb->add_option("--labels", arguments->labels,
                                           "Names to show, as in before,after; default: the sequences'");
    CLI::Option* parts = verb->add_option(
        "--parts", arguments->parts, "Parts of the video: side,wipe,difference,slice,flicker (default: all)");
    CLI::Option* fps =
        verb->add_option("--fps", arguments->fps,
                         "Frames a second, as in 24, 23.976, 24000/1001; default: of a manifest, else 24");
    CLI::Option* scale =
        verb->add_option(
                "--difference-scale", arguments->difference_scale,
                "What the heat maps show brightest: in means of A, or in code values where a sequence is "
                "display-referred; default: what 99.5 % of the clip's differences stay below, rounded up")
            ->check(CLI::PositiveNumber);
    CLI::Option* row = verb->add_option("--slice-row", arguments->slice_row,
                                        "Row of pixels to show over time, from the top; default: the middle");
    verb->add_option("--config", options.view.config, "OCIO config; default: $OCIO, else the one built in");
    verb->add_option("--display", options.view.display, "Display of the config");
    verb->add_option("--view", options.view.view, "View of the display");
    verb->add_option("--look", options.view.look, "Look, instead of the view's own");
    verb->add_option("--exposure", options.exposure, "Stops, for linear pictures")
        ->check(CLI::Range(-64.0, 64.0));
    verb->add_option("--threads", arguments->threads, "Threads; 0 (default): all that the process may use")
        ->check(CLI::Range(0, 1024));
    verb->footer(
        "Linear pictures are graded through OCIO; PNG and pictures that dapple has graded are shown as they "
        "are.\n"
        "Differences, means and flicker are of relative luminance, or of the graded luma where a sequence "
        "is\n"
        "display-referred. Missing and unreadable frames are drawn as blanks and listed at the end.\n"
        "Exit codes: 0 done, 2 wrong call, 4 unreadable input or different sizes, 5 unwritable output,\n"
        "75 interrupted.");
    verb->callback([arguments, frames, labels, parts, fps, scale, row, &run] {
        run = [=] {
            judge::CompareOptions& chosen = arguments->options;
            if (frames->count() > 0) chosen.frames = FrameSet::parse(arguments->frames);
            if (labels->count() > 0) chosen.labels = items_of(arguments->labels);
            if (parts->count() > 0) chosen.parts = parts_of(arguments->parts);
            if (fps->count() > 0) chosen.fps = rate_of(arguments->fps);
            if (scale->count() > 0) chosen.difference_scale = arguments->difference_scale;
            if (row->count() > 0) chosen.slice_row = arguments->slice_row;
            return compare(*arguments);
        };
    });
}

}  // namespace dapple::app
