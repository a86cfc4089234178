#pragma once
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"

namespace CLI {
class App;
}

namespace dapple::app {

/// Each adds one verb to the command line. `run` is set to what the verb does, once its arguments are parsed;
/// it returns the exit code or throws.
using Run = std::function<ExitCode()>;
void add_render_verb(CLI::App& app, Run& run);
void add_validate_verb(CLI::App& app, Run& run);
void add_info_verb(CLI::App& app, Run& run);
void add_probe_verb(CLI::App& app, Run& run);
void add_check_verb(CLI::App& app, Run& run);
void add_compare_verb(CLI::App& app, Run& run);
void add_bench_verb(CLI::App& app, Run& run, int argc,
                    const char* const* argv);  ///< the call, for its report

}  // namespace dapple::app
