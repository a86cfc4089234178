#pragma once
#include <string>
#include <vector>

#include "scene/frame_state.h"

namespace dapple::judge {

/// One method over values of one key, the cheapest first: "METHOD:KEY=V1,V2".
struct Ladder {
    std::string method;
    std::string key;  ///< a path in the timeline ("water.mesh_cells"); empty: the method is run as it is
    std::vector<std::string> values;  ///< YAML; one empty value where there is no key

    std::string name() const { return key.empty() ? method : method + ", " + key; }
    bool operator==(const Ladder&) const = default;
};

/// A method with one setting: what is rendered, timed and judged.
struct Rung {
    std::size_t ladder = 0;  ///< index in BenchPlan::ladders
    std::string value;
    std::string name;                    ///< fit for a folder: "sliced_beams-water.mesh_cells=200"
    std::vector<std::string> overrides;  ///< of the timeline, as for --set
};

struct BenchPlan {
    std::vector<Ladder> ladders;
    std::vector<Rung> rungs;
    std::vector<std::string> reference_overrides;
};

struct PlanOptions {
    std::vector<std::string> methods = {};  ///< empty: all but the reference
    std::vector<std::string> ladders = {};  ///< as given; a method's own take the place of its default ladder
    std::vector<std::string> settings =
        {};                         ///< "path=value" for all runs; caustics.KEY for those that know KEY
    double reference_error = 0.01;  ///< caustics.standard_error of the reference
};

/// Throws Error(usage) that says what would be right. Values are cut at commas outside brackets and quotes.
Ladder parse_ladder(const std::string& text);

/// Names of the methods that can be judged: all of the schema but the reference.
std::vector<std::string> judged_methods();

/// The methods that are asked for. Throws Error(usage) for unknown ones and one named twice.
std::vector<std::string> methods_of(const PlanOptions& options);

/// What a method is run over where nothing is said. `state`: of the clip's first frame.
Ladder default_ladder(const std::string& method, const scene::FrameState& state);

/// Overrides that make `method` render a timeline whose own method is `own`: the caustics' keys of another
/// method go, those of `settings` ("path=value") that the method does not know are left out.
std::vector<std::string> overrides_for(const std::string& method, const std::string& own,
                                       const std::vector<std::string>& settings);

/// All runs over a timeline. Throws Error(usage) for unknown methods, twice the same rung, a setting of the
/// caustics that no method knows; TimelineError where the timeline does not take a setting of a rung.
BenchPlan plan_bench(const std::string& timeline, const PlanOptions& options);

/// The files *.yaml of a folder that `option` names, sorted. Throws Error(usage) where there is none.
std::vector<std::string> yaml_files(const std::string& folder, const std::string& option);

}  // namespace dapple::judge
