#include <sys/statvfs.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/verbs.h"
#include "base/parallel.h"
#include "run/frame_loop.h"
#include "run/manifest.h"
#include "run/memory_budget.h"
#include "run/output_paths.h"
#include "run/timeline_source.h"

namespace dapple::app {
namespace {

struct Arguments {
    std::string timeline;
    std::vector<std::string> overrides;
    std::string frames;
    std::string output;
    std::string existing = "verify";
    int threads = 0;
    std::string device;
    std::string max_memory;
    std::string log_json;
    bool plan = false;
    bool dry_run = false;
    bool strict = false;
    std::optional<double> max_flicker;
};

run::Existing existing_of(const std::string& name) {
    if (name == "skip") return run::Existing::skip;
    if (name == "overwrite") return run::Existing::overwrite;
    if (name == "error") return run::Existing::error;
    return run::Existing::verify;
}

/// The plan of the first frame, and of each later one whose plan is another.
void print_plan(run::TimelineSource& source, const FrameSet& frames) {
    std::string known;
    for (const std::int64_t frame : frames.frames()) {
        const std::vector<render::PlanLine> lines = source.plan(frame);
        std::size_t width = 0;
        for (const render::PlanLine& line : lines) width = std::max(width, line.pass.size());
        std::string text;
        for (const render::PlanLine& line : lines) {
            text += "  " + line.pass + std::string(width - line.pass.size(), ' ') + "  " + line.decision +
                    std::string(line.decision.size() < 6 ? 6 - line.decision.size() : 0, ' ') + "  " +
                    line.reason + "\n";
        }
        if (text == known) continue;
        known = text;
        std::printf("from frame %lld:\n%s", static_cast<long long>(frame), text.c_str());
    }
}

std::string free_space(std::filesystem::path folder) {
    folder = std::filesystem::absolute(folder);
    std::error_code ignored;
    while (!std::filesystem::exists(folder, ignored) && folder.has_relative_path())
        folder = folder.parent_path();
    struct statvfs disk {};
    if (::statvfs(folder.c_str(), &disk) != 0) return "an unknown amount";
    return run::format_bytes(static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize));
}

/// Settings for caustics.target_error: those of the folder's manifest where that is this job's, else chosen
/// by the pilot frames.
void settle(const timeline::Timeline& timeline, const gpu::Device& device, run::TimelineSource& source,
            const run::LoopOptions& options, const run::Interruption& interruption) {
    if (!timeline.gives("caustics.target_error")) return;
    const run::OutputPaths paths(options.folder, timeline.clip().name);
    source.settle(run::known_settings(paths.manifest(), job_of(timeline, device, source)), options.max_memory,
                  [&] { return interruption.requested(); });
}

void print_dry_run(const run::TimelineSource& source, const scene::Clip& clip,
                   const run::LoopOptions& options) {
    const run::OutputPaths paths(options.folder, clip.name);
    std::size_t memory = 0;
    for (const std::int64_t frame : options.frames.frames()) {
        std::printf("frame %lld: %s %s\n", static_cast<long long>(frame), paths.linear(frame).c_str(),
                    paths.graded(frame).c_str());
        memory = std::max(memory, source.bytes(frame));
    }
    const double disk = run::largest_frame_bytes(clip) * static_cast<double>(options.frames.frames().size());
    std::printf("%zu frames (%s) of %dx%d\n", options.frames.frames().size(),
                to_string(options.frames).c_str(), clip.width, clip.height);
    if (source.settled()) {
        const render::PlanLine line = source.settled_line();
        std::printf("%s: %s\n", line.pass.c_str(), line.reason.c_str());
    }
    std::printf("memory: about %s a frame, of %s allowed\n",
                run::format_bytes(static_cast<double>(memory)).c_str(),
                run::format_bytes(static_cast<double>(options.max_memory)).c_str());
    std::printf("disk: at most %s, of %s free\n", run::format_bytes(disk).c_str(),
                free_space(options.folder).c_str());
}

/// With $DAPPLE_VALIDATION set, a message of the validation layer is a failure.
void check_validation(const gpu::Device& device) {
    const std::vector<std::string>& messages = device.validation_messages();
    if (messages.empty()) return;
    throw Error(ExitCode::device, "the validation layer sent " + std::to_string(messages.size()) +
                                      " messages, the first: " + clipped(messages.front()));
}

/// A limit that nothing can exceed, such as NaN, would be no check.
CLI::Validator positive_number() {
    const auto fault = [](const std::string& text) -> std::string {
        double number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        const bool whole = error == std::errc{} && end == text.data() + text.size();
        if (whole && std::isfinite(number) && number > 0) return "";
        return "'" + clipped(text) + "' is no number above 0, such as 1e-3";
    };
    return {fault, "NUMBER > 0"};
}

ExitCode render(const Arguments& arguments) {
    const run::Interruption interruption;
    run::LoopOptions options;
    if (!arguments.frames.empty()) options.frames = FrameSet::parse(arguments.frames);
    options.max_memory =
        arguments.max_memory.empty() ? run::default_memory_budget() : run::parse_bytes(arguments.max_memory);
    options.existing = existing_of(arguments.existing);
    options.strict = arguments.strict;
    options.max_flicker = arguments.max_flicker;
    set_thread_count(arguments.threads);
    image::set_exr_threads(thread_count());

    const auto timeline = timeline::Timeline::load(arguments.timeline, arguments.overrides);
    const scene::Clip& clip = timeline.clip();
    if (arguments.frames.empty()) options.frames = FrameSet::range(clip.first_frame, clip.last_frame);
    options.folder = arguments.output.empty() ? "out/" + clip.name : arguments.output;
    run::check_readable(timeline.input_files());

    gpu::Device device({.name = arguments.device, .threads = arguments.threads});
    run::TimelineSource source(timeline, device);
    source.limit_memory(options.max_memory);
    settle(timeline, device, source, options, interruption);
    if (arguments.plan) {
        print_plan(source, options.frames);
        return ExitCode::done;
    }
    if (arguments.dry_run) print_dry_run(source, clip, options);
    run::check_memory(source, options.frames, options.max_memory);
    if (arguments.dry_run) return ExitCode::done;

    options.linear_exr = source.linear_exr();
    options.graded_exr = source.graded_exr();
    run::Reporter reporter(arguments.log_json);
    if (options.frames.duplicates() > 0) {
        reporter.note(std::to_string(options.frames.duplicates()) + " repeated frames are rendered once");
    }
    if (source.settled()) {
        const render::PlanLine line = source.settled_line();
        const std::string text = line.pass + ": " + line.reason;
        source.settled()->reached() ? reporter.note(text) : reporter.warning(text);
    }
    const auto outside = std::count_if(
        options.frames.frames().begin(), options.frames.frames().end(),
        [&](std::int64_t frame) { return frame < clip.first_frame || frame > clip.last_frame; });
    if (outside > 0) {
        reporter.note(std::to_string(outside) + " frames lie outside the clip, where its curves hold");
    }
    try {
        const run::Job job = job_of(timeline, device, source);
        const ExitCode code = run::render_frames(job, source, options, interruption, reporter);
        check_validation(device);
        return code;
    } catch (const Error& error) {
        reporter.run_failed(static_cast<int>(error.code()), error.what());
        throw;
    }
}

}  // namespace

