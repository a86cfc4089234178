#pragma once
#include <string>
#include <vector>

#include "timeline/program.h"

namespace dapple::timeline {

/// Timeline::fingerprint and Timeline::input_files of a program whose timeline stands in `folder`.
std::string fingerprint(const Program& program, const std::string& folder);
std::vector<std::string> input_files(const Program& program);

}  // namespace dapple::timeline
