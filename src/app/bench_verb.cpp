#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "app/verbs.h"
#include "base/parallel.h"
#include "image/exr.h"
#include "judge/bench.h"

namespace dapple::app {
namespace {

ExitCode bench(judge::BenchOptions options) {
    if (options.timeline.empty() && options.hard_cases.empty() && options.claims.empty()) {
        throw Error(ExitCode::usage,
                    "name a timeline, or --hard-cases FOLDER, or --claims FOLDER (see --help)");
    }
    const run::Interruption interruption;
    set_thread_count(options.threads);
    image::set_exr_threads(thread_count());
    if (options.folder.empty()) {
        const std::string& named = !options.timeline.empty() ? options.timeline
                                   : !options.claims.empty() ? options.claims
                                                             : options.hard_cases;
        options.folder = "out/bench_" + std::filesystem::path(named).lexically_normal().stem().string();
    }
    run::Reporter reporter;
    return judge::bench(options, interruption, reporter);
}

std::string command_line(int argc, const char* const* argv) {
    std::string text;
    for (int i = 0; i < argc; ++i) text += (i > 0 ? " " : "") + std::string(argv[i]);
    return text;
}

}  // namespace

void add_bench_verb(CLI::App& app, Run& run, int argc, const char* const* argv) {
    const auto options = std::make_shared<judge::BenchOptions>();
    options->command_line = command_line(argc, argv);
    CLI::App* verb = app.add_subcommand(
        "bench", "Time and judge every method over a ladder of settings against the reference");
    verb->add_option("timeline", options->timeline, "YAML file");
    verb->add_option("--methods", options->plan.methods, "Methods, as in a,b; default: all but the reference")
        ->delimiter(',')
        ->allow_extra_args(false);
    verb->add_option(
            "--ladder", options->plan.ladders,
            "METHOD:KEY=V1,V2,...: values of one key for one method, in place of its default ladder; may "
            "be repeated")
        ->allow_extra_args(false);
    verb->add_option(
        "-f,--frames", options->frames,
        "Frames, as in render; default: three in the middle of the clip. Flicker needs three in a row");
    verb->add_option(
            "--set", options->plan.settings,
            "Override a key of the timeline in all runs, the reference too: path=value; caustics.KEY for "
            "the methods that know KEY; hard cases stay as they are; may be repeated")
        ->allow_extra_args(false);
    verb->add_option("-o,--output", options->folder, "Folder for runs and report; default: out/bench_NAME");
    verb->add_option("--repeats", options->repeats, "Processes a run, for its times; default: 3")
        ->check(CLI::Range(1, 1000));
    verb->add_option("--reference-error", options->plan.reference_error,
                     "Standard error at which the reference ends; default: 0.01")
        ->check(CLI::Range(1e-6, 1.0));
    verb->add_option("--layer", options->layer, "Layer that is compared; default: E, the irradiance");
    verb->add_option(
        "--hard-cases", options->hard_cases,
        "Also render every timeline (*.yaml) of this folder by every method, with a verdict each");
    verb->add_option("--claims", options->claims,
                     "A claim of a paper as a file, or a folder of them (*.yaml), as sequences/claims: runs "
                     "them and says by what factor each claim holds or fails; without a timeline");
    verb->add_option("--threads", options->threads, "Threads; 0 (default): all that the process may use")
        ->check(CLI::Range(0, 1024));
    verb->add_option("--device", options->device, "Part of the name of a Vulkan device (see dapple info)");
    verb->footer(
        "A reference at full size is out of reach: --set 'clip.resolution=[240, 135]' is usual, and\n"
        "--set clip.samples=1. Finished runs and references are kept in the folder and used again where\n"
        "their job is the same. Writes bench.csv, bench.json and index.html.\n"
        "Exit codes: 0 done, 2 wrong call, 3 invalid timeline, 4 unreadable input, 5 unwritable output, 6 a "
        "run\n"
        "or a hard case failed, or a figure of a claim is not what is expected, 7 device, 33 memory, 75 "
        "interrupted (the same command goes on).");
    verb->callback([options, &run] { run = [options] { return bench(*options); }; });
}

}  // namespace dapple::app
