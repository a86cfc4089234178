#include "ocean/water_surface.h"

#include <cassert>
#include <cmath>
#include <optional>
#include <sstream>

#include "base/error.h"
#include "ocean/grid_mesh.h"
#include "ocean/mesh_sequence.h"
#include "ocean/rings.h"
#include "ocean/spectrum_sea.h"
#include "ocean/wave_sum.h"

namespace dapple::ocean {

using scene::WaterSurfaceType;

struct WaterSurface::State {
    scene::Water water;
    GridSize size;
    std::optional<RingLayout> rings;
    std::optional<WaveSum> waves;  ///< also flat water of any type
    std::optional<SpectrumSea> spectrum;
};

WaterSurface::WaterSurface(const scene::Water& water) : state_(std::make_unique<State>()) {
    state_->water = water;
    if (water.surface.type == WaterSurfaceType::mesh_sequence) {
        state_->size.cells_x = state_->size.cells_z = 0;
        return;
    }
    const bool flat = is_flat(water.surface);
    if (has_rings(water)) {
        if (water.surface.type == WaterSurfaceType::spectrum && !flat)
            throw Error(ExitCode::timeline_invalid, "water.rings: serve a surface of type waves only");
        state_->rings.emplace(water);
        state_->size.cells_x = state_->size.cells_z = 0;
    } else {
        state_->size = grid_size(water);
    }
    if (water.surface.type == WaterSurfaceType::spectrum && !flat) {
        state_->spectrum.emplace(water, state_->size);
    } else {
        if (water.surface.type == WaterSurfaceType::spectrum) state_->water.surface = {};
        state_->waves.emplace(state_->water.surface.waves);
    }
}

WaterSurface::~WaterSurface() = default;
WaterSurface::WaterSurface(WaterSurface&&) noexcept = default;
WaterSurface& WaterSurface::operator=(WaterSurface&&) noexcept = default;

std::string WaterSurface::key(const scene::Water& water) {
    std::ostringstream text;
    text << std::hexfloat;
    const auto put = [&](auto... values) { ((text << values << ' '), ...); };
    const scene::WaterSurface& surface = water.surface;
    put(water.extent.center.x, water.extent.center.y, water.extent.size.x, water.extent.size.y,
        water.mesh_cells, water.rings.inner_size, water.rings.cells);
    switch (surface.type) {
        case WaterSurfaceType::waves:
            put("waves", surface.waves.depth);
            for (const scene::Wave& w : surface.waves.waves) put(w.length, w.heading, w.amplitude, w.phase);
            break;
        case WaterSurfaceType::spectrum: {
            const scene::Spectrum& s = surface.spectrum;
            put("spectrum", s.wind_speed, s.wind_heading, s.fetch, s.depth, s.peak_enhancement, s.spreading,
                s.choppiness, s.cutoff_length, s.amplitude_scale, s.loop, s.seed);
            break;
        }
        case WaterSurfaceType::mesh_sequence: {
            const scene::MeshSequence& s = surface.mesh_sequence;
            put("mesh_sequence", s.first_file, s.last_file, s.fps, static_cast<int>(s.up), s.scale,
                s.offset.x, s.offset.y, s.offset.z, static_cast<int>(s.missing), s.pattern);
            break;
        }
    }
    return text.str();
}

scene::WaterMesh WaterSurface::mesh(double time, glm::dvec2 viewpoint) const {
    const scene::WaterSurface& surface = state_->water.surface;
    if (surface.type == WaterSurfaceType::mesh_sequence) return sequence_mesh(surface.mesh_sequence, time);

    const double choppiness = state_->spectrum ? surface.spectrum.choppiness : 0;
    scene::WaterMesh mesh =
        state_->rings ? ring_mesh(*state_->rings, *state_->waves, time, viewpoint)
                      : grid_mesh(state_->water.extent,
                                  grid(time, choppiness != 0 ? kChoppyMeshFields : kMeshFields), choppiness);
    // The sums of a height and of the bound are rounded in different orders.
    constexpr double rounding = 1 + 1e-12;
    const double amplitudes =
        rounding * (state_->spectrum ? state_->spectrum->amplitude_sum() : state_->waves->amplitude_sum());
    mesh.height_bound = amplitudes;
    mesh.displacement_bound = std::abs(choppiness) * amplitudes;
    if (state_->rings) {
        mesh.shortest_wave = is_flat(surface) ? 0 : shortest_wave(surface);
        mesh.cells_per_shortest_wave = mesh.shortest_wave / mesh.rings.front().cell;
    } else {
        mesh.shortest_wave = state_->size.shortest_wave;
        mesh.cells_per_shortest_wave = state_->size.cells_per_shortest_wave;
        mesh.capped = state_->size.capped;
    }
    return mesh;
}

SurfaceGrid WaterSurface::grid(double time, FieldMask fields) const {
    assert((state_->waves || state_->spectrum) && !state_->rings);
    if (state_->spectrum) return state_->spectrum->grid(time, fields);
    const glm::ivec2 cells(state_->size.cells_x, state_->size.cells_z);
    return state_->waves->grid(Lattice::whole(state_->water.extent, cells), time, fields);
}

SurfaceSample WaterSurface::sample(double x, double z, double time) const {
    assert(state_->waves || state_->spectrum);
    return state_->spectrum ? state_->spectrum->sample(x, z, time) : state_->waves->sample(x, z, time);
}

GridSize WaterSurface::size() const {
    return state_->size;
}

MeshCounts mesh_counts(const scene::Water& water) {
    if (water.surface.type == WaterSurfaceType::mesh_sequence) return {};
    if (has_rings(water)) return RingLayout(water).most();
    const GridSize size = grid_size(water);
    return {size.vertices(), size.triangles()};
}

}  // namespace dapple::ocean
