#pragma once
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>

#include "ocean/surface_grid.h"
#include "scene/frame_state.h"
#include "scene/mesh.h"

namespace dapple::ocean {

/// Positions, normals and triangles of a regular grid over an extent, from height and slope, and with
/// choppiness > 0 from displacement and its gradient too. Normals are those of the surface, not of the
/// triangles. All cells are split by the diagonal from (column, row + 1) to (column + 1, row). Fills in the
/// largest height and displacement of this mesh and its vertices that have folded over; bounds are left to
/// the caller.
scene::WaterMesh grid_mesh(const scene::Extent& extent, const SurfaceGrid& grid, double choppiness);

/// A vertex of a mesh of water.
struct WaterVertex {
    glm::dvec3 position{0, 0, 0};
    glm::dvec3 normal{0, 1, 0};
    double displacement_squared = 0;  ///< m^2, horizontal
    bool folded = false;
};

/// The vertex over (x, z) from the fields of kMeshFields, or kChoppyMeshFields where choppiness is not 0, by
/// `field(Field)`.
template <class Fields>
WaterVertex water_vertex(double x, double z, const Fields& field, double choppiness) {
    WaterVertex vertex;
    vertex.position = {x, field(Field::height), z};
    const double slope_x = field(Field::slope_x), slope_z = field(Field::slope_z);
    glm::dvec3 normal(-slope_x, 1, -slope_z);
    if (choppiness != 0) {
        const double dx = choppiness * field(Field::displacement_x);
        const double dz = choppiness * field(Field::displacement_z);
        vertex.position.x += dx;
        vertex.position.z += dz;
        const double xx = choppiness * field(Field::displacement_xx);
        const double xz = choppiness * field(Field::displacement_xz);
        const double zz = choppiness * field(Field::displacement_zz);
        normal = glm::cross(glm::dvec3(xz, slope_z, 1 + zz), glm::dvec3(1 + xx, slope_x, xz));
        vertex.displacement_squared = dx * dx + dz * dz;
        // normal.y is the Jacobian of the horizontal map.
        vertex.folded = !(normal.y > 0);
    }
    vertex.normal = normal * (1 / std::sqrt(glm::dot(normal, normal)));
    return vertex;
}

/// What is summed up of the vertices of a mesh.
struct WaterExtremes {
    double height = 0;
    double displacement_squared = 0;
    std::size_t folded = 0;

    void add(const WaterVertex& vertex);
    void add(const WaterExtremes& others);
    void put(scene::WaterMesh& water) const;
};

/// What grid_mesh needs.
constexpr FieldMask kMeshFields = kHeight | kSlope;
constexpr FieldMask kChoppyMeshFields = kMeshFields | kDisplacement | kDisplacementGradient;
constexpr FieldMask mesh_fields(double choppiness) {
    return choppiness != 0 ? kChoppyMeshFields : kMeshFields;
}

}  // namespace dapple::ocean
