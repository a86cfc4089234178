#pragma once
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace dapple::judge {

/// A mean error that grows over the clip.
struct Drift {
    double per_frame = 0;  ///< slope
    double total = 0;      ///< over the clip
};

/// Whether a series of (frame, relative mean error) drifts: the slope of its least-squares line is
/// kDriftSigma times as large as its scatter about the line makes it uncertain, scatter that lasts over
/// frames counted as such (the residuals' autocorrelation at one step, with what is uncertain of it, widens
/// the uncertainty), and it makes kLeastDrift over the clip. Of first-order autoregressive scatter of
/// correlation 0.9 not one series of 100 drifts. `jumps`: frames whose change from the frame before is taken
/// out of the series, for it has another cause. Nothing below kLeastDriftFrames values.
inline constexpr double kDriftSigma = 6;
inline constexpr double kLeastDrift = 0.002;
inline constexpr std::size_t kLeastDriftFrames = 16;
std::optional<Drift> find_drift(const std::vector<std::pair<std::int64_t, double>>& errors,
                                const std::vector<std::int64_t>& jumps);

}  // namespace dapple::judge
