#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include "app/verbs.h"
#include "base/checked_file.h"
#include "base/parallel.h"
#include "image/exr.h"
#include "judge/check.h"
#include "judge/check_report.h"

namespace dapple::app {
namespace {

struct Arguments {
    judge::CheckOptions options;
    bool graded = false;
    std::string frames;
    std::string flip = "auto";
    std::string ssim = "gaussian";
    std::string exposures;
    double fps = 0;
    bool json = false;
    std::string html;
    int threads = 0;
};

/// Limits that nothing can exceed, such as NaN, would be no check.
CLI::Validator finite_number(double least) {
    const auto fault = [least](const std::string& text) -> std::string {
        double number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        const bool whole = error == std::errc{} && end == text.data() + text.size();
        if (whole && std::isfinite(number) && number >= least) return "";
        return "'" + clipped(text) + "' is no number of at least " + std::to_string(least);
    };
    return {fault, "NUMBER"};
}

CLI::Validator above_zero() {
    const auto fault = [](const std::string& text) -> std::string {
        double number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        const bool whole = error == std::errc{} && end == text.data() + text.size();
        if (whole && std::isfinite(number) && number > 0) return "";
        return "'" + clipped(text) + "' is no number above 0";
    };
    return {fault, "NUMBER > 0"};
}

metrics::Exposures exposures_of(const std::string& text) {
    metrics::Exposures exposures;
    std::istringstream stream(text);
    char comma = 0, other = 0;
    const bool read =
        static_cast<bool>(stream >> exposures.start >> comma >> exposures.stop >> other >> exposures.count);
    if (!read || comma != ',' || other != ',' || !(stream >> std::ws).eof() || exposures.count < 2 ||
        exposures.count > 100 || !std::isfinite(exposures.start) || !std::isfinite(exposures.stop)) {
        throw Error(ExitCode::usage,
                    "--exposures takes START,STOP,COUNT in stops, with a count of 2 to 100, "
                    "as in -10.5,2.5,13; not '" +
                        clipped(text) + "'");
    }
    return exposures;
}

ExitCode check(Arguments arguments) {
    judge::CheckOptions& options = arguments.options;
    if (arguments.graded) options.pictures = judge::Pictures::graded;
    if (!arguments.frames.empty()) options.frames = FrameSet::parse(arguments.frames);
    if (arguments.fps > 0) options.fps = arguments.fps;
    if (!arguments.exposures.empty()) options.exposures = exposures_of(arguments.exposures);
    options.flip = arguments.flip == "ldr"    ? judge::FlipKind::ldr
                   : arguments.flip == "hdr"  ? judge::FlipKind::hdr
                   : arguments.flip == "none" ? judge::FlipKind::none
                                              : judge::FlipKind::automatic;
    options.ssim = arguments.ssim == "boxes" ? metrics::SsimWindow::boxes : metrics::SsimWindow::gaussian;
    options.maps = !arguments.html.empty();
    set_thread_count(arguments.threads);
    image::set_exr_threads(1);  // so that decoding can be told from measuring; it overlaps with it

    const judge::CheckResult result = judge::check(options);
    if (!arguments.html.empty()) write_file_atomically(arguments.html, judge::check_html(result));
    const std::string output = arguments.json ? judge::check_json(result) : judge::check_text(result);
    std::fwrite(output.data(), 1, output.size(), stdout);
    if (result.findings.empty()) return ExitCode::done;
    const std::size_t count = result.findings.size();
    throw Error(ExitCode::check_failed, clipped(options.sequence + ": " + std::to_string(count) +
                                                (count == 1 ? " finding" : " findings, the first") + ": " +
                                                judge::line_of(result.findings.front())));
}

void add_limits(CLI::App& verb, judge::CheckLimits& limits) {
    verb.add_option("--max-flicker", limits.max_flicker,
                    "Most flicker of a frame: mean square of its difference to the mean of its neighbours "
                    "(of luminance, or of its error), over the clip's mean squared")
        ->check(finite_number(0));
    verb.add_option("--max-error", limits.max_error,
                    "Most relative RMSE of a frame: over the reference's mean")
        ->check(finite_number(0));
    verb.add_option("--max-flip", limits.max_flip, "Most mean FLIP of a frame")->check(finite_number(0));
    verb.add_option("--min-psnr", limits.min_psnr, "Least PSNR of a frame, in dB")
        ->check(finite_number(-1e3));
    verb.add_option("--min-ssim", limits.min_ssim, "Least SSIM of a frame")->check(finite_number(-1));
}

}  // namespace

void add_check_verb(CLI::App& app, Run& run) {
    const auto arguments = std::make_shared<Arguments>();
    judge::CheckOptions& options = arguments->options;
    CLI::App* verb =
        app.add_subcommand("check", "Find what is wrong with a sequence, by itself and against a reference");
    verb->add_option("sequence", options.sequence,
                     "Pattern as clip.%04d.exr or clip.####.exr, folder, manifest.json, or one picture")
        ->required();
    verb->add_option("--reference", options.reference, "Sequence that it should equal");
    verb->add_option("--layer", options.layer, "Layer to judge, as caustics or E (default: R, G, B)");
    verb->add_flag("--graded", arguments->graded,
                   "Judge the graded pictures of folders that dapple rendered");
    verb->add_option("-f,--frames", arguments->frames,
                     "Frames to judge, as 1-48, 1-47x2 or 3,5 (default: all)");
    add_limits(*verb, options.limits);
    verb->add_option(
        "--motion", options.motion_layer,
        "Layer of motion to the frame before, LAYER.X and LAYER.Y in pixels, for the warping error");
    verb->add_option("--flip", arguments->flip, "FLIP for display-referred or scene-linear pictures")
        ->check(CLI::IsMember({"auto", "ldr", "hdr", "none"}))
        ->capture_default_str();
    verb->add_flag("--delta-flip", options.delta_flip,
                   "Also FLIP from frame to frame, less that of the reference (three times the work)");
    verb->add_option("--ppd", options.pixels_per_degree, "Pixels per degree of FLIP's observer")
        ->check(above_zero())  // no NaN, which lies in any range
        ->check(CLI::Range(1.0, 1000.0))
        ->capture_default_str();
    verb->add_option("--exposures", arguments->exposures,
                     "START,STOP,COUNT of HDR-FLIP in stops (default: from the first, middle and last frame "
                     "of the reference, one set for the clip)");
    verb->add_option("--ssim", arguments->ssim, "Windows of SSIM: gaussian 11 x 11, or boxes as in ffmpeg")
        ->check(CLI::IsMember({"gaussian", "boxes"}))
        ->capture_default_str();
    verb->add_option("--peak", options.peak, "Signal range of PSNR and SSIM")
        ->check(above_zero())
        ->capture_default_str();
    verb->add_option("--fps", arguments->fps, "Frames a second (default: of the manifest)")
        ->check(above_zero());
    verb->add_flag("--json", arguments->json, "Print everything as JSON");
    verb->add_option("--html", arguments->html, "Write a page with plots and pictures to this file");
    verb->add_option("--threads", arguments->threads, "Threads; 0: all that the process may use")
        ->check(CLI::Range(0, 1024));
    verb->footer(
        "Exit codes: 0 clean, 2 wrong call, 4 no readable sequence, 5 unwritable page, 6 findings or a limit "
        "passed.");
    verb->callback([arguments, &run] { run = [arguments] { return check(*arguments); }; });
}

}  // namespace dapple::app
