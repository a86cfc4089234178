#include "ocean/water_surface.h"

#include <cassert>
#include <cmath>
#include <optional>
#include <sstream>

#include "ocean/grid_mesh.h"
#include "ocean/mesh_sequence.h"
#include "ocean/spectrum_sea.h"
#include "ocean/wave_sum.h"

namespace dapple::ocean {

using scene::WaterSurfaceType;

struct WaterSurface::State {
    scene::Water water;
    GridSize size;
    std::optional<WaveSum> waves;  ///< also flat water of any type
    std::optional<SpectrumSea> spectrum;
};

WaterSurface::WaterSurface(const scene::Water& water) : state_(std::make_unique<State>()) {
    state_->water = water;
    if (water.surface.type == WaterSurfaceType::mesh_sequence) {
        state_->size.cells_x = state_->size.cells_z = 0;
        return;
    }
    state_->size = grid_size(water);
    if (water.surface.type == WaterSurfaceType::spectrum && !is_flat(water.surface)) {
        state_->spectrum.emplace(water, state_->size);
    } else {
        if (water.surface.type == WaterSurfaceType::spectrum) state_->water.surface = {};
        state_->waves.emplace(state_->water, state_->size);
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
        water.mesh_cells);
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

scene::WaterMesh WaterSurface::mesh(double time) const {
    const scene::WaterSurface& surface = state_->water.surface;
    if (surface.type == WaterSurfaceType::mesh_sequence) return sequence_mesh(surface.mesh_sequence, time);

    const double choppiness = state_->spectrum ? surface.spectrum.choppiness : 0;
    scene::WaterMesh mesh = grid_mesh(
        state_->water.extent, grid(time, choppiness != 0 ? kChoppyMeshFields : kMeshFields), choppiness);
    // The sums of a height and of the bound are rounded in different orders.
    constexpr double rounding = 1 + 1e-12;
    const double amplitudes =
        rounding * (state_->spectrum ? state_->spectrum->amplitude_sum() : state_->waves->amplitude_sum());
    mesh.height_bound = amplitudes;
    mesh.displacement_bound = std::abs(choppiness) * amplitudes;
    mesh.shortest_wave = state_->size.shortest_wave;
    mesh.cells_per_shortest_wave = state_->size.cells_per_shortest_wave;
    mesh.capped = state_->size.capped;
    return mesh;
}

SurfaceGrid WaterSurface::grid(double time, FieldMask fields) const {
    assert(state_->waves || state_->spectrum);
    return state_->spectrum ? state_->spectrum->grid(time, fields) : state_->waves->grid(time, fields);
}

SurfaceSample WaterSurface::sample(double x, double z, double time) const {
    assert(state_->waves || state_->spectrum);
    return state_->spectrum ? state_->spectrum->sample(x, z, time) : state_->waves->sample(x, z, time);
}

GridSize WaterSurface::size() const {
    return state_->size;
}

}  // namespace dapple::ocean
