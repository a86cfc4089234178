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
    std::unique_ptr<const LinearWaves> waves;  ///< none of a mesh_sequence
    double choppiness = 0;
};

WaterSurface::WaterSurface(const scene::Water& water) : state_(std::make_unique<State>()) {
    state_->water = water;
    if (water.surface.type == WaterSurfaceType::mesh_sequence) {
        state_->size.cells_x = state_->size.cells_z = 0;
        return;
    }
    if (has_rings(water)) {
        state_->rings.emplace(water);
        state_->size.cells_x = state_->size.cells_z = 0;
    } else {
        state_->size = grid_size(water);
    }
    if (water.surface.type == WaterSurfaceType::waves) {
        state_->waves = std::make_unique<WaveSum>(water.surface.waves);
    } else if (is_flat(water.surface)) {
        state_->waves = std::make_unique<WaveSum>(scene::Waves{});
    } else {
        state_->waves = std::make_unique<SpectrumSea>(water);
        state_->choppiness = water.surface.spectrum.choppiness;
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
                s.choppiness, s.cutoff_length, s.period, s.amplitude_scale, s.loop, s.seed);
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

    const double choppiness = state_->choppiness;
    scene::WaterMesh mesh =
        state_->rings ? ring_mesh(*state_->rings, *state_->waves, choppiness, time, viewpoint)
                      : grid_mesh(state_->water.extent, grid(time, mesh_fields(choppiness)), choppiness);
    // The sums of a height and of the bound are rounded in different orders.
    constexpr double rounding = 1 + 1e-12;
    const double amplitudes = rounding * state_->waves->amplitude_sum();
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
    assert(state_->waves && !state_->rings);
    const glm::ivec2 cells(state_->size.cells_x, state_->size.cells_z);
    return state_->waves->grid(Lattice::whole(state_->water.extent, cells), time, fields, {});
}

SurfaceSample WaterSurface::sample(double x, double z, double time) const {
    assert(state_->waves);
    return state_->waves->sample(x, z, time);
}

GridSize WaterSurface::size() const {
    return state_->size;
}

MeshCounts mesh_counts(const scene::Water& water) {
    if (water.surface.type == WaterSurfaceType::mesh_sequence) return {};
    MeshCounts counts;
    glm::ivec2 cells;
    if (has_rings(water)) {
        const RingLayout rings(water);
        counts = rings.most();
        cells = rings.lattice_cells(0);
    } else {
        const GridSize size = grid_size(water);
        counts = {size.vertices(), size.triangles()};
        cells = {size.cells_x, size.cells_z};
    }
    if (water.surface.type == WaterSurfaceType::spectrum && !is_flat(water.surface)) {
        const FieldMask fields = mesh_fields(water.surface.spectrum.choppiness);
        counts.spectrum_bytes =
            static_cast<std::size_t>(SpectrumSea::making_bytes(water, cells / periods_across(water), fields));
    }
    return counts;
}

}  // namespace dapple::ocean
