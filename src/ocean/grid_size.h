#pragma once
#include <cstddef>
#include <glm/glm.hpp>

#include "scene/frame_state.h"

namespace dapple::ocean {

/// Largest number of triangles of a mesh whose resolution is not given.
constexpr double kDefaultTriangleCap = 2.1e6;
constexpr double kDefaultCellsPerWave = 25;
/// Largest number of triangles altogether; a mesh_cells beyond it is refused.
constexpr double kTriangleLimit = 1e8;

/// The regular grid of a computed surface.
struct GridSize {
    int cells_x = 2;
    int cells_z = 2;
    double shortest_wave = 0;            ///< m; 0: flat
    double cells_per_shortest_wave = 0;  ///< along the coarser axis; 0: flat
    bool capped = false;                 ///< fewer cells than the default asks for, to keep to the cap
    std::size_t vertices() const {
        return (static_cast<std::size_t>(cells_x) + 1) * (static_cast<std::size_t>(cells_z) + 1);
    }
    std::size_t triangles() const {
        return 2 * static_cast<std::size_t>(cells_x) * static_cast<std::size_t>(cells_z);
    }
};

/// Sizes of a mesh.
struct MeshCounts {
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    /// While a spectrum is evaluated: its modes and a tile of the sea, beside the fields of the vertices.
    std::size_t spectrum_bytes = 0;
};

/// Whether the surface is `waves` or `spectrum` without any amplitude: exactly flat, whatever the mesh.
bool is_flat(const scene::WaterSurface& surface);

/// Whether the mesh is nested rings about the camera (ocean/rings.h) rather than a regular grid.
inline bool has_rings(const scene::Water& water) {
    return water.rings.inner_size > 0 && water.surface.type != scene::WaterSurfaceType::mesh_sequence;
}

/// Periods of a spectrum along x and z of the extent: the whole numbers nearest to what `period` asks for,
/// one at least; 1 of all other surfaces. Error(timeline_invalid) for more than 2^30.
glm::ivec2 periods_across(const scene::Water& water);

/// m, of `waves` (one at least) and `spectrum`, whatever their amplitudes.
double shortest_wave(const scene::WaterSurface& surface);

/// Cells of the regular grid of `waves` and `spectrum` (a mesh_sequence brings its own mesh): `mesh_cells`
/// along x and as many along z as make square cells, or 25 cells a shortest wave under a cap of 2.1 million
/// triangles; waves count whatever their amplitude, so that a keyed amplitude leaves the mesh alone. Flat
/// water has 2 by 2 cells. Of a spectrum each period has cells of the form 2^a 3^b 5^c, for the FFT: rounded
/// up, or down where the cap would be passed. Error(timeline_invalid) beyond kTriangleLimit.
GridSize grid_size(const scene::Water& water);

/// The smallest number >= n, or the largest <= n, of the form 2^a 3^b 5^c; n >= 1.
int smooth_size_up(int n);
int smooth_size_down(int n);

}  // namespace dapple::ocean
