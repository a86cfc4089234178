#include "ocean/ring_layout.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "base/error.h"

namespace dapple::ocean {
namespace {

/// Lines at its edge by which a level may move when the viewpoint crosses half of a cell of the next, and one
/// cell of that more, so that whole cells of it come and go.
constexpr double kMovingCells = 4;
/// Finest cells across the extent: their indices are ints.
constexpr double kMostLines = 1 << 30;

/// Of sizes that are whole multiples round-off makes no further cells.
constexpr double kRounding = 1e-9;
/// Most points of the tile that a spectrum is evaluated on: 5 seconds of CPU time and 2 GB for a choppy sea.
constexpr double kMostTilePoints = 1 << 24;

/// The smallest number of cells across the extent, `least` or more, that a level can have whose cells double
/// `doublings` times: a multiple of 2^doublings, with whole cells in each period, on all levels that have 4
/// or more of them there; their number is of the form 2^a 3^b 5^c. `least / periods` and 2^doublings are at
/// most 2^25.
double periodic_cells(double least, int periods, int doublings) {
    int of_period = static_cast<int>(std::ceil(least / periods - kRounding));
    for (;; ++of_period) {
        of_period = smooth_size_up(std::max(of_period, 1));
        int halvings = 0;
        while (halvings < doublings && of_period >> (halvings + 1) >= kLeastCellsPerWave) ++halvings;
        const std::int64_t all = std::int64_t{of_period} * periods;
        if (of_period % (1 << halvings) == 0 && all % (1 << doublings) == 0) return static_cast<double>(all);
    }
}

}  // namespace

RingLayout::RingLayout(const scene::Water& water)
    : extent_(water.extent),
      periods_(is_flat(water.surface) ? glm::ivec2(1) : periods_across(water)),
      across_((water.rings.cells + 3) / 4 * 4) {
    const double inner = water.rings.inner_size;
    const double longer = std::max(extent_.size.x, extent_.size.y);
    const double doublings = std::max(0.0, std::ceil(std::log2(longer / inner) - kRounding));
    const double coarse = inner / across_ * std::exp2(doublings);
    const glm::dvec2 cells = glm::max(glm::ceil(extent_.size / coarse - kRounding), 1.0);
    if (!(std::max(cells.x, cells.y) * std::exp2(doublings) <= kMostLines))
        throw Error(ExitCode::timeline_invalid,
                    "water.rings.inner_size: cells so small beside the water's extent are more than 2^30 "
                    "across it; ask for a larger one");
    levels_ = 1 + static_cast<int>(doublings);
    coarsest_ = glm::ivec2(cells);
    if (water.surface.type == scene::WaterSurfaceType::spectrum && !is_flat(water.surface))
        fit_periods(inner);
    if (most().triangles > static_cast<std::size_t>(kTriangleLimit))
        throw Error(ExitCode::timeline_invalid, "water.rings.cells: " + std::to_string(water.rings.cells) +
                                                    " cells across make more than 100 million triangles; "
                                                    "ask for fewer");
}

void RingLayout::fit_periods(double inner) {
    const double finest = inner / across_;
    const glm::dvec2 period = extent_.size / glm::dvec2(periods_), points = glm::ceil(period / finest);
    if (!(points.x * points.y <= kMostTilePoints))
        throw Error(
            ExitCode::timeline_invalid,
            "water.surface.period: a sea that repeats after " + std::to_string(period.x) + " m by " +
                std::to_string(period.y) + " m has more than 2^24 cells of " + std::to_string(finest) +
                " m, as water.rings asks for, in a period; ask for a shorter one, or for larger cells");
    RingLayout best = *this;
    double fewest = std::numeric_limits<double>::infinity();
    for (int doublings = levels_ - 1; doublings >= 0; --doublings) {
        const glm::dvec2 cells(periodic_cells(extent_.size.x / finest, periods_.x, doublings),
                               periodic_cells(extent_.size.y / finest, periods_.y, doublings));
        if (std::max(cells.x, cells.y) > kMostLines) continue;
        RingLayout layout = *this;
        layout.levels_ = 1 + doublings;
        layout.coarsest_ = glm::ivec2(cells) / (1 << doublings);
        const glm::dvec2 cell = layout.cell(0);
        layout.across_ = 4 * static_cast<int>(std::ceil(inner / (4 * std::min(cell.x, cell.y)) - kRounding));
        const auto triangles = static_cast<double>(layout.most().triangles);
        if (triangles < fewest) {
            fewest = triangles;
            best = layout;
        }
    }
    if (fewest > kTriangleLimit)
        throw Error(
            ExitCode::timeline_invalid,
            "water.surface.period: rings whose cells divide it, " + std::to_string(periods_.x) + " by " +
                std::to_string(periods_.y) +
                " times across the extent, have more than 100 million triangles; ask for one that goes "
                "into the extent a power of two times, or for fewer water.rings.cells");
    *this = best;
}

glm::ivec2 RingLayout::lattice_cells(int level) const {
    return coarsest_ * (1 << (levels_ - 1 - level));
}

glm::dvec2 RingLayout::cell(int level) const {
    return extent_.size / glm::dvec2(lattice_cells(level));
}

CellBox RingLayout::box(int level, glm::dvec2 viewpoint) const {
    const glm::ivec2 all = lattice_cells(level);
    if (level + 1 == levels_) return {{0, 0}, all};
    const glm::dvec2 line = (viewpoint - extent_.center + 0.5 * extent_.size) / cell(level + 1);
    // Far beyond the extent is as good as beyond it.
    const glm::ivec2 middle =
        2 * glm::ivec2(glm::clamp(glm::round(line), glm::dvec2(-across_), glm::dvec2(all + across_)));
    return {glm::clamp(middle - across_ / 2, glm::ivec2(0), all),
            glm::clamp(middle + across_ / 2, glm::ivec2(0), all)};
}

Lattice RingLayout::lattice(int level, glm::dvec2 viewpoint) const {
    Lattice lattice{extent_, lattice_cells(level), box(level, viewpoint)};
    if (level == 0) return lattice;
    const CellBox inside = box(level - 1, viewpoint);
    if (!inside.empty()) lattice.hole = {inside.lower / 2, inside.upper / 2};
    return lattice;
}

double RingLayout::morph(int level, glm::dvec2 offset) const {
    if (level + 1 == levels_) return 0;
    const glm::dvec2 cells = glm::abs(offset) / cell(level);
    const double begin = 0.375 * across_, end = 0.5 * across_ - kMovingCells;
    const double t = std::clamp((std::max(cells.x, cells.y) - begin) / (end - begin), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

WaveLengths RingLayout::last_waves(int level) const {
    WaveLengths lengths = lasting_waves(level - 1);
    lengths.end = lasting_waves(level).least;
    return lengths;
}

WaveLengths RingLayout::lasting_waves(int level) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (level < 0) return {0, infinity};
    if (level + 1 == levels_ || lattice_cells(level + 1) % periods_ != glm::ivec2(0))
        return {infinity, infinity};
    const glm::dvec2 next = cell(level + 1);
    return {kLeastCellsPerWave * std::max(next.x, next.y), infinity};
}

MeshCounts RingLayout::most() const {
    const auto square = [](double side) { return side * side; };
    const double across = across_;
    double vertices = (coarsest_.x + 1.0) * (coarsest_.y + 1.0);
    double triangles = 2.0 * coarsest_.x * coarsest_.y;
    for (int level = 0; level + 1 < levels_; ++level) {
        // The hole's side is cut into half as many of the next level's cells.
        vertices += square(across + 1) - (level > 0 ? square(across / 2 + 1) : 0);
        triangles += 2 * (square(across) - (level > 0 ? square(across / 2) : 0)) + 2 * across;
    }
    return {static_cast<std::size_t>(vertices), static_cast<std::size_t>(triangles)};
}

}  // namespace dapple::ocean
