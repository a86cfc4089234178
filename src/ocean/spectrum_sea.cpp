#include "ocean/spectrum_sea.h"

#include <cmath>
#include <complex>
#include <span>

#include "base/parallel.h"
#include "ocean/grid_fft.h"

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

SpectrumSea::SpectrumSea(const scene::Water& water, const GridSize& size)
    : corner_(water.extent.center - 0.5 * water.extent.size),
      size_(size),
      loop_(water.surface.spectrum.loop),
      modes_(spectrum_modes(water.surface.spectrum, water.extent.size)) {
    std::vector<bool> used(static_cast<std::size_t>(size_.cells_z));
    for (const Mode& mode : modes_) {
        used[folded(mode.n, size_.cells_z)] = true;
        used[folded(-mode.n, size_.cells_z)] = true;
        amplitude_sum_ += std::abs(mode.amplitude);
    }
    row_slot_.resize(used.size());
    for (std::size_t row = 0; row < used.size(); ++row) {
        row_slot_[row] = used_rows_.size();
        if (used[row]) used_rows_.push_back(static_cast<int>(row));
    }
}

SurfaceGrid SpectrumSea::grid(double time, FieldMask mask) const {
    // Amplitudes at this time, seen from the grid's corner.
    const TimePhase time_phase(time, loop_);
    std::vector<Complex> amplitudes(modes_.size());
    parallel_for(modes_.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Mode& mode = modes_[i];
            const double phase = glm::dot(mode.k, corner_) - time_phase(mode);
            amplitudes[i] = mode.amplitude * Complex(std::cos(phase), std::sin(phase));
        }
    });

    SurfaceGrid grid;
    grid.rows = size_.cells_z + 1;
    grid.columns = size_.cells_x + 1;
    const std::vector<Field> fields = fields_of(mask);
    for (const Field field : fields) grid[field].resize(size_.vertices());

    // Re(B e) = B e / 2 + conj(B) conj(e) / 2: a mode fills its own bin and the opposite one. Two fields
    // share a transform, as real and imaginary part.
    const GridFft fft(size_.cells_z, size_.cells_x, used_rows_);
    const std::size_t pairs = (fields.size() + 1) / 2;
    const auto columns = static_cast<std::size_t>(size_.cells_x);
    std::vector<std::vector<Complex>> spectra(pairs);
    parallel_for(pairs, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const bool two = 2 * p + 1 < fields.size();
            std::vector<Complex>& z = spectra[p];
            z = fft.spectrum();
            for (std::size_t i = 0; i < modes_.size(); ++i) {
                const Mode& mode = modes_[i];
                const Complex f =
                    0.5 * field_amplitude(field_factor(fields[2 * p], mode.k, mode.omega), amplitudes[i]);
                const Complex g =
                    two ? 0.5 * field_amplitude(field_factor(fields[2 * p + 1], mode.k, mode.omega),
                                                amplitudes[i])
                        : Complex(0, 0);
                const std::size_t bin =
                    row_slot_[folded(mode.n, size_.cells_z)] * columns + folded(mode.m, size_.cells_x);
                const std::size_t opposite =
                    row_slot_[folded(-mode.n, size_.cells_z)] * columns + folded(-mode.m, size_.cells_x);
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
