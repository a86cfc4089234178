#pragma once
#include <string>
#include <vector>

#include "input/located_node.h"
#include "timeline/fault_list.h"

namespace dapple::timeline {

/// Writes "path=value" into the tree, in the order given, values read as YAML. List elements go by index or
/// name: water.surface.waves[0].amplitude=5 mm, lights.sun.elevation=30 deg. Maps on the way are made where
/// they are not there, so that keys left to their default can be set; whether such keys exist is for the
/// check of the tree.
void apply_overrides(const std::vector<std::string>& overrides, input::LocatedNode& root, FaultList& faults);

}  // namespace dapple::timeline
