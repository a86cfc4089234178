#include "scene/water_surface.h"

#include <algorithm>
#include <cmath>

#include "base/number_pattern.h"

namespace dapple::scene {

std::int64_t file_number(const MeshSequence& sequence, double time) {
    // A frame that falls on a file's beginning must not miss it by the rounding of frame / fps * fps.
    constexpr double kRounding = 1e-6;  // files
    const double files = std::floor(time * sequence.fps + kRounding);
    const auto span = static_cast<double>(sequence.last_file - sequence.first_file);
    return sequence.first_file + static_cast<std::int64_t>(std::clamp(files, 0.0, span));
}

std::string file_path(const MeshSequence& sequence, std::int64_t number) {
    return with_number(sequence.pattern, find_number(sequence.pattern), number);
}

}  // namespace dapple::scene
