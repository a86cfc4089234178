#include "ocean/spectrum_sea.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <utility>

#include "base/parallel.h"
#include "ocean/grid_fft.h"
#include "ocean/grid_size.h"

namespace dapple::ocean {
namespace {

using Complex = std::complex<double>;

std::size_t folded(int index, int size) {
    return static_cast<std::size_t>(((index % size) + size) % size);
}

// Re(factor * amplitude * e) for "of cosine", Re(i * factor * amplitude * e) for "of -sine".
Complex field_amplitude(const FieldFactor& f, Complex amplitude) {
    return f.of_cosine ? f.factor * amplitude
                       : Complex(-f.factor * amplitude.imag(), f.factor * amplitude.real());
}

}  // namespace

SpectrumSea::SpectrumSea(const scene::Water& water)
    : corner_(water.extent.center - 0.5 * water.extent.size),
      periods_(periods_across(water)),
      loop_(water.surface.spectrum.loop),
      modes_(spectrum_modes(water.surface.spectrum, water.extent.size / glm::dvec2(periods_))) {
    lengths_.reserve(modes_.size());
    for (const Mode& mode : modes_) {
        lengths_.push_back(2 * std::numbers::pi / std::hypot(mode.k.x, mode.k.y));
        amplitude_sum_ += std::abs(mode.amplitude);
    }
}

SurfaceGrid SpectrumSea::grid(const Lattice& lattice, double time, FieldMask mask,
                              WaveLengths lengths) const {
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < modes_.size(); ++i) {
        if (lengths.hold(lengths_[i])) wanted.push_back(i);
    }
    SurfaceGrid grid;
    grid.rows = lattice.rows();
    grid.columns = lattice.columns();
    const auto columns = static_cast<std::size_t>(grid.columns);
    const std::vector<Field> fields = fields_of(mask);
    if (wanted.empty()) {
        for (const Field field : fields) grid[field].resize(static_cast<std::size_t>(grid.rows) * columns);
        return grid;
    }
    assert(lattice.cells % periods_ == glm::ivec2(0));
    const glm::ivec2 points = lattice.cells / periods_;
    const CellBox& box = lattice.box;
    SurfaceGrid one = tile(points, time, mask, wanted);
    if (box.lower == glm::ivec2(0) && box.upper == points && lattice.hole.empty()) return one;
    for (const Field field : fields) {
        std::vector<double>& values = grid[field];
        values.resize(static_cast<std::size_t>(grid.rows) * columns);
        parallel_for(static_cast<std::size_t>(grid.rows), 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                const std::size_t tile_row = folded(box.lower.y + static_cast<int>(row), points.y);
                const double* from = one[field].data() + tile_row * static_cast<std::size_t>(one.columns);
                lattice.for_runs(static_cast<int>(row), [&](int first, int last) {
                    for (int column = first; column < last; ++column)
                        values[row * columns + static_cast<std::size_t>(column)] =
                            from[folded(box.lower.x + column, points.x)];
                });
            }
        });
    }
    return grid;
}

