#include "judge/text.h"

#include <cstdio>

#include "base/frame_set.h"

namespace dapple::judge {

std::string formatted(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string percent(double share) {
    return formatted("%.2f", 100 * share);
}

std::string frames_text(const std::vector<std::int64_t>& frames) {
    std::string list;
    for (const std::int64_t frame : frames) list += (list.empty() ? "" : ",") + std::to_string(frame);
    return to_string(FrameSet::parse(list));
}

}  // namespace dapple::judge
