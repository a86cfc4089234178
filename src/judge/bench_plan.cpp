#include "judge/bench_plan.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/suggest.h"
#include "ocean/grid_size.h"
#include "ocean/lamp_mesh.h"
#include "scene/schema.h"
#include "timeline/timeline.h"

namespace dapple::judge {
namespace {

constexpr std::string_view kReference = "reference";
constexpr std::string_view kCaustics = "caustics";
constexpr std::string_view kExample =
    "write METHOD:KEY=V1,V2, as in sliced_beams:water.mesh_cells=100,200,400";

/// Keys that decide how exact a method is, and values from cheap to dear. Methods that are not listed are run
/// as they are.
struct DefaultLadder {
    std::string_view method, key;
    std::vector<std::string_view> values;
};
const std::array<DefaultLadder, 3> kDefaultLadders{
    {{"photon_splatting", "caustics.map_resolution", {"256", "512", "1024", "2048"}},
     {"caustic_mesh", "caustics.map_resolution", {"256", "512", "1024", "2048"}},
     {"adaptive_beams", "caustics.levels", {"0", "1", "2", "3", "4", "5"}}}};

const scene::Structure& caustics_schema() {
    return *scene::frame_schema().find(kCaustics, "")->structure;
}

std::vector<std::string_view> all_methods() {
    return caustics_schema().find("method", "")->choices;
}

[[noreturn]] void wrong(const std::string& message) {
    throw Error(ExitCode::usage, message);
}

std::string_view stripped(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    return text;
}

/// Cut at commas that stand in no brackets or quotes.
std::vector<std::string> values_of(std::string_view text) {
    std::vector<std::string> values;
    std::string value;
    int depth = 0;
    char quote = 0;
    const auto end_value = [&] {
        values.emplace_back(stripped(value));
        value.clear();
    };
    for (const char c : text) {
        if (quote != 0) {
            if (c == quote) quote = 0;
        } else if (c == '"' || c == '\'') {
            quote = c;
        } else if (c == '[' || c == '{') {
            ++depth;
        } else if (c == ']' || c == '}') {
            --depth;
        } else if (c == ',' && depth == 0) {
            end_value();
            continue;
        }
        value += c;
    }
    end_value();
    return values;
}

void check_method(const std::string& method) {
    const std::vector<std::string> known = judged_methods();
    if (std::find(known.begin(), known.end(), method) != known.end()) return;
    if (method == kReference)
        wrong("reference is what the methods are judged by; it cannot be judged itself");
    wrong("there is no method " + in_quotes(clipped(method)) +
          suggestion(method, {known.begin(), known.end()}, "there are"));
}

std::string file_name(const std::string& text) {
    std::string name;
    for (const char c : text) {
        const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                           std::string_view("._=+-").find(c) != std::string_view::npos;
        name += plain ? c : '_';
    }
    return name;
}

/// The key below `caustics` that an override sets; empty where it sets something else.
std::string caustics_key(const std::string& setting) {
    const std::string path = setting.substr(0, setting.find('='));
    if (path == kCaustics || path == "caustics.method") {
        wrong("--set " + clipped(path) +
              ": choose methods by --methods and set their keys one by one: caustics.KEY=VALUE");
    }
    const std::string prefix = std::string(kCaustics) + ".";
    return path.starts_with(prefix) ? path.substr(prefix.size()) : "";
}

void check_caustics_keys(const std::vector<std::string>& settings) {
    std::vector<std::string_view> known;
    for (const scene::Field& field : caustics_schema().fields) known.push_back(field.key);
    for (const std::string& setting : settings) {
        const std::string key = caustics_key(setting);
        if (key.empty() || std::find(known.begin(), known.end(), key) != known.end()) continue;
        wrong("--set caustics." + clipped(key) + ": no method knows this key" + suggestion(key, known));
    }
}

std::vector<Ladder> ladders_of(const PlanOptions& options, const scene::FrameState& state) {
    std::vector<Ladder> given;
    for (const std::string& text : options.ladders) {
        given.push_back(parse_ladder(text));
        check_method(given.back().method);
    }
    const std::vector<std::string> methods = methods_of(options);
    for (const Ladder& ladder : given) {
        if (std::find(methods.begin(), methods.end(), ladder.method) == methods.end()) {
            wrong("--ladder is for " + ladder.method + ", which --methods leaves out");
        }
    }
    std::vector<Ladder> ladders;
    for (const std::string& method : methods) {
        const std::size_t before = ladders.size();
        std::copy_if(given.begin(), given.end(), std::back_inserter(ladders),
                     [&](const Ladder& ladder) { return ladder.method == method; });
        if (ladders.size() == before) ladders.push_back(default_ladder(method, state));
    }
    return ladders;
}

}  // namespace

Ladder parse_ladder(const std::string& text) {
    const std::size_t colon = text.find(':');
    const std::size_t equals = text.find('=');
    if (colon == std::string::npos || equals == std::string::npos || equals < colon) {
        wrong("--ladder " + in_quotes(clipped(text)) + ": " + std::string(kExample));
    }
    Ladder ladder;
    ladder.method = stripped(std::string_view(text).substr(0, colon));
    ladder.key = stripped(std::string_view(text).substr(colon + 1, equals - colon - 1));
    ladder.values = values_of(std::string_view(text).substr(equals + 1));
    const bool empty_value = std::any_of(ladder.values.begin(), ladder.values.end(),
                                         [](const std::string& value) { return value.empty(); });
    if (ladder.method.empty() || ladder.key.empty() || empty_value) {
        wrong("--ladder " + in_quotes(clipped(text)) + ": something is missing; " + std::string(kExample));
    }
    if (ladder.key == kCaustics || ladder.key == "caustics.method") {
        wrong("--ladder " + in_quotes(clipped(text)) + ": a ladder leads over values of one method's key");
    }
    return ladder;
}

std::vector<std::string> judged_methods() {
    std::vector<std::string> methods;
    for (const std::string_view method : all_methods())
        if (method != kReference) methods.emplace_back(method);
    return methods;
}

std::vector<std::string> methods_of(const PlanOptions& options) {
    const std::vector<std::string>& methods = options.methods;
    for (const std::string& method : methods) {
        check_method(method);
        if (std::count(methods.begin(), methods.end(), method) > 1)
            wrong("--methods names " + method + " twice");
    }
    return methods.empty() ? judged_methods() : methods;
}

Ladder default_ladder(const std::string& method, const scene::FrameState& state) {
    Ladder ladder{method, "", {""}};
    for (const DefaultLadder& known : kDefaultLadders) {
        if (known.method != method) continue;
        ladder.key = known.key;
        ladder.values.assign(known.values.begin(), known.values.end());
    }
    if (method == "sliced_beams" && state.water && !ocean::is_flat(state.water->surface) &&
        !ocean::has_rings(*state.water)) {
        // Its error is the mesh's: about what the timeline itself resolves. Meshes from files bring their
        // own.
        const int cells = ocean::grid_size(*ocean::with_mesh_for_lamps(state).water).cells_x;
        if (state.water->surface.type == scene::WaterSurfaceType::mesh_sequence || cells < 8) return ladder;
        ladder.key = "water.mesh_cells";
        ladder.values.clear();
        for (const double factor : {0.25, 0.5, 1.0, 2.0})
            ladder.values.push_back(std::to_string(static_cast<int>(factor * cells)));
    }
    return ladder;
}

std::vector<std::string> overrides_for(const std::string& method, const std::string& own,
                                       const std::vector<std::string>& settings) {
    std::vector<std::string> overrides;
    if (method != own) overrides.push_back("caustics={method: " + method + "}");
    for (const std::string& setting : settings) {
        const std::string key = caustics_key(setting);
        if (key.empty() || caustics_schema().find(key, method) != nullptr) overrides.push_back(setting);
    }
    return overrides;
}

BenchPlan plan_bench(const std::string& timeline, const PlanOptions& options) {
    std::vector<std::string> scene_settings;
    for (const std::string& setting : options.settings)
        if (caustics_key(setting).empty()) scene_settings.push_back(setting);
    check_caustics_keys(options.settings);
    const auto plain = timeline::Timeline::load(timeline, scene_settings);
    const scene::FrameState state = plain.at(plain.clip().first_frame);

    BenchPlan plan;
    plan.ladders = ladders_of(options, state);
    std::vector<std::string> reference_settings = options.settings;
    char error[64];
    std::snprintf(error, sizeof error, "caustics.standard_error=%.9g", options.reference_error);
    reference_settings.insert(reference_settings.begin(), error);
    plan.reference_overrides =
        overrides_for(std::string(kReference), state.caustics.method, reference_settings);
    timeline::Timeline::load(timeline, plan.reference_overrides);

    std::set<std::string> names;
    for (std::size_t i = 0; i < plan.ladders.size(); ++i) {
        const Ladder& ladder = plan.ladders[i];
        for (const std::string& value : ladder.values) {
            Rung rung{i, value, ladder.method,
                      overrides_for(ladder.method, state.caustics.method, options.settings)};
            if (!ladder.key.empty()) {
                rung.name = file_name(ladder.method + "-" + ladder.key + "=" + value);
                rung.overrides.push_back(ladder.key + "=" + value);
            }
            if (!names.insert(rung.name).second)
                wrong("two rungs are called " + rung.name + ": leave one out");
            timeline::Timeline::load(timeline, rung.overrides);
            plan.rungs.push_back(std::move(rung));
        }
    }
    return plan;
}

std::vector<std::string> yaml_files(const std::string& folder, const std::string& option) {
    std::vector<std::string> files;
    std::error_code fault;
    for (const auto& entry : std::filesystem::directory_iterator(folder, fault))
        if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
    if (files.empty()) wrong(option + " " + folder + ": no folder of timelines (*.yaml)");
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace dapple::judge
