#pragma once
#include <vector>

#include "judge/check.h"
#include "judge/check_frames.h"
#include "judge/sequence.h"

namespace dapple::judge {

/// Files of one frame that are missing, damaged, or not what the manifest says.
void check_file(const Sequence& sequence, const ReadFrame& frame, std::vector<Finding>& findings);

/// All findings of a measured clip, each cause once: what a missing, repeated or shifted frame does to its
/// neighbours is no jump. `findings` holds those of the files; the result's figures are complete.
void add_findings(const FrameMeasurer::Found& found, std::vector<Finding> findings, CheckResult& result);

}  // namespace dapple::judge
