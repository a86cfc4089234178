#pragma once
#include <glm/glm.hpp>

#include "scene/frame_state.h"

namespace dapple::ocean {

/// Coordinate of grid line `index` of `cells` cells across [center - size / 2, center + size / 2]; the ends
/// are exact, and a line has the same coordinate in all grids that share it and differ by powers of two.
inline double grid_coordinate(double center, double size, int index, int cells) {
    return center + size * (static_cast<double>(index) / cells - 0.5);
}

/// A rectangle of cells of a lattice, from the grid lines `lower` to `upper`, x and z.
struct CellBox {
    glm::ivec2 lower{0, 0};
    glm::ivec2 upper{0, 0};

    bool empty() const { return upper.x <= lower.x || upper.y <= lower.y; }
    glm::ivec2 cells() const { return upper - lower; }
    /// Among the box's vertices, those on its edge too; an empty box has none.
    bool holds(glm::ivec2 vertex) const {
        return !empty() && vertex.x >= lower.x && vertex.x <= upper.x && vertex.y >= lower.y &&
               vertex.y <= upper.y;
    }
};

/// Vertices of a regular lattice over an extent that something is wanted at: those of `box` that `hole` does
/// not hold.
struct Lattice {
    scene::Extent extent;
    glm::ivec2 cells{1, 1};  ///< across the whole extent
    CellBox box;
    CellBox hole{};

    static Lattice whole(const scene::Extent& extent, glm::ivec2 cells) {
        return {extent, cells, {{0, 0}, cells}, {}};
    }
    int rows() const { return box.cells().y + 1; }
    int columns() const { return box.cells().x + 1; }
    double x(int column) const {
        return grid_coordinate(extent.center.x, extent.size.x, box.lower.x + column, cells.x);
    }
    double z(int row) const {
        return grid_coordinate(extent.center.y, extent.size.y, box.lower.y + row, cells.y);
    }
    /// Calls body(first, end) for each run of columns of a row that is wanted.
    template <class Body>
    void for_runs(int row, const Body& body) const {
        const int line = box.lower.y + row;
        if (hole.empty() || line < hole.lower.y || line > hole.upper.y) {
            body(0, columns());
            return;
        }
        if (hole.lower.x > box.lower.x) body(0, hole.lower.x - box.lower.x);
        if (hole.upper.x < box.upper.x) body(hole.upper.x + 1 - box.lower.x, columns());
    }
};

}  // namespace dapple::ocean
