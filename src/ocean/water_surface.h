#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <string>

#include "ocean/grid_size.h"
#include "ocean/surface_grid.h"
#include "scene/frame_state.h"
#include "scene/mesh.h"

namespace dapple::ocean {

/// The water of a frame as a mesh. Holds what does not depend on time (modes of the spectrum, tables of the
/// waves), so it is worth keeping while key() stays the same. All functions are const, thread-safe and run on
/// parallel_for; the bits of their results do not depend on the number of threads.
class WaterSurface {
public:
    /// Error(timeline_invalid) for a spectrum of too many modes, a mesh of too many triangles, a tile of a
    /// spectrum of too many points.
    explicit WaterSurface(const scene::Water& water);
    ~WaterSurface();
    WaterSurface(WaterSurface&&) noexcept;
    WaterSurface& operator=(WaterSurface&&) noexcept;

    /// Everything of `water` that shapes the surface and its mesh, as text: equal keys, equal meshes.
    static std::string key(const scene::Water& water);

    /// All fields of WaterMesh. Height bounds hold at all times for waves and spectrum (sums of amplitudes, a
    /// little rounding added) and for the file at hand for a mesh_sequence. Error(input_unreadable) for files
    /// of a mesh_sequence.
    /// Rings lie about the camera's place on the rest plane, `viewpoint` (x, z); nothing else asks for it.
    scene::WaterMesh mesh(double time, glm::dvec2 viewpoint = {0, 0}) const;

    /// The two below are for `waves` and `spectrum` only (asserted); both are before horizontal displacement.
    /// The first is of the regular grid, for water without rings.
    SurfaceGrid grid(double time, FieldMask fields) const;
    /// The exact sum at one point, m and s. A spectrum takes time in proportion to its modes.
    SurfaceSample sample(double x, double z, double time) const;

    /// Of the computed mesh; a mesh_sequence has none (0 cells), nor have rings.
    GridSize size() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Of the computed mesh: what it has, or with rings the most that a place of the camera makes; none for a
/// mesh_sequence.
MeshCounts mesh_counts(const scene::Water& water);

}  // namespace dapple::ocean
