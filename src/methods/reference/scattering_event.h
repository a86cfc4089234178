#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace dapple::reference {

/// Light scattered at one place towards the near end of one camera segment, if nothing is between.
struct ScatteringEvent {
    glm::dvec3 position{0};  ///< m, relative to the origin
    glm::dvec3 near_end{0};  ///< m, the same
    glm::dvec3 radiance{0};  ///< W/m^2/sr, what it adds to the mean S of the segment
    std::uint32_t segment = 0;
    bool in_water = false;
    bool may_cross_water = false;  ///< waves may lie between
    double slack = 0;              ///< m before the near end within which nothing hides it
};

}  // namespace dapple::reference
