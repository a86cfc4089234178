#include "report/ticks.h"

#include <cassert>
#include <cmath>
#include <initializer_list>

namespace dapple::report {
namespace {

/// 10^exponent as the nearest double; pow() may be off by a bit.
double power_of_ten(int exponent) {
    return exponent < 0 ? 1 / std::pow(10, -exponent) : std::pow(10, exponent);
}

/// Slack for ends of a range that are ticks themselves but for rounding.
constexpr double kSlack = 1e-9;

}  // namespace

std::vector<double> linear_ticks(Range range, int most) {
    assert(range.low < range.high && most >= 2);
    const double extent = range.high - range.low;
    // The first step that is wide enough: from a power of ten that is surely too narrow upwards.
    for (int exponent = static_cast<int>(std::floor(std::log10(extent / most))) - 1;; ++exponent) {
        for (const int factor : {1, 2, 5}) {
            const double step = factor * power_of_ten(exponent);
            const double first = std::ceil(range.low / step - kSlack),
                         last = std::floor(range.high / step + kSlack);
            if (last - first + 1 > most) continue;
            std::vector<double> ticks;
            for (double i = first; i <= last; ++i) {
                // A quotient where the step is no whole number: 3 / 10 is 0.3, 3 * 0.1 is not.
                ticks.push_back(exponent < 0 ? i * factor / power_of_ten(-exponent) : i * step);
            }
            return ticks;
        }
    }
}

std::vector<double> log_ticks(Range range, int most) {
    assert(range.low > 0 && range.low < range.high && most >= 2);
    const double low = std::log10(range.low), high = std::log10(range.high);
    const int first = static_cast<int>(std::floor(low)), last = static_cast<int>(std::ceil(high));
    std::vector<double> ticks;
    const auto add = [&](double value) {
        if (value >= range.low * (1 - kSlack) && value <= range.high * (1 + kSlack)) ticks.push_back(value);
    };
    if (high - low < 2) {
        for (int exponent = first; exponent <= last; ++exponent) {
            for (const int factor : {1, 2, 5}) add(factor * power_of_ten(exponent));
        }
        return ticks.size() < 2 ? linear_ticks(range, most) : ticks;
    }
    const int decades = last - first + 1;
    const int step = (decades + most - 1) / most;
    for (int exponent = first; exponent <= last; ++exponent) {
        if (exponent % step == 0) add(power_of_ten(exponent));
    }
    return ticks;
}

}  // namespace dapple::report