void add_render_verb(CLI::App& app, Run& run) {
    const auto arguments = std::make_shared<Arguments>();
    CLI::App* verb = app.add_subcommand("render", "Render the frames of a timeline");
    verb->add_option("timeline", arguments->timeline, "YAML file")->required();
    verb->add_option(
        "-f,--frames", arguments->frames,
        "Frames, as in 1-10, 1-10x3 (every third), 1-10y3 (the others), 7,3,10-5; default: all of the clip");
    verb->add_option("-o,--output", arguments->output, "Folder for the files; default: out/NAME of the clip");
    verb->add_option("--existing", arguments->existing,
                     "What to do with finished frames: verify (default; keep those whose content is right), "
                     "skip (look "
                     "at sizes only), overwrite, error")
        ->check(CLI::IsMember({"verify", "skip", "overwrite", "error"}));
    verb->add_option("--set", arguments->overrides,
                     "Override a key of the timeline: path=value; may be repeated")
        ->allow_extra_args(false);
    verb->add_option("--threads", arguments->threads, "Threads; 0 (default): all that the process may use")
        ->check(CLI::Range(0, 1024));
    verb->add_option("--device", arguments->device, "Part of the name of a Vulkan device (see dapple info)");
    verb->add_option(
        "--max-memory", arguments->max_memory,
        "Refuse frames that need more, as in 8G; default: three quarters of the machine's memory");
    verb->add_option("--log-json", arguments->log_json, "Append events as lines of JSON to this file");
    verb->add_flag("--plan", arguments->plan, "Print which passes the frames need, and why; render nothing");
    verb->add_flag("--dry-run", arguments->dry_run,
                   "Print the frames, their files, memory and disk space; render nothing");
    verb->add_flag(
        "--strict", arguments->strict,
        "Exit with 6 where values were not finite or a pass was done partly; the frames are complete then");
    verb->add_option(
            "--max-flicker", arguments->max_flicker,
            "Exit with 6 where the flicker of a frame of the folder exceeds this: the mean square of "
            "its difference to the mean of its neighbours, over the clip's mean squared; the frames "
            "are complete then")
        ->check(positive_number());
    verb->footer(
        "Exit codes: 0 done, 2 wrong call or another job's folder, 3 invalid timeline, 4 unreadable input,\n"
        "5 unwritable output, 6 --strict or --max-flicker, 7 device, 33 memory, 75 interrupted (the same "
        "command goes on).\n"
        "A first SIGINT, SIGTERM or SIGHUP lets the frame at work be finished; a second one does not.");
    verb->callback([arguments, &run] { run = [arguments] { return render(*arguments); }; });
}

}  // namespace dapple::app
