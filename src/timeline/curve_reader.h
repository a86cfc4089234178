#pragma once
#include <cstddef>
#include <optional>

#include "scene/frame_state.h"
#include "timeline/curve.h"
#include "timeline/value_reader.h"

namespace dapple::timeline {

/// Reads `{keys: [{frame: 1, value: 10 deg}, {time: 2 s, value: 20 deg}], interpolation: linear}`. A key
/// takes `interpolation` of its own, for the way to the next key, and the handles `out` and `in` of bezier
/// segments. Frames are absolute, seconds count from the first frame of `clip`. Nothing where faults were
/// reported.
std::optional<Curve> read_curve(const Source& source, std::size_t components, const scene::Clip& clip);

}  // namespace dapple::timeline
