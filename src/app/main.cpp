// dapple: turns a YAML timeline into an EXR clip of water caustics. Parses the command line, prints errors,
// returns the exit codes of CONVENTIONS.md.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <new>
#include <string>

#include "app/verbs.h"
#include "timeline/timeline.h"

namespace dapple::app {
namespace {

/// The one form of error lines, for people and for the farms' patterns.
int fail(ExitCode code, const std::string& message) {
    std::fflush(stdout);  // so that the error stands last, also where both go to one file
    std::fprintf(stderr, "ERROR [%d] %s\n", static_cast<int>(code), message.c_str());
    return static_cast<int>(code);
}

/// All faults with their lines, then the error line.
int fail(const timeline::TimelineError& error) {
    for (const timeline::Fault& fault : error.faults()) {
        std::fprintf(stderr, "%s\n", to_string(fault).c_str());
    }
    const std::size_t count = error.faults().size() + error.more();
    return fail(error.code(), "the timeline is invalid: " + std::to_string(count) +
                                  (count == 1 ? " fault" : " faults") +
                                  (error.more() > 0 ? ", the first are shown" : ""));
}

/// CLI11 may break its messages into lines.
std::string one_line(std::string text) {
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return clipped(text);
}

int parse_and_run(int argc, char** argv) {
    CLI::App parser("dapple: an animation sequencer for water caustics", "dapple");
    parser.set_version_flag("--version", std::string("dapple ") + DAPPLE_VERSION);
    parser.require_subcommand(1);
    Run run;
    add_render_verb(parser, run);
    add_validate_verb(parser, run);
    add_probe_verb(parser, run);
    add_check_verb(parser, run);
    add_compare_verb(parser, run);
    add_bench_verb(parser, run, argc, argv);
    add_info_verb(parser, run);
    try {
        parser.parse(argc, argv);
    } catch (const CLI::Success& request) {  // --help, --version
        return parser.exit(request);
    } catch (const CLI::ParseError& error) {
        const std::string first = argc > 1 ? argv[1] : "";
        const bool known =
            !parser.get_subcommands([&](const CLI::App* verb) { return verb->get_name() == first; }).empty();
        if (!first.starts_with('-') && !known) {
            return fail(ExitCode::usage,
                        (first.empty() ? "a verb is missing" : "unknown verb '" + clipped(first) + "'") +
                            "; there are render, validate, probe, check, compare, bench and info (see dapple "
                            "--help)");
        }
        return fail(ExitCode::usage, one_line(error.what()) + " (see --help)");
    }
    return static_cast<int>(run());
}

int guarded_main(int argc, char** argv) {
    try {
        return parse_and_run(argc, argv);
    } catch (const timeline::TimelineError& error) {
        return fail(error);
    } catch (const Error& error) {
        return fail(error.code(), error.what());
    } catch (const std::bad_alloc&) {
        return fail(ExitCode::out_of_memory_budget, "the memory of the machine or of its limits is used up");
    } catch (const std::exception& error) {
        return fail(ExitCode::failure, one_line(error.what()));
    }
}

}  // namespace
}  // namespace dapple::app

int main(int argc, char** argv) {
    return dapple::app::guarded_main(argc, argv);
}
