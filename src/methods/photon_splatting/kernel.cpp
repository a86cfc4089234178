#include "methods/photon_splatting/kernel.h"

#include <cmath>

namespace dapple::methods {
namespace {

using lanes::greater;
using lanes::lesser;
using lanes::magnitude;

constexpr float kSmallestSpacing = 0.01f;  // cells
constexpr float kSmallestBox = 0.002f;     // of the support

/// Length in cells along the nearer axis of the picture: a box of extent 1 sums to the same over rows (or
/// columns) of cells wherever it lies, also when it runs obliquely.
Floats extent(Vectors2 vector) {
    return greater(magnitude(vector.x), magnitude(vector.y));
}

/// Makes the half-extents of the kernel of a vector of the lattice, times the style's scale, and its box.
void widen(Vectors2& vector, Floats& box, Floats cells, const KernelMetric& metric,
           const KernelStyle& style) {
    const bool tent = style.shape == KernelShape::tent;
    // Both in units of the vector: half-widths of the shape and of the box that it is convolved with.
    Floats core = all(tent ? 1.0f : 0.5f), half{};
    if (style.widened) {
        const Floats across = greater(all(1e-30f), metric.beam.product(vector, vector));
        const Floats radius_square = metric.disc_radius * metric.disc_radius / across;
        // Variances along a line: of a box of width w w^2 / 12, of a tent of half-width c c^2 / 6, of a disc
        // of radius R R^2 / 4.
        if (style.scale == std::trunc(style.scale)) {
            const Floats share = tent ? lesser(greater(2.0f - cells, all(0.0f)), all(1.0f)) : all(1.0f);
            const Floats cell = share / cells;
            half = 0.5f * lanes::square_root<float>(cell * cell + 3.0f * radius_square);
        } else {  // only the cell's own box makes the samples of pixels hold the flux
            core = lanes::square_root<float>(core * core + (tent ? 1.5f : 0.75f) * radius_square);
            half = 0.5f / cells;
        }
    }
    // A box's edge of no width has no profile; of a tent such a box would change less than round-off.
    const Floats least = tent ? Floats{} : core * (kSmallestBox / (1 - kSmallestBox));
    half = half < kSmallestBox * (core + half) ? least : half;
    const Floats whole = core + half;
    box = half / whole;
    vector = whole * vector;
}

}  // namespace

Metric reduction_metric(const KernelMetric& metric) {
    const Vectors2 x = metric.cell_from_first, y = metric.cell_from_second;
    const Metric cell{dot(x, x), dot(x, y), dot(y, y)}, &beam = metric.beam;
    // Covariances add: a cell's box 1/12, the disc's R^2 / 4. The inverse of the sum of the inverses of two
    // symmetric matrices of two rows, A and B, is det(B) A + det(A) B but for its unit.
    const Floats disc = 3.0f * metric.disc_radius * metric.disc_radius;
    const Floats of_cell = beam.xx * beam.yy - beam.xy * beam.xy,
                 of_beam = disc * (cell.xx * cell.yy - cell.xy * cell.xy);
    return {of_cell * cell.xx + of_beam * beam.xx, of_cell * cell.xy + of_beam * beam.xy,
            of_cell * cell.yy + of_beam * beam.yy};
}

PlaneKernel widened_kernel(const LatticeBasis& basis, const KernelMetric& metric, const KernelStyle& style) {
    const Floats scale = all(style.scale);
    PlaneKernel kernel{scale * basis.first, scale * basis.second, {}, {}};
    Vectors2 first = metric.cells(kernel.first), second = metric.cells(kernel.second);
    if (style.widened) {
        constexpr float kSmallestSquare = kSmallestSpacing * kSmallestSpacing;
        const Vectors2 x = metric.cell_from_first, y = metric.cell_from_second;
        const Floats area_from_plane = cross(x, y);
        const auto on_plane = [&](Vectors2 cells) {
            return Vectors2{cross(cells, y) / area_from_plane, cross(x, cells) / area_from_plane};
        };
        const Flags no_second = ~(dot(second, second) >= kSmallestSquare);
        if (lanes::any(no_second)) {
            second = choose(no_second, {all(0.0f), all(kSmallestSpacing)}, second);
            kernel.second = choose(no_second, on_plane(second), kernel.second);
        }
        const Floats second_square = dot(second, second), area = cross(first, second);
        constexpr float kThin = kSmallestSquare * 1e-4f;
        const Flags no_first =
            ~(area * area > kThin * second_square) | ~(dot(first, first) >= kSmallestSquare);
        if (lanes::any(no_first)) {
            const Vectors2 across = {-second.y, second.x};
            first = choose(no_first, (kSmallestSpacing * lanes::inverse_root(second_square)) * across, first);
            kernel.first = choose(no_first, on_plane(first), kernel.first);
        }
    }
    widen(kernel.first, kernel.box_first, extent(first), metric, style);
    widen(kernel.second, kernel.box_second, extent(second), metric, style);
    return kernel;
}

}  // namespace dapple::methods
