#pragma once
#include "input/located_node.h"
#include "timeline/fault_list.h"
#include "timeline/program.h"

namespace dapple::timeline {

/// Checks what no key can be checked for alone: a camera that looks nowhere, a sun that shines upwards. Keyed
/// values are looked at in the clip's frames, all of them up to 4096, else as many at even distances.
void check_program(const Program& program, const input::LocatedNode& root, FaultList& faults);

}  // namespace dapple::timeline
