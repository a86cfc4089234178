#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>

#include "methods/reference/round_estimate.h"

namespace dapple::reference {

enum class Quantity : int { irradiance, in_scatter };

/// Estimates by (quantity, sample, branch) of their layer.
using Progress = std::map<std::tuple<Quantity, int, int>, RoundEstimate>;

/// Reads what `write_progress` wrote for the same `job`; nothing where there is no such file, or it is
/// damaged, of another version or of another job: work is then done again.
Progress read_progress(const std::string& path, const std::string& job);

/// Replaces the file as a whole (base/checked_file.h); Error(output_unwritable).
void write_progress(const std::string& path, const std::string& job, const Progress& progress);

}  // namespace dapple::reference
