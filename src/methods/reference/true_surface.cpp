#include "methods/reference/true_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "ocean/grid_size.h"
#include "ocean/water_surface.h"

namespace dapple::reference {
namespace {

/// Cells a shortest wave and triangles at most of the meshes that are made here.
constexpr double kCellsPerWave = 100;
constexpr double kMostTriangles = 4e6;
/// Of the patches of a sea that repeats, which make no mesh, in triangles too.
constexpr double kMostOfPeriod = 16e6;

/// Weights of value and derivative (times the cell) at both ends of a cubic Hermite segment, at t in [0, 1].
struct Hermite {
    std::array<double, 2> value, derivative;

    static Hermite at(double t) {
        const double s = 1 - t;
        return {{(1 + 2 * t) * s * s, (1 + 2 * s) * t * t}, {t * s * s, -s * t * t}};
    }
    static Hermite slope_at(double t) {
        const double s = 1 - t;
        return {{-6 * t * s, 6 * t * s}, {s * (1 - 3 * t), t * (3 * t - 2)}};
    }
};

/// Along one axis: the cell that holds a coordinate, and the place in it.
struct CellPlace {
    int index;
    double t;
    CellPlace(double coordinate, double corner, double cell, int points, bool repeats) {
        double place = (coordinate - corner) / cell;
        if (repeats) place -= (points - 1) * std::floor(place / (points - 1));
        index = std::clamp(static_cast<int>(std::floor(place)), 0, points - 2);
        t = place - index;
    }
};

/// The water with a finer grid, where the frame's is coarser; without rings, which leave out waves.
scene::Water refined(const scene::Water& water, double most_triangles = kMostTriangles) {
    scene::Water finer = water;
    finer.rings = {};
    const ocean::GridSize size = ocean::grid_size(finer);
    if (!(size.cells_per_shortest_wave > 0)) return finer;
    const double wanted = kCellsPerWave / size.cells_per_shortest_wave;
    const double allowed = std::sqrt(most_triangles / static_cast<double>(size.triangles()));
    const double factor = std::min(wanted, allowed);
    if (factor > 1) finer.mesh_cells = static_cast<int>(std::lround(factor * size.cells_x));
    return finer;
}

bool repeats_within(const scene::Water& water) {
    return ocean::periods_across(water) != glm::ivec2(1);
}

/// Water of its own over the first period of a spectrum, with the same waves at the same places.
scene::Water patch_water(const scene::Water& water) {
    if (!repeats_within(water)) return refined(water);
    scene::Water one = water;
    const glm::dvec2 corner = water.extent.center - 0.5 * water.extent.size;
    one.extent.size = water.extent.size / glm::dvec2(ocean::periods_across(water));
    one.extent.center = corner + 0.5 * one.extent.size;
    one.surface.spectrum.period = 0;
    one.mesh_cells = 0;
    return refined(one, kMostOfPeriod);
}

PatchedSea patched_sea(const scene::Water& all, double time) {
    const scene::Water water = patch_water(all);
    const ocean::WaterSurface surface(water);
    const ocean::GridSize size = surface.size();
    ocean::SurfaceGrid grid =
        surface.grid(time, ocean::kHeight | ocean::kSlope | ocean::field_bit(ocean::Field::second_xz));
    PatchedSea sea;
    sea.columns = grid.columns;
    sea.rows = grid.rows;
    sea.repeats = repeats_within(all);
    sea.corner = water.extent.center - 0.5 * water.extent.size;
    sea.cell = water.extent.size / glm::dvec2(size.cells_x, size.cells_z);
    sea.height = std::move(grid[ocean::Field::height]);
    sea.slope_x = std::move(grid[ocean::Field::slope_x]);
    sea.slope_z = std::move(grid[ocean::Field::slope_z]);
    sea.mixed = std::move(grid[ocean::Field::second_xz]);
    return sea;
}

}  // namespace

double surface_bytes(const scene::Water& water) {
    if (water.surface.type == scene::WaterSurfaceType::mesh_sequence || ocean::is_flat(water.surface))
        return 0;
    const ocean::GridSize size = ocean::grid_size(refined(water));
    double patches = 0;
    if (repeats_within(water)) {
        // Four fields, and what they are made from.
        const ocean::MeshCounts counts = ocean::mesh_counts(patch_water(water));
        patches = static_cast<double>(counts.vertices) * 4 * sizeof(double) +
                  static_cast<double>(counts.spectrum_bytes);
    }
    // Positions, normals and what they are made from; indices and Embree's tree (70 bytes, measured).
    return patches + static_cast<double>(size.vertices()) * (2 * sizeof(glm::dvec3) + 8 * sizeof(double)) +
           static_cast<double>(size.triangles()) * (sizeof(glm::uvec3) + 70);
}

void PatchedSea::evaluate(std::span<const double> x, std::span<const double> z, std::span<double> out_height,
                          std::span<double> out_slope_x, std::span<double> out_slope_z) const {
    for (std::size_t i = 0; i < x.size(); ++i) {
        const CellPlace across(x[i], corner.x, cell.x, columns, repeats);
        const CellPlace along(z[i], corner.y, cell.y, rows, repeats);
        const Hermite u = Hermite::at(across.t), du = Hermite::slope_at(across.t);
        const Hermite v = Hermite::at(along.t), dv = Hermite::slope_at(along.t);
        double h = 0, hx = 0, hz = 0;
        for (std::size_t row = 0; row < 2; ++row) {
            for (std::size_t column = 0; column < 2; ++column) {
                const std::size_t at =
                    (static_cast<std::size_t>(along.index) + row) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(across.index) + column;
                const double f = height[at];
                const double fx = slope_x[at] * cell.x;
                const double fz = slope_z[at] * cell.y;
                const double fxz = mixed[at] * cell.x * cell.y;
                const auto sum = [&](const Hermite& a, const Hermite& b) {
                    return b.value[row] * (a.value[column] * f + a.derivative[column] * fx) +
                           b.derivative[row] * (a.value[column] * fz + a.derivative[column] * fxz);
                };
                h += sum(u, v);
                hx += sum(du, v) / cell.x;
                hz += sum(u, dv) / cell.y;
            }
        }
        out_height[i] = h;
        out_slope_x[i] = hx;
        out_slope_z[i] = hz;
    }
}

TrueSurface::TrueSurface(const scene::FrameScene& scene)
    : water_(*scene.state.water), time_(scene.state.time) {
    const scene::WaterSurface& surface = water_.surface;
    const bool spectrum = surface.type == scene::WaterSurfaceType::spectrum;
    if (surface.type == scene::WaterSurfaceType::waves || ocean::is_flat(surface)) {
        sines_.emplace(spectrum ? scene::Waves{} : surface.waves, time_);
        steepest_ = sines_->slope_bound();
        highest_ = sines_->height_bound();
    } else if (spectrum && surface.spectrum.choppiness == 0) {
        sea_ = patched_sea(water_, time_);
        for (std::size_t i = 0; i < sea_->height.size(); ++i) {
            highest_ = std::max(highest_, std::abs(sea_->height[i]));
            steepest_ = std::max(steepest_, std::hypot(sea_->slope_x[i], sea_->slope_z[i]));
        }
        highest_ *= 1.1;
        steepest_ *= 1.1;
    } else {
        triangles_ =
            spectrum && !ocean::has_rings(water_)
                ? std::make_shared<const scene::WaterMesh>(ocean::WaterSurface(refined(water_)).mesh(time_))
                : scene.water;
        steepest_ = std::numeric_limits<double>::infinity();
        for (const glm::dvec3& position : triangles_->mesh.positions)
            highest_ = std::max(highest_, std::abs(position.y));
    }
}

void TrueSurface::evaluate(std::span<const double> x, std::span<const double> z, std::span<double> height,
                           std::span<double> slope_x, std::span<double> slope_z) const {
    if (sines_)
        sines_->evaluate(x, z, height, slope_x, slope_z);
    else
        sea_->evaluate(x, z, height, slope_x, slope_z);
}

std::shared_ptr<const scene::WaterMesh> TrueSurface::mesh() const {
    if (triangles_) return triangles_;
    return std::make_shared<const scene::WaterMesh>(ocean::WaterSurface(refined(water_)).mesh(time_));
}

double TrueSurface::chord_error(const scene::WaterMesh& mesh) const {
    if (!is_height_field()) return 0;
    const std::vector<glm::dvec3>& points = mesh.mesh.positions;
    const auto columns = static_cast<std::size_t>(mesh.columns);
    std::vector<double> most(static_cast<std::size_t>(mesh.rows) - 1, 0);
    parallel_for(most.size(), 16, [&](std::size_t begin, std::size_t end) {
        std::vector<double> x(columns - 1), z(x), h(x), sx(x), sz(x);
        for (std::size_t row = begin; row < end; ++row) {
            const auto corner = [&](std::size_t down, std::size_t column) {
                return points[(row + down) * columns + column];
            };
            for (std::size_t i = 0; i + 1 < columns; ++i) {
                const glm::dvec3 middle = 0.5 * (corner(1, i) + corner(0, i + 1));
                x[i] = middle.x;
                z[i] = middle.z;
            }
            evaluate(x, z, h, sx, sz);
            for (std::size_t i = 0; i + 1 < columns; ++i) {
                for (const double chord :
                     {corner(1, i).y + corner(0, i + 1).y, corner(0, i).y + corner(1, i + 1).y}) {
                    most[row] = std::max(most[row], std::abs(0.5 * chord - h[i]));
                }
            }
        }
    });
    return 2 * *std::max_element(most.begin(), most.end());
}

}  // namespace dapple::reference
