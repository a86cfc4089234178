#include "ocean/grid_size.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"

namespace dapple::ocean {
namespace {

bool is_smooth(int n) {
    for (const int p : {2, 3, 5}) {
        while (n % p == 0) n /= p;
    }
    return n == 1;
}

}  // namespace

double shortest_wave(const scene::WaterSurface& surface) {
    if (surface.type == scene::WaterSurfaceType::spectrum) return surface.spectrum.cutoff_length;
    double shortest = surface.waves.waves.front().length;
    for (const scene::Wave& wave : surface.waves.waves) shortest = std::min(shortest, wave.length);
    return shortest;
}

glm::ivec2 periods_across(const scene::Water& water) {
    const double period = water.surface.spectrum.period;
    if (water.surface.type != scene::WaterSurfaceType::spectrum || !(period > 0)) return {1, 1};
    const glm::dvec2 periods = glm::max(glm::round(water.extent.size / period), 1.0);
    if (!(std::max(periods.x, periods.y) <= 1 << 30))
        throw Error(
            ExitCode::timeline_invalid,
            "water.surface.period: more than 2^30 periods across the water's extent; ask for a longer one");
    return glm::ivec2(periods);
}

int smooth_size_up(int n) {
    while (!is_smooth(n)) ++n;
    return n;
}

int smooth_size_down(int n) {
    while (!is_smooth(n)) --n;
    return n;
}

bool is_flat(const scene::WaterSurface& surface) {
    if (surface.type == scene::WaterSurfaceType::mesh_sequence) return false;
    if (surface.type == scene::WaterSurfaceType::spectrum) {
        const scene::Spectrum& s = surface.spectrum;
        return s.amplitude_scale == 0 || s.wind_speed <= 0 || s.fetch <= 0;
    }
    return std::all_of(surface.waves.waves.begin(), surface.waves.waves.end(),
                       [](const scene::Wave& wave) { return wave.amplitude == 0; });
}

GridSize grid_size(const scene::Water& water) {
    const glm::dvec2 extent = water.extent.size;
    const bool flat = is_flat(water.surface);
    const bool fft = !flat && water.surface.type == scene::WaterSurfaceType::spectrum;
    GridSize size;
    if (!flat) size.shortest_wave = shortest_wave(water.surface);

    // In double throughout: the cells asked for may be far beyond int.
    double x = 2;
    double z = 2;
    if (water.mesh_cells > 0) {
        x = water.mesh_cells;
        z = std::max(1.0, std::round(x * extent.y / extent.x));
    } else if (!flat) {
        x = std::ceil(kDefaultCellsPerWave * extent.x / size.shortest_wave);
        z = std::ceil(kDefaultCellsPerWave * extent.y / size.shortest_wave);
    }
    const glm::ivec2 periods = fft ? periods_across(water) : glm::ivec2(1);
    const auto rounded_up = [&](double n, double of) {
        return fft && n < kTriangleLimit ? of * smooth_size_up(static_cast<int>(std::ceil(n / of))) : n;
    };
    const auto rounded_down = [&](double n, double of) {
        return of * smooth_size_down(std::max(1, static_cast<int>(n / of)));
    };
    const double wanted_x = rounded_up(x, periods.x);
    const double wanted_z = rounded_up(z, periods.y);
    if (water.mesh_cells <= 0 && 2 * wanted_x * wanted_z > kDefaultTriangleCap) {
        size.capped = true;
        const double cells = kDefaultTriangleCap / 2;
        const double shrink = std::min(1.0, std::sqrt(cells / (x * z)));
        x = std::clamp(std::floor(x * shrink), 1.0, cells);
        z = std::clamp(std::floor(z * shrink), 1.0, std::floor(cells / x));
        x = std::min(x, std::floor(cells / z));
        if (fft) {
            x = rounded_down(x, periods.x);
            z = rounded_down(z, periods.y);
        }
    } else {
        x = wanted_x;
        z = wanted_z;
    }
    if (!(2 * x * z <= kTriangleLimit)) {
        if (water.mesh_cells <= 0)
            throw Error(ExitCode::timeline_invalid,
                        "water.surface.period: so many periods across the water's extent make more than 100 "
                        "million triangles; ask for a longer one");
        throw Error(ExitCode::timeline_invalid, "water.mesh_cells: " + std::to_string(water.mesh_cells) +
                                                    " cells along x make more than 100 million triangles of "
                                                    "the water's extent; ask for fewer");
    }
    size.cells_x = static_cast<int>(x);
    size.cells_z = static_cast<int>(z);
    if (!flat) size.cells_per_shortest_wave = size.shortest_wave * std::min(x / extent.x, z / extent.y);
    return size;
}

}  // namespace dapple::ocean
