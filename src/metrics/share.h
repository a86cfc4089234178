#pragma once
#include <cmath>

namespace dapple::metrics {

/// `value` as a share of the size of `whole`: 0 where there is no value, infinite where there is no whole, so
/// that an error over black passes no limit.
inline double share_of(double value, double whole) {
    return value == 0 ? 0 : value / std::abs(whole);
}

}  // namespace dapple::metrics
