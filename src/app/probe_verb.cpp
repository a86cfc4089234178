#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "app/verbs.h"
#include "base/parallel.h"
#include "render/probe.h"
#include "run/job.h"
#include "timeline/timeline.h"
#include "view/camera_paths.h"

namespace dapple::app {
namespace {

using Json = nlohmann::ordered_json;
using methods::sliced_beams::PointPath;
using methods::sliced_beams::PointPaths;
using render::ProbedReceiver;
using render::ProbedView;

struct Arguments {
    std::string timeline;
    std::string x, y;
    std::vector<std::string> overrides;
    long long frame = 0;
    int threads = 0;
    bool json = false;
};

/// A whole number means a pixel and its centre, a fraction a place.
double coordinate(const char* name, const std::string& text, int size) {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, fault] = std::from_chars(text.data(), end, value, std::chars_format::fixed);
    if (fault != std::errc{} || stop != end || !(value >= 0 && value < size)) {
        const std::string last = std::to_string(size - 1);
        throw Error(ExitCode::usage, std::string(name) + " '" + clipped(text) +
                                         "' is no place in the picture: take a pixel, 0 to " + last +
                                         ", or a place as 3.25, 0.0 to less than " + std::to_string(size) +
                                         ".0");
    }
    return text.find('.') == std::string::npos ? value + 0.5 : value;
}

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

std::string vector_text(const glm::dvec3& v) {
    return "(" + number(v.x) + ", " + number(v.y) + ", " + number(v.z) + ")";
}

std::string count(std::size_t number, const char* what) {
    return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

std::string signed_number(int value) {
    return (value > 0 ? "+" : "") + std::to_string(value);
}

const char* blocked_between(const PointPath& path) {
    return path.blocked_in_air ? "light and water" : "water and receiver";
}

/// Chains in the order of their first paths.
std::vector<std::vector<const PointPath*>> by_chain(const PointPaths& paths) {
    std::vector<std::vector<const PointPath*>> chains;
    for (const PointPath& path : paths.paths) {
        const auto chain = std::find_if(chains.begin(), chains.end(),
                                        [&](const auto& of) { return of.front()->chain == path.chain; });
        (chain == chains.end() ? chains.emplace_back() : *chain).push_back(&path);
    }
    return chains;
}

/// Of one chain.
void print_paths(const scene::FrameState& state, const std::vector<const PointPath*>& paths) {
    std::printf("%s: %s\n", paths.front()->chain.c_str(), count(paths.size(), "path").c_str());
    std::printf("  %-34s  %-26s  %-28s  %11s  %9s  %9s  %-5s %s\n", "on the water [m]", "direction",
                "E [W/m^2]", "det J", "way [m]", "triangle", "fold", "");
    for (const PointPath* path : paths) {
        const std::string blocked = path->blocker
                                        ? "blocked by " + render::object_name(state, *path->blocker) +
                                              " between " + blocked_between(*path)
                                        : "lit";
        char direction[64];
        std::snprintf(direction, sizeof direction, "(%.4f, %.4f, %.4f)", path->direction.x, path->direction.y,
                      path->direction.z);
        std::printf("  %-34s  %-26s  %-28s  %11.5g  %9.5g  %9lu  %-5s %s\n",
                    vector_text(path->water_point).c_str(), direction, vector_text(path->irradiance).c_str(),
                    path->jacobian, path->way, static_cast<unsigned long>(path->triangle),
                    path->near_fold ? "near" : "-", blocked.c_str());
    }
}

const char* surroundings(const ProbedReceiver& receiver) {
    return receiver.in_glass ? "glass" : receiver.in_water ? "water" : "air";
}

void print_receiver(const scene::FrameState& state, const ProbedReceiver& receiver) {
    std::printf("receiver: %s at %s m, normal %s, in the %s, seen %s, %s m from the camera\n",
                receiver.object.c_str(), vector_text(receiver.position).c_str(),
                vector_text(receiver.normal).c_str(), surroundings(receiver),
                receiver.behind_specular ? "through or by water, glass or mirrors" : "directly",
                number(receiver.distance).c_str());
    for (const auto& paths : by_chain(receiver.paths)) print_paths(state, paths);
    std::printf("sum: E %s W/m^2 at the point (a pixel's E is a mean), %s, sum of signs %s%s\n",
                vector_text(receiver.irradiance).c_str(), count(receiver.paths.paths.size(), "path").c_str(),
                signed_number(receiver.paths.sign_sum).c_str(), receiver.paths.fold ? ", near a fold" : "");
    for (const render::OracleCount& oracle : receiver.oracle) {
        if (!oracle.unavailable.empty()) {
            std::printf("oracle: %s: %s\n", oracle.chain.c_str(), oracle.unavailable.c_str());
            continue;
        }
        const std::string behind =
            oracle.behind_waves > 0 ? ", " + std::to_string(oracle.behind_waves) + " more behind waves" : "";
        std::printf("oracle: %s: %s%s, sum of signs %s, %s\n", oracle.chain.c_str(),
                    count(static_cast<std::size_t>(oracle.paths), "path").c_str(), behind.c_str(),
                    signed_number(oracle.sign_sum).c_str(), oracle.proven ? "proven" : "not proven");
    }
}

const char* name_of(ProbedView::Sees sees) {
    switch (sees) {
        case ProbedView::Sees::receiver:
            return "receiver";
        case ProbedView::Sees::sky:
            return "sky";
        case ProbedView::Sees::nothing:
            break;
    }
    return "nothing";
}

void print_view(const scene::FrameState& state, const ProbedView& view, const char* heading) {
    std::printf("%sthroughput %s\n", heading, vector_text(view.throughput).c_str());
    switch (view.sees) {
        case ProbedView::Sees::receiver:
            print_receiver(state, *view.receiver);
            break;
        case ProbedView::Sees::sky:
            std::printf("no receiver: it sees the sky\n");
            break;
        case ProbedView::Sees::nothing:
            std::printf(
                "no receiver: it sees nothing (dark: the path leaves through the water, or meets too "
                "many surfaces)\n");
            break;
    }
}

Json to_json(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

Json to_json(const scene::FrameState& state, const PointPath& path) {
    Json json = {{"chain", path.chain},
                 {"water_point", to_json(path.water_point)},
                 {"direction", to_json(path.direction)},
                 {"irradiance", to_json(path.irradiance)},
                 {"jacobian", path.jacobian},
                 {"sign", path.sign},
                 {"way", path.way},
                 {"triangle", path.triangle},
                 {"near_fold", path.near_fold},
                 {"blocked_by", nullptr}};
    if (path.blocker) {
        json["blocked_by"] = render::object_name(state, *path.blocker);
        json["blocked_between"] = blocked_between(path);
    }
    return json;
}

Json to_json(const scene::FrameState& state, const ProbedReceiver& receiver) {
    Json paths = Json::array();
    for (const PointPath& path : receiver.paths.paths) paths.push_back(to_json(state, path));
    Json oracle = Json::array();
    for (const render::OracleCount& chain : receiver.oracle) {
        if (chain.unavailable.empty())
            oracle.push_back({{"chain", chain.chain},
                              {"paths", chain.paths},
                              {"sign_sum", chain.sign_sum},
                              {"behind_waves", chain.behind_waves},
                              {"proven", chain.proven}});
        else
            oracle.push_back({{"chain", chain.chain}, {"unavailable", chain.unavailable}});
    }
    return {{"object", receiver.object},          {"position", to_json(receiver.position)},
            {"normal", to_json(receiver.normal)}, {"in_water", receiver.in_water},
            {"in_glass", receiver.in_glass},      {"behind_specular", receiver.behind_specular},
            {"distance", receiver.distance},      {"irradiance", to_json(receiver.irradiance)},
            {"count", receiver.paths.count},      {"sign_sum", receiver.paths.sign_sum},
            {"fold", receiver.paths.fold},        {"paths", std::move(paths)},
            {"oracle", std::move(oracle)}};
}

void print_json(const scene::FrameState& state, glm::dvec2 place, const std::vector<ProbedView>& views) {
    Json json = {{"v", 1}, {"frame", state.frame}, {"place", {place.x, place.y}}, {"views", Json::array()}};
    for (const ProbedView& view : views) {
        Json entry = {
            {"branch", view.branch}, {"sees", name_of(view.sees)}, {"throughput", to_json(view.throughput)}};
        if (view.receiver) entry["receiver"] = to_json(state, *view.receiver);
        json["views"].push_back(std::move(entry));
    }
    // Names may come from files in any encoding; what is no UTF-8 is replaced, never thrown.
    std::printf("%s\n", json.dump(1, ' ', false, Json::error_handler_t::replace).c_str());
}

ExitCode probe(const Arguments& arguments, bool frame_given) {
    set_thread_count(arguments.threads);
    const auto timeline = timeline::Timeline::load(arguments.timeline, arguments.overrides);
    const scene::Clip& clip = timeline.clip();
    const glm::dvec2 place(coordinate("X", arguments.x, clip.width),
                           coordinate("Y", arguments.y, clip.height));
    run::check_readable(timeline.input_files());
    const scene::FrameState state = timeline.at(frame_given ? arguments.frame : clip.first_frame);
    if (state.frame < clip.first_frame || state.frame > clip.last_frame) {
        // To stderr: stdout may be JSON for a program.
        std::fprintf(stderr, "note: frame %lld lies outside the clip, where its curves hold\n",
                     static_cast<long long>(state.frame));
    }
    const std::vector<ProbedView> views = render::probe(state, place);
    if (arguments.json) {
        print_json(state, place, views);
        return ExitCode::done;
    }
    std::printf("frame %lld, picture point (%s, %s), ", static_cast<long long>(state.frame),
                number(place.x).c_str(), number(place.y).c_str());
    constexpr std::array<const char*, view::kBranches> kNames{
        "", "\nthe reflected path of the first split, ", "\nthe weaker path of the second split, ",
        "\nthe reflected path of the first split, the weaker of the second, "};
    for (const ProbedView& view : views)
        print_view(state, view, kNames[static_cast<std::size_t>(view.branch)]);
    return ExitCode::done;
}

}  // namespace

void add_probe_verb(CLI::App& app, Run& run) {
    const auto arguments = std::make_shared<Arguments>();
    CLI::App* verb = app.add_subcommand("probe", "List all light paths to what a pixel shows");
    verb->add_option("timeline", arguments->timeline, "YAML file")->required();
    CLI::Option* frame =
        verb->add_option("-f,--frame", arguments->frame, "Frame; default: the first of the clip");
    verb->add_option("X", arguments->x, "Pixel from the left, 0 being the first: 12 (its centre) or 12.25")
        ->required();
    verb->add_option("Y", arguments->y, "Pixel from the top, likewise")->required();
    verb->add_option("--set", arguments->overrides,
                     "Override a key of the timeline: path=value; may be repeated")
        ->allow_extra_args(false);
    verb->add_option("--threads", arguments->threads, "Threads; 0 (default): all that the process may use")
        ->check(CLI::Range(0, 1024));
    verb->add_flag("--json", arguments->json, "Print JSON");
    verb->footer(
        "A line a path: where on the water, the direction of travel from there, E that it brings to the\n"
        "point if nothing blocks it, det J (signed area of its landed beam over that of its facet), the way\n"
        "from the water to the point. A sun counts by the middle of its disc, dispersed light by its green, "
        "an\n"
        "area light by each of its points, which is a chain of its own.\n"
        "The paths are those of the water mesh; where the water is a list of waves, the oracle proves their\n"
        "number on the waves themselves. Light that met glass is not listed.");
    verb->callback([arguments, frame, &run] {
        run = [arguments, given = frame->count() > 0] { return probe(*arguments, given); };
    });
}

}  // namespace dapple::app
