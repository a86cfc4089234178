#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "render/light_quadrature.h"

namespace dapple::render {

/// What media take of light on its way to a segment, by its optical depth at few places: the ends of parts of
/// equal light, then midway wherever that shows the depth not to be linear between, as far as it counts.
class WayDepths {
public:
    /// Multiplies shares, in their order along the segment, by what the ways to their middles leave.
    void dim(const LightOnSegment& light, std::span<LightShare> shares);

private:
    struct Node {
        double place;      ///< m along the segment
        glm::dvec3 depth;  ///< of the light's way there, a channel
    };
    static Node node(const LightOnSegment& light, double place);
    void start(const LightOnSegment& light, std::span<const LightShare> shares);
    void refine(const LightOnSegment& light, std::span<const LightShare> shares, const Node& begin,
                const Node& end, int level);

    std::vector<Node> coarse_, nodes_;
    glm::dvec3 left_{0};  ///< W/m^2/sr, about: of all shares
};

}  // namespace dapple::render
