#pragma once
#include <glm/glm.hpp>

#include "ocean/grid_size.h"
#include "ocean/surface_grid.h"
#include "scene/mesh.h"

namespace dapple::ocean {

/// Coordinate of grid line `index` of `cells` cells across [center - size / 2, center + size / 2]; the ends
/// are exact.
inline double grid_coordinate(double center, double size, int index, int cells) {
    return center + size * (static_cast<double>(index) / cells - 0.5);
}

/// Positions, normals and triangles of a regular grid over an extent, from height and slope, and with
/// choppiness > 0 from displacement and its gradient too. Normals are those of the surface, not of the
/// triangles. All cells are split by the diagonal from (column, row + 1) to (column + 1, row). Fills in the
/// largest height and displacement of this mesh and its vertices that have folded over; bounds are left to
/// the caller.
scene::WaterMesh grid_mesh(const scene::Extent& extent, const SurfaceGrid& grid, double choppiness);

/// What grid_mesh needs.
constexpr FieldMask kMeshFields = kHeight | kSlope;
constexpr FieldMask kChoppyMeshFields = kMeshFields | kDisplacement | kDisplacementGradient;

}  // namespace dapple::ocean
