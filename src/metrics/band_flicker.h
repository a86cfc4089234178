#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Flicker by band of temporal frequency: the power spectrum in time of D (luminance, or its error), mean
/// over pixels, by windows of kWindow frames (Hann, half overlapped, their own mean taken off: Welch 1967),
/// the last one ending at the last frame, summed into octaves. Memory is one window of luminance, whatever
/// the clip's length. What happens at the very ends of a clip weighs little, as Hann's window is 0 there.
class BandFlicker {
public:
    static constexpr int kWindow = 32;  ///< frames; a shorter clip is one window of its own length

    /// `fps` above 0.
    explicit BandFlicker(double fps);
    /// D of the next frame, all of one size. A window leaves out pixels that any of its frames excludes.
    void add(const std::vector<float>& values, const std::vector<std::uint32_t>& excluded = {});
    /// What is added next does not follow what was added last: windows end here as at the end of a clip, and
    /// begin anew. A window weighs as much as it has frames; a frame alone is none.
    void gap();

    struct Band {
        double low_hz = 0;
        double high_hz = 0;
        double energy = 0;  ///< mean over pixels of the variance in time within the band
    };
    /// Three octaves below half the frame rate, and what lies below them (the lowest is 2 of a window's
    /// frequencies wide), from low to high. The constant part belongs to none. A sine of amplitude a has
    /// energy a^2 / 2, and 99 % of it in its own band where it lies fps / 16 or more inside it.
    std::vector<Band> bands() const;

private:
    static constexpr int kBands = 4;
    struct Frame {
        std::vector<float> values;
        std::vector<std::uint32_t> excluded;
    };
    /// Mean over pixels of the energies of the last min(frames_, kWindow) frames.
    std::vector<double> window_energies() const;
    /// Adds that window, by its weight, to sums.
    void add_window(std::vector<double>& energies, double& weight) const;
    bool has_rest() const { return frames_ > last_window_end_ && frames_ > 1; }

    double fps_;
    std::size_t frames_ = 0;  ///< since the last gap
    std::vector<Frame> ring_;
    std::vector<double> energies_;  ///< sums over the windows so far, each by its weight
    double weight_ = 0;             ///< of these
    std::size_t last_window_end_ = 0;
};

}  // namespace dapple::metrics
