#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "app/verbs.h"
#include "color/grader.h"
#include "render/texture_files.h"
#include "run/job.h"
#include "run/output_paths.h"
#include "run/timeline_source.h"
#include "timeline/timeline.h"

namespace dapple::app {
namespace {

struct Arguments {
    std::string timeline;
    std::vector<std::string> overrides;
};

std::string count(std::size_t number, const std::string& what) {
    return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

/// Checks all that can be checked without a device. Faults are thrown.
ExitCode validate(const Arguments& arguments) {
    const auto timeline = timeline::Timeline::load(arguments.timeline, arguments.overrides);
    const scene::Clip& clip = timeline.clip();
    const std::vector<std::string> inputs = timeline.input_files();
    run::check_readable(inputs);
    const scene::FrameState state = timeline.at(clip.first_frame);
    render::check_light_textures(state);
    const color::Grader grader(run::view_settings(state.output));
    const run::OutputPaths paths("out/" + clip.name, clip.name);

    const std::string fps = std::to_string(clip.fps.numerator) +
                            (clip.fps.denominator == 1 ? "" : "/" + std::to_string(clip.fps.denominator));
    std::printf(
        "%s is valid: clip %s, frames %lld-%lld at %s fps, %dx%d, %s a pixel, %s, %s, %s, caustics by %s, "
        "%s\n",
        arguments.timeline.c_str(), clip.name.c_str(), static_cast<long long>(clip.first_frame),
        static_cast<long long>(clip.last_frame), fps.c_str(), clip.width, clip.height,
        count(static_cast<std::size_t>(clip.samples), "sample").c_str(), state.water ? "water" : "no water",
        count(state.lights.size(), "light").c_str(), count(state.objects.size(), "object").c_str(),
        state.caustics.method.c_str(), count(inputs.size(), "input file").c_str());
    return ExitCode::done;
}

}  // namespace

void add_validate_verb(CLI::App& app, Run& run) {
    const auto arguments = std::make_shared<Arguments>();
    CLI::App* verb = app.add_subcommand("validate", "Check a timeline and its files; render nothing");
    verb->add_option("timeline", arguments->timeline, "YAML file")->required();
    verb->add_option("--set", arguments->overrides,
                     "Override a key of the timeline: path=value; may be repeated")
        ->allow_extra_args(false);
    verb->callback([arguments, &run] { run = [arguments] { return validate(*arguments); }; });
}

}  // namespace dapple::app
