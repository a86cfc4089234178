#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace dapple::media {

/// A line in some affine space: origin + t * direction, t in metres of the world.
struct Line {
    glm::dvec3 origin{0};
    glm::dvec3 direction{0};
    glm::dvec3 at(double t) const { return origin + t * direction; }
};

/// Part of a line; empty where end <= begin.
struct Interval {
    double begin = 0;
    double end = 0;
    bool empty() const { return !(end > begin); }
};

/// The part of `whole` in which the line is between `low` and `high`, faces included.
inline Interval inside_box(const Line& line, const glm::dvec3& low, const glm::dvec3& high, Interval whole) {
    for (int axis = 0; axis < 3; ++axis) {
        const double o = line.origin[axis], d = line.direction[axis];
        if (d == 0) {
            if (!(o >= low[axis] && o <= high[axis])) return {};
            continue;
        }
        const double to_low = (low[axis] - o) / d, to_high = (high[axis] - o) / d;
        const double enters = std::min(to_low, to_high), leaves = std::max(to_low, to_high);
        if (!(enters <= leaves)) return {};  // not a number
        whole.begin = std::max(whole.begin, enters);
        whole.end = std::min(whole.end, leaves);
    }
    return whole;
}

}  // namespace dapple::media
