#include "ocean/wave_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "ocean/dispersion.h"
#include "ocean/grid_mesh.h"

namespace dapple::ocean {

WaveSum::WaveSum(const scene::Water& water, const GridSize& size)
    : size_(size), center_(water.extent.center), extent_(water.extent.size) {
    const scene::Waves& waves = water.surface.waves;
    for (const scene::Wave& wave : waves.waves) {
        if (wave.amplitude == 0) continue;
        const double k = 2 * std::numbers::pi / wave.length;
        components_.push_back({k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading)),
                               angular_frequency(k, waves.depth), wave.amplitude, wave.phase});
    }
    const auto columns = static_cast<std::size_t>(size_.cells_x) + 1;
    cosine_.resize(components_.size() * columns);
    sine_.resize(components_.size() * columns);
    parallel_for(components_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t w = begin; w < end; ++w) {
            for (std::size_t i = 0; i < columns; ++i) {
                const double angle = components_[w].k.x * grid_coordinate(center_.x, extent_.x,
                                                                          static_cast<int>(i), size_.cells_x);
                cosine_[w * columns + i] = std::cos(angle);
                sine_[w * columns + i] = std::sin(angle);
            }
        }
    });
}

SurfaceGrid WaveSum::grid(double time, FieldMask mask) const {
    SurfaceGrid grid;
    grid.rows = size_.cells_z + 1;
    grid.columns = size_.cells_x + 1;
    const std::vector<Field> fields = fields_of(mask);
    for (const Field field : fields) grid[field].resize(size_.vertices());
    const auto columns = static_cast<std::size_t>(grid.columns);

    const std::size_t waves = components_.size();
    std::vector<FieldFactor> factors;  // of each wave and field, wave-major
    for (const Component& wave : components_) {
        for (const Field field : fields) factors.push_back(field_factor(field, wave.k, wave.omega));
    }

    parallel_for(static_cast<std::size_t>(grid.rows), 4, [&](std::size_t begin, std::size_t end) {
        // A stretch of a row at a time keeps all sums in the first cache.
        constexpr std::size_t stretch = 256;
        std::array<double, stretch> c;
        std::array<double, stretch> d;
        std::vector<double> a_cos(waves);
        std::vector<double> a_sin(waves);
        for (std::size_t row = begin; row < end; ++row) {
            const double z = grid_coordinate(center_.y, extent_.y, static_cast<int>(row), size_.cells_z);
            for (std::size_t w = 0; w < waves; ++w) {
                const Component& wave = components_[w];
                const double angle = wave.k.y * z - wave.omega * time + wave.phase;
                a_cos[w] = wave.amplitude * std::cos(angle);
                a_sin[w] = wave.amplitude * std::sin(angle);
            }
            for (std::size_t first = 0; first < columns; first += stretch) {
                const std::size_t count = std::min(stretch, columns - first);
                for (std::size_t w = 0; w < waves; ++w) {
                    const double* cosine = cosine_.data() + w * columns + first;
                    const double* sine = sine_.data() + w * columns + first;
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

}  // namespace dapple::ocean
