#include "metrics/band_flicker.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <numbers>

#include "metrics/counted.h"

namespace dapple::metrics {
namespace {

constexpr std::size_t kMostFrames = BandFlicker::kWindow;
/// Pixels that are transformed together: their frames stay in the first cache.
constexpr std::size_t kBlock = 128;

/// Hann's window times the rows of the discrete Fourier transform, from frequency 1 to half the length,
/// scaled so that the squares of a row's values add up to the variance at its frequency (Welch 1967,
/// one-sided).
struct Transform {
    struct Row {
        std::array<float, kMostFrames> real{}, imaginary{};
    };
    std::vector<Row> rows;

    explicit Transform(std::size_t length) {
        const auto n = static_cast<double>(length);
        const auto window = [&](std::size_t t) {
            return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(t) / n);
        };
        double squares = 0;
        for (std::size_t t = 0; t < length; ++t) squares += window(t) * window(t);
        for (std::size_t k = 1; k <= length / 2; ++k) {
            const double sides = 2 * k == length ? 1 : 2;
            const double scale = std::sqrt(sides / (n * squares));
            Row& row = rows.emplace_back();
            for (std::size_t t = 0; t < length; ++t) {
                const double angle = 2 * std::numbers::pi * static_cast<double>(k * t % length) / n;
                row.real[t] = static_cast<float>(scale * window(t) * std::cos(angle));
                row.imaginary[t] = static_cast<float>(scale * window(t) * std::sin(angle));
            }
        }
    }
};

/// By frequency, of a few pixels.
struct Spectrum {
    std::array<double, kMostFrames / 2> energies{};
    void operator+=(const Spectrum& other) {
        for (std::size_t i = 0; i < energies.size(); ++i) energies[i] += other.energies[i];
    }
};

/// Up to kBlock pixels over time, each less its mean.
class Block {
public:
    void load(const std::vector<const float*>& frames, std::size_t first, std::size_t count) {
        length_ = frames.size();
        std::array<float, kBlock> mean{};
        for (std::size_t t = 0; t < length_; ++t) {
            // The first frame is taken off before, so that what does not change is 0 to the last bit.
            for (std::size_t i = 0; i < count; ++i) {
                values_[t][i] = frames[t][first + i] - frames[0][first + i];
            }
            for (std::size_t i = count; i < kBlock; ++i) values_[t][i] = 0;
            for (std::size_t i = 0; i < kBlock; ++i) mean[i] += values_[t][i];
        }
        for (std::size_t t = 0; t < length_; ++t) {
            for (std::size_t i = 0; i < kBlock; ++i) values_[t][i] -= mean[i] / static_cast<float>(length_);
        }
    }

    void add_to(Spectrum& spectrum, const Transform& transform) const {
        for (std::size_t k = 0; k < transform.rows.size(); ++k) {
            const Transform::Row& row = transform.rows[k];
            std::array<float, kBlock> real{}, imaginary{};
            for (std::size_t t = 0; t < length_; ++t) {
                for (std::size_t i = 0; i < kBlock; ++i) {
                    real[i] += row.real[t] * values_[t][i];
                    imaginary[i] += row.imaginary[t] * values_[t][i];
                }
            }
            double energy = 0;
            for (std::size_t i = 0; i < kBlock; ++i) {
                energy += static_cast<double>(real[i] * real[i] + imaginary[i] * imaginary[i]);
            }
            spectrum.energies[k] += energy;
        }
    }

private:
    std::size_t length_ = 0;
    std::array<std::array<float, kBlock>, kMostFrames> values_;
};

}  // namespace

BandFlicker::BandFlicker(double fps) : fps_(fps), energies_(kBands) {
    assert(fps > 0);
}

void BandFlicker::add(const std::vector<float>& values, const std::vector<std::uint32_t>& excluded) {
    assert(ring_.empty() || ring_.front().values.size() == values.size());
    if (ring_.size() < kMostFrames) ring_.emplace_back();
    ring_[frames_ % kMostFrames] = {values, excluded};
    ++frames_;
    if (frames_ < kMostFrames || frames_ % (kMostFrames / 2) != 0) return;
    add_window(energies_, weight_);
    last_window_end_ = frames_;
}

void BandFlicker::gap() {
    if (has_rest()) add_window(energies_, weight_);
    ring_.clear();
    frames_ = 0;
    last_window_end_ = 0;
}

void BandFlicker::add_window(std::vector<double>& energies, double& weight) const {
    const std::vector<double> window = window_energies();
    const auto frames = static_cast<double>(ring_.size());
    for (std::size_t band = 0; band < kBands; ++band) energies[band] += frames * window[band];
    weight += frames;
}

std::vector<double> BandFlicker::window_energies() const {
    const std::size_t length = ring_.size();
    std::vector<const float*> frames;
    std::vector<std::uint32_t> excluded;
    for (std::size_t age = length; age > 0; --age) {
        const Frame& frame = ring_[(frames_ - age) % length];
        frames.push_back(frame.values.data());
        std::vector<std::uint32_t> both;
        std::ranges::set_union(excluded, frame.excluded, std::back_inserter(both));
        excluded = std::move(both);
    }
    const std::size_t pixels = ring_.front().values.size();
    const Transform transform(length);
    const auto sums =
        sum_counted<Spectrum>(pixels, excluded, [&](Spectrum& tile, std::size_t first, std::size_t last) {
            Block block;
            for (std::size_t begin = first; begin < last; begin += kBlock) {
                block.load(frames, begin, std::min(kBlock, last - begin));
                block.add_to(tile, transform);
            }
        });

    std::vector<double> energies(kBands);
    const auto counted = static_cast<double>(std::max<std::size_t>(1, pixels - excluded.size()));
    for (std::size_t k = 1; k <= length / 2; ++k) {
        // Octaves of the full window below frequency 16: from 8, 4, 2, and 0 on.
        const std::size_t place = k * kMostFrames / length;
        const std::size_t band = place >= 8 ? 3 : place >= 4 ? 2 : place >= 2 ? 1 : 0;
        energies[band] += sums.energies[k - 1] / counted;
    }
    return energies;
}

std::vector<BandFlicker::Band> BandFlicker::bands() const {
    std::vector<double> energies = energies_;
    double weight = weight_;
    if (has_rest()) add_window(energies, weight);
    std::vector<Band> bands(kBands);
    for (std::size_t band = 0; band < kBands; ++band) {
        bands[band].low_hz = band == 0 ? 0 : fps_ / static_cast<double>(2 << (kBands - band));
        bands[band].high_hz = fps_ / static_cast<double>(2 << (kBands - 1 - band));
        bands[band].energy = weight > 0 ? energies[band] / weight : 0;
    }
    return bands;
}

}  // namespace dapple::metrics
