#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "base/large_vector.h"

namespace dapple::view {

/// The pieces of the camera paths of one receiver layer that lie in a medium that scatters. A piece is
/// straight, between two specular events, on one side of the water. Pieces of pixel i are [first[i],
/// first[i + 1]), in the order of the path. Positions are m, relative to FrameScene::origin.
struct SegmentLayer {
    int width = 0;
    int height = 0;
    int sample = 0;
    int branch = 0;
    std::vector<std::uint32_t> first;  ///< width * height + 1 entries

    LargeVector<glm::vec3> origin;     ///< the end nearer to the camera
    LargeVector<glm::vec3> direction;  ///< unit, away from the camera
    LargeVector<float> length;         ///< m, finite: cut where nothing beyond it could be seen
    LargeVector<std::uint8_t> in_water;
    LargeVector<std::uint8_t> primary;  ///< 1 where nothing specular lies between the camera and the piece
    /// Of the path from the pixel to the near end: Fresnel, mirrors, extinction, n^2. What a pixel receives
    /// from the piece is throughput times S.
    LargeVector<glm::vec3> throughput;
    /// d(point at distance s)/d(pixel x) = spread_u_origin + s * spread_u_direction; v: a pixel down.
    LargeVector<glm::vec3> spread_u_origin, spread_u_direction, spread_v_origin, spread_v_direction;
    std::size_t segments() const { return origin.size(); }
};

}  // namespace dapple::view