SurfaceGrid SpectrumSea::tile(glm::ivec2 points, double time, FieldMask mask,
                              const std::vector<std::size_t>& wanted) const {
    // Amplitudes at this time, seen from the tile's corner.
    const TimePhase time_phase(time, loop_);
    std::vector<Complex> amplitudes(wanted.size());
    parallel_for(wanted.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Mode& mode = modes_[wanted[i]];
            const double phase = glm::dot(mode.k, corner_) - time_phase(mode);
            amplitudes[i] = mode.amplitude * Complex(std::cos(phase), std::sin(phase));
        }
    });
    std::vector<bool> used(static_cast<std::size_t>(points.y));
    for (const std::size_t i : wanted) {
        used[folded(modes_[i].n, points.y)] = true;
        used[folded(-modes_[i].n, points.y)] = true;
    }
    std::vector<int> used_rows;
    std::vector<std::size_t> row_slot(used.size());  // of each row of the tile: its place among the used ones
    for (std::size_t row = 0; row < used.size(); ++row) {
        row_slot[row] = used_rows.size();
        if (used[row]) used_rows.push_back(static_cast<int>(row));
    }

    SurfaceGrid grid;
    grid.rows = points.y + 1;
    grid.columns = points.x + 1;
    const std::vector<Field> fields = fields_of(mask);
    for (const Field field : fields)
        grid[field].resize(static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns));

    // Re(B e) = B e / 2 + conj(B) conj(e) / 2: a mode fills its own bin and the opposite one. Two fields
    // share a transform, as real and imaginary part.
    const GridFft fft(points.y, points.x, std::move(used_rows));
    const std::size_t pairs = (fields.size() + 1) / 2;
    const auto columns = static_cast<std::size_t>(points.x);
    std::vector<std::vector<Complex>> spectra(pairs);
    parallel_for(pairs, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const bool two = 2 * p + 1 < fields.size();
            std::vector<Complex>& z = spectra[p];
            z = fft.spectrum();
            for (std::size_t i = 0; i < wanted.size(); ++i) {
                const Mode& mode = modes_[wanted[i]];
                const Complex f =
                    0.5 * field_amplitude(field_factor(fields[2 * p], mode.k, mode.omega), amplitudes[i]);
                const Complex g =
                    two ? 0.5 * field_amplitude(field_factor(fields[2 * p + 1], mode.k, mode.omega),
                                                amplitudes[i])
                        : Complex(0, 0);
                const std::size_t bin =
                    row_slot[folded(mode.n, points.y)] * columns + folded(mode.m, points.x);
                const std::size_t opposite =
                    row_slot[folded(-mode.n, points.y)] * columns + folded(-mode.m, points.x);
                z[bin] += Complex(f.real() - g.imag(), f.imag() + g.real());
                z[opposite] += Complex(f.real() + g.imag(), g.real() - f.imag());
            }
        }
    });
    for (std::size_t p = 0; p < pairs; ++p) {
        const bool two = 2 * p + 1 < fields.size();
        fft.synthesise(spectra[p], grid[fields[2 * p]],
                       two ? std::span<double>(grid[fields[2 * p + 1]]) : std::span<double>());
    }
    return grid;
}

double SpectrumSea::mean_square_slope(WaveLengths lengths) const {
    double sum = 0;
    for (std::size_t i = 0; i < modes_.size(); ++i) {
        if (lengths.hold(lengths_[i]))
            sum += 0.5 * glm::dot(modes_[i].k, modes_[i].k) * std::norm(modes_[i].amplitude);
    }
    return sum;
}

bool SpectrumSea::any(WaveLengths lengths) const {
    return std::any_of(lengths_.begin(), lengths_.end(), [&](double length) { return lengths.hold(length); });
}

double SpectrumSea::making_bytes(const scene::Water& water, glm::ivec2 points, FieldMask mask) {
    const glm::dvec2 longest =
        water.extent.size / glm::dvec2(periods_across(water)) / water.surface.spectrum.cutoff_length;
    const double modes = std::numbers::pi * longest.x * longest.y;
    const auto fields = static_cast<double>(fields_of(mask).size());
    const double a_point = fields * sizeof(double) + std::ceil(fields / 2) * sizeof(Complex);
    return modes * (sizeof(Mode) + sizeof(double) + sizeof(std::size_t) + sizeof(Complex)) +
           static_cast<double>(points.x) * static_cast<double>(points.y) * a_point;
}

SurfaceSample SpectrumSea::sample(double x, double z, double time) const {
    const TimePhase time_phase(time, loop_);
    SurfaceSample sample;
    for (const Mode& mode : modes_) {
        const double phase = mode.k.x * x + mode.k.y * z - time_phase(mode);
        const Complex value = mode.amplitude * Complex(std::cos(phase), std::sin(phase));
        add_sinusoid(sample, value.real(), -value.imag(), mode.k, mode.omega);
    }
    return sample;
}

}  // namespace dapple::ocean
