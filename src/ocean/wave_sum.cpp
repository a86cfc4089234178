#include "ocean/wave_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "ocean/dispersion.h"

namespace dapple::ocean {

WaveSum::WaveSum(const scene::Waves& waves) {
    for (const scene::Wave& wave : waves.waves) {
        if (wave.amplitude == 0) continue;
        const double k = 2 * std::numbers::pi / wave.length;
        components_.push_back({k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading)),
                               angular_frequency(k, waves.depth), wave.amplitude, wave.phase, wave.length});
    }
}

SurfaceGrid WaveSum::grid(const Lattice& lattice, double time, FieldMask mask, WaveLengths lengths) const {
    SurfaceGrid grid;
    grid.rows = lattice.rows();
    grid.columns = lattice.columns();
    const auto rows = static_cast<std::size_t>(grid.rows), columns = static_cast<std::size_t>(grid.columns);
    const std::vector<Field> fields = fields_of(mask);
    for (const Field field : fields) grid[field].resize(rows * columns);

    std::vector<Component> wanted;
    std::vector<FieldFactor> factors;  // of each wave and field, wave-major
    for (const Component& wave : components_) {
        if (!lengths.hold(wave.length)) continue;
        wanted.push_back(wave);
        for (const Field field : fields) factors.push_back(field_factor(field, wave.k, wave.omega));
    }
    const std::size_t waves = wanted.size();
    // cos(k.x x) and sin(k.x x) of each wave and column, wave-major.
    std::vector<double> cosines(waves * columns), sines(waves * columns);
    parallel_for(waves, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t w = begin; w < end; ++w) {
            for (std::size_t i = 0; i < columns; ++i) {
                const double angle = wanted[w].k.x * lattice.x(static_cast<int>(i));
                cosines[w * columns + i] = std::cos(angle);
                sines[w * columns + i] = std::sin(angle);
            }
        }
    });

    parallel_for(rows, 4, [&](std::size_t begin, std::size_t end) {
        // A stretch of a row at a time keeps all sums in the first cache.
        constexpr std::size_t stretch = 256;
        std::array<double, stretch> c;
        std::array<double, stretch> d;
        std::vector<double> a_cos(waves);
        std::vector<double> a_sin(waves);
        for (std::size_t row = begin; row < end; ++row) {
            const double z = lattice.z(static_cast<int>(row));
            for (std::size_t w = 0; w < waves; ++w) {
                const Component& wave = wanted[w];
                const double angle = wave.k.y * z - wave.omega * time + wave.phase;
                a_cos[w] = wave.amplitude * std::cos(angle);
                a_sin[w] = wave.amplitude * std::sin(angle);
            }
            lattice.for_runs(static_cast<int>(row), [&](int run_begin, int run_end) {
                for (auto first = static_cast<std::size_t>(run_begin);
                     first < static_cast<std::size_t>(run_end); first += stretch) {
                    const std::size_t count = std::min(stretch, static_cast<std::size_t>(run_end) - first);
                    for (std::size_t w = 0; w < waves; ++w) {
                        const double* cosine = cosines.data() + w * columns + first;
                        const double* sine = sines.data() + w * columns + first;
                        for (std::size_t i = 0; i < count; ++i) {
                            c[i] = a_cos[w] * cosine[i] - a_sin[w] * sine[i];
                            d[i] = -(a_sin[w] * cosine[i] + a_cos[w] * sine[i]);
                        }
                        for (std::size_t f = 0; f < fields.size(); ++f) {
                            const FieldFactor& factor = factors[w * fields.size() + f];
                            const double* source = factor.of_cosine ? c.data() : d.data();
                            double* target = grid[fields[f]].data() + row * columns + first;
                            for (std::size_t i = 0; i < count; ++i) target[i] += factor.factor * source[i];
                        }
                    }
                }
            });
        }
    });
    return grid;
}

SurfaceSample WaveSum::sample(double x, double z, double time) const {
    SurfaceSample sample;
    for (const Component& wave : components_) {
        const double phase = wave.k.x * x + wave.k.y * z - wave.omega * time + wave.phase;
        add_sinusoid(sample, wave.amplitude * std::cos(phase), -wave.amplitude * std::sin(phase), wave.k,
                     wave.omega);
    }
    return sample;
}

double WaveSum::amplitude_sum() const {
    double sum = 0;
    for (const Component& wave : components_) sum += std::abs(wave.amplitude);
    return sum;
}

double WaveSum::mean_square_slope(WaveLengths lengths) const {
    double sum = 0;
    for (const Component& wave : components_) {
        if (lengths.hold(wave.length))
            sum += 0.5 * glm::dot(wave.k, wave.k) * wave.amplitude * wave.amplitude;
    }
    return sum;
}

bool WaveSum::any(WaveLengths lengths) const {
    return std::any_of(components_.begin(), components_.end(),
                       [&](const Component& wave) { return lengths.hold(wave.length); });
}

}  // namespace dapple::ocean
