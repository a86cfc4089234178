#include "rays/water_grid.h"

#include <algorithm>
#include <atomic>

#include "base/parallel.h"

namespace dapple::rays {
namespace {

constexpr int kPatchCells = 32;

int patches_along(int vertices) {
    return (vertices - 1 + kPatchCells - 1) / kPatchCells;
}

/// Corner of the mesh's cell at `first` (row 0, column 0) that a vertex is, or -1.
int corner_of(std::size_t vertex, std::size_t first, std::size_t columns) {
    const std::array<std::size_t, 4> corners{first, first + 1, first + columns + 1, first + columns};
    const auto* found = std::find(corners.begin(), corners.end(), vertex);
    return found == corners.end() ? -1 : static_cast<int>(found - corners.begin());
}

}  // namespace

std::optional<WaterGrid> WaterGrid::make(const scene::WaterMesh& water) {
    WaterGrid grid;
    grid.rows_ = water.rows;
    grid.columns_ = water.columns;
    if (water.rows < 2 || water.columns < 2) return std::nullopt;
    const auto rows = static_cast<std::size_t>(water.rows);
    const auto columns = static_cast<std::size_t>(water.columns);
    const std::size_t cells = (rows - 1) * (columns - 1);
    const auto& triangles = water.mesh.triangles;
    if (water.mesh.positions.size() != rows * columns || triangles.size() != 2 * cells) return std::nullopt;

    for (std::size_t t = 0; t < 2; ++t) {
        for (int v = 0; v < 3; ++v) {
            const int corner = corner_of(triangles[t][v], 0, columns);
            if (corner < 0) return std::nullopt;
            grid.corners_[t][static_cast<std::size_t>(v)] = corner;
        }
    }
    std::atomic<bool> alike = true;
    parallel_for(rows - 1, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t cell = begin * (columns - 1); cell < end * (columns - 1); ++cell) {
            const auto shift = static_cast<glm::uint>(cell / (columns - 1) * columns + cell % (columns - 1));
            if (triangles[2 * cell] != triangles[0] + shift ||
                triangles[2 * cell + 1] != triangles[1] + shift) {
                alike = false;
                return;
            }
        }
    });
    if (!alike) return std::nullopt;

    // Embree's triangles are the corners 0, 1, 3 and 2, 3, 1: each lacks one of 2 and 0, or, with the columns
    // reversed, of 3 and 1.
    const auto lacks = [&](std::size_t t, int corner) {
        return std::find(grid.corners_[t].begin(), grid.corners_[t].end(), corner) == grid.corners_[t].end();
    };
    if ((lacks(0, 1) && lacks(1, 3)) || (lacks(0, 3) && lacks(1, 1))) {
        grid.reversed_ = true;
        for (auto& triangle : grid.corners_) {
            for (int& corner : triangle) corner ^= 1;  // 0 <-> 1, 2 <-> 3
        }
    } else if (!((lacks(0, 2) && lacks(1, 0)) || (lacks(0, 0) && lacks(1, 2)))) {
        return std::nullopt;
    }
    return grid;
}

std::size_t WaterGrid::vertex(std::size_t index) const {
    if (!reversed_) return index;
    const auto columns = static_cast<std::size_t>(columns_);
    return index + columns - 1 - 2 * (index % columns);
}

RTCGeometry WaterGrid::make_geometry(RTCDevice device, glm::vec3*& vertices) const {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), this->vertices()));
    const int across = patches_along(columns_);
    const int down = patches_along(rows_);
    auto* patches = static_cast<RTCGrid*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid),
                                static_cast<std::size_t>(across) * static_cast<std::size_t>(down)));
    if (patches == nullptr) return geometry;
    for (int j = 0; j < down; ++j) {
        for (int i = 0; i < across; ++i) {
            const int row = j * kPatchCells;
            const int column = i * kPatchCells;
            *patches++ = {static_cast<unsigned>(row * columns_ + column), static_cast<unsigned>(columns_),
                          static_cast<unsigned short>(std::min(kPatchCells, columns_ - 1 - column) + 1),
                          static_cast<unsigned short>(std::min(kPatchCells, rows_ - 1 - row) + 1)};
        }
    }
    return geometry;
}

void WaterGrid::resolve(Hit& hit) const {
    const int across = patches_along(columns_);
    const int column = static_cast<int>(hit.primitive) % across * kPatchCells;
    const int row = static_cast<int>(hit.primitive) / across * kPatchCells;
    const int width = std::min(kPatchCells, columns_ - 1 - column);
    const int height = std::min(kPatchCells, rows_ - 1 - row);
    const glm::vec2 place(hit.barycentric.x * static_cast<float>(width),
                          hit.barycentric.y * static_cast<float>(height));
    const int x = std::clamp(static_cast<int>(place.x), 0, width - 1);
    const int y = std::clamp(static_cast<int>(place.y), 0, height - 1);
    const float u = place.x - static_cast<float>(x);
    const float v = place.y - static_cast<float>(y);

    const bool lower = u + v <= 1;  // the triangle of the corners 0, 1, 3
    const std::array<float, 4> weight =
        lower ? std::array{1 - u - v, u, 0.0f, v} : std::array{0.0f, 1 - v, u + v - 1, 1 - u};
    const int missing = lower ? 2 : 0;
    const bool second = std::find(corners_[0].begin(), corners_[0].end(), missing) != corners_[0].end();
    const auto& triangle = corners_[second ? 1 : 0];
    const int mesh_column = reversed_ ? columns_ - 2 - (column + x) : column + x;
    const int cell = (row + y) * (columns_ - 1) + mesh_column;
    hit.primitive = 2 * static_cast<std::uint32_t>(cell) + (second ? 1 : 0);
    hit.barycentric = {weight[static_cast<std::size_t>(triangle[1])],
                       weight[static_cast<std::size_t>(triangle[2])]};
    // Embree's normal is that of corners 0, 1, 3; the mesh may go round the other way.
    const auto next = [&](int corner) {
        const auto* at = std::find(triangle.begin(), triangle.end(), corner);
        return triangle[static_cast<std::size_t>((at - triangle.begin() + 1) % 3)];
    };
    const bool same_way = lower ? next(1) == 3 : next(3) == 1;
    if (!same_way) hit.normal = -hit.normal;
}

}  // namespace dapple::rays
