#pragma once
#include <string>
#include <vector>

#include "run/child_process.h"
#include "run/scratch_folder.h"
#include "source_dir.h"

namespace dapple::end_to_end {

inline const std::string kFolder = std::string(DAPPLE_SOURCE_DIR) + "/tests/end_to_end";
inline const std::string kSmall = kFolder + "/small.yaml";

inline std::vector<std::string> dapple(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), DAPPLE_PROGRAM);
    return arguments;
}

/// Runs dapple to its end; its output goes to a file in `scratch`.
inline testing_tools::Outcome run_dapple(const testing_tools::ScratchFolder& scratch,
                                         const std::vector<std::string>& arguments) {
    return testing_tools::run_program(dapple(arguments), scratch / "output.txt");
}

}  // namespace dapple::end_to_end
