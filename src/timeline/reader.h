#pragma once
#include <string>

#include "input/located_node.h"
#include "timeline/fault_list.h"
#include "timeline/program.h"

namespace dapple::timeline {

/// Checks a tree against the schema and turns it into a program. Goes on after a fault, so that all are
/// found.
Program read_program(const input::LocatedNode& root, const std::string& folder, FaultList& faults);

}  // namespace dapple::timeline
