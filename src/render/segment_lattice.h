#pragma once
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "view/segment_layer.h"

namespace dapple::render {

/// What media scatter on each segment of a layer towards its near end, W/m^2/sr.
struct SegmentRadiance {
    std::vector<glm::vec3> direct;    ///< of light that met nothing before
    std::vector<glm::vec3> caustics;  ///< S of the method
};
using AskSegments = std::function<SegmentRadiance(const view::SegmentLayer&)>;

/// Segments lie between those of their neighbors where both ends are nearer than this share of their length
/// to the mean of the neighbors' ends.
constexpr float kBetween = 0.01f;

/// Pixels (1: yes) that are asked for themselves at half resolution: those of even x and y, and those whose
/// segments do not all lie between those of the two or four such pixels about them (kBetween; as many, on
/// the same sides of the water).
std::vector<std::uint8_t> half_resolution_pixels(const view::SegmentLayer& segments);

/// The layer less the segments of pixels that are 0 in `kept`.
view::SegmentLayer segments_of(const view::SegmentLayer& segments, const std::vector<std::uint8_t>& kept);

/// Asks for the segments of half_resolution_pixels() and gives all others the mean of their neighbors'.
SegmentRadiance at_half_resolution(const view::SegmentLayer& segments, const AskSegments& ask);

}  // namespace dapple::render
