#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "light/water_beams.h"
#include "methods/sliced_beams/beam_pyramid.h"

namespace dapple::methods::sliced_beams {

constexpr std::uint32_t kNoVertex = 0xffffffffu;

/// What lies across the edge from corner k to corner k + 1 of a triangle.
struct Neighbor {
    std::uint32_t triangle = kNoBeam;
    std::uint32_t vertex = kNoVertex;  ///< its corner that is not on the edge
};

/// Triangles that share edges: by arithmetic in a grid (two triangles a cell, as ocean/ makes them), by a
/// table in an indexed mesh.
class BeamNeighbors {
public:
    BeamNeighbors(int rows, int columns, std::span<const glm::uvec3> triangles);
    Neighbor across(std::uint32_t triangle, int edge) const {
        return rows_ > 0 ? across_in_grid(triangle, edge)
                         : table_[std::size_t{3} * triangle + static_cast<std::size_t>(edge)];
    }

private:
    Neighbor across_in_grid(std::uint32_t triangle, int edge) const;

    std::int64_t rows_, columns_;  ///< of vertices
    std::vector<Neighbor> table_;
};

}  // namespace dapple::methods::sliced_beams
