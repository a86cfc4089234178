#pragma once
#include <string>

#include "judge/check.h"

namespace dapple::judge {

/// "frame 7 (pop, around (40, 60)): pops: ..." of a finding, one line.
std::string line_of(const Finding& finding);

/// A figure of CheckResult::clip as people read it, with its unit: "RMSE of means of 4 x 4 pixels [pixel
/// value]". The key itself where it is not known.
std::string figure_name(const std::string& key);

/// A line a finding, then a table of the clip's figures.
std::string check_text(const CheckResult& result);

/// Everything, frame by frame. Numbers that JSON cannot hold are "inf", "-inf" and "nan".
std::string check_json(const CheckResult& result);

/// The page: verdict, findings, figures, plots over the frames, a heat map of the temporal deviation, and the
/// pictures around the worst places. Reads those few frames again; needs CheckOptions::maps.
std::string check_html(const CheckResult& result);

}  // namespace dapple::judge
