#pragma once
#include <glm/glm.hpp>

#include "ocean/grid_size.h"
#include "ocean/lattice.h"
#include "ocean/linear_waves.h"
#include "scene/frame_state.h"

namespace dapple::ocean {

/// Fewest cells along a wave in a ring that has it.
constexpr double kLeastCellsPerWave = 4;

/// Nested rings of cells about a viewpoint, as geometry clipmaps have them (Losasso and Hoppe 2004): level 0
/// is a square of `cells` by `cells`, each further level is a square twice as wide with cells twice as wide
/// and a hole where the one inside it lies, and the last covers what is left of the extent. The cells of all
/// levels belong to lattices that divide the extent, each level's every second line is one of the next, and
/// every level ends at lines of the next: so vertices stay where they are while the viewpoint moves, and only
/// come and go. `cells` is the timeline's, rounded up to a multiple of 4.
///
/// Of a spectrum the cells of each level that has waves divide the sea's period: of all layouts with cells as
/// small and rings as wide as asked for, or smaller and wider, it is the one of fewest triangles.
///
/// Towards its outer edge a level morphs: what lies between the vertices of the next level is moved onto that
/// level's triangles, by a weight that is a continuous function of the place relative to the viewpoint, 0
/// until 3/4 of the way to the edge and 1 over the last cells, which may come and go. By the same weight the
/// waves go that the next level has fewer than 4 cells for (the finest level has all waves).
class RingLayout {
public:
    /// `water.rings.inner_size` is above 0. Error(timeline_invalid) beyond kTriangleLimit, and for a period
    /// of more than 2^24 of the finest cells.
    explicit RingLayout(const scene::Water& water);

    int levels() const { return levels_; }
    /// Cells across a level, its hole included; the last level has others.
    int across() const { return across_; }
    /// Cells of a level's lattice across the extent.
    glm::ivec2 lattice_cells(int level) const;
    /// m, sides of a level's cells.
    glm::dvec2 cell(int level) const;
    /// What a level and those inside it cover, in the level's lattice.
    CellBox box(int level, glm::dvec2 viewpoint) const;
    /// The level's vertices that no finer level has. The vertices along its hole belong to that.
    Lattice lattice(int level, glm::dvec2 viewpoint) const;
    /// Weight in [0, 1] of the next level's surface, at a place relative to the viewpoint (x, z).
    double morph(int level, glm::dvec2 offset) const;
    /// Waves that this level is the last to have.
    WaveLengths last_waves(int level) const;
    /// Waves that further levels have too.
    WaveLengths lasting_waves(int level) const;
    /// No viewpoint makes more.
    MeshCounts most() const;

private:
    void fit_periods(double inner);

    scene::Extent extent_;
    glm::ivec2 periods_{1, 1};  ///< of a spectrum, across the extent
    int levels_ = 1;
    int across_ = 0;
    glm::ivec2 coarsest_{1, 1};  ///< cells of the last level across the extent
};

}  // namespace dapple::ocean
