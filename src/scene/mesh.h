#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace dapple::scene {

/// An indexed triangle mesh, in double until its user makes it relative to an origin.
struct TriangleMesh {
    std::vector<glm::dvec3> positions;  ///< m
    std::vector<glm::dvec3> normals;    ///< unit, a vertex; empty: none given
    std::vector<glm::dvec2> uv;         ///< a vertex; empty: none given
    std::vector<glm::uvec3> triangles;  ///< counter-clockwise seen from outside
};

/// One ring of a mesh of nested rings.
struct WaterRing {
    double cell = 0;  ///< m, side of its cells, the longer one
    double size = 0;  ///< m, side of the square that it ends with
    /// Of the mean-square slope of all waves: what those have that are left out from there outwards.
    double slope_left_out = 0;
};

/// The water surface at one instant: a height field or a choppy or read mesh. Normals point to the air.
struct WaterMesh {
    TriangleMesh mesh;  ///< world space; triangles counter-clockwise seen from the air; normals always given
    /// Vertices of a regular grid, row-major (index = row * columns + column), rows along z; 0: not a grid.
    int rows = 0;
    int columns = 0;
    std::vector<WaterRing> rings;  ///< the innermost first; empty: none
    /// Whether the triangles are one height field without gaps, so that all parts that hide another face away
    /// somewhere. Of grids it is taken for granted.
    bool one_sheet = false;
    /// Heights never leave [-height_bound, height_bound], in all frames of the clip where that is known; m.
    double height_bound = 0;
    /// Largest horizontal displacement of a vertex off its grid point; m.
    double displacement_bound = 0;
    /// The largest |y| and the largest horizontal displacement of this very mesh; m. Far below the bounds for
    /// a spectrum, whose bounds are sums of all amplitudes: what covers one frame is sized by these.
    double largest_height = 0;
    double largest_displacement = 0;
    /// Vertices at which a choppy or read surface has folded over itself: their normals do not point up.
    std::size_t folded_vertices = 0;
    /// Shortest wave that the surface was asked for and the cells a shortest wave that the mesh has; 0:
    /// unknown.
    double shortest_wave = 0;
    double cells_per_shortest_wave = 0;
    /// m, in the world: step between neighbouring floats at the outermost vertex of a read mesh, all of whose
    /// coordinates are floats; 0: computed, or given with more digits.
    double float_step = 0;
    double mean_edge = 0;  ///< m, of the cells of a read mesh as if they were square; 0: computed
    bool capped = false;   ///< fewer cells than asked for, to keep to the cap of triangles
};

}  // namespace dapple::scene
