#include "report/axis.h"

#include <algorithm>
#include <cmath>

#include "report/ticks.h"

namespace dapple::report {

bool Axis::shows(double value) const {
    return std::isfinite(value) && (!log_ || value > 0);
}

void Axis::include(double value) {
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
}

void Axis::finish(double share, Start start) {
    // Below, the range is rounding: no ticks could be told apart.
    const bool one_value = high_ - low_ <= 1e-9 * std::max(std::abs(low_), std::abs(high_));
    if (log_) {
        if (one_value) {
            low_ /= 2;
            high_ *= 2;
        }
        const double factor = std::pow(high_ / low_, share);
        low_ /= factor;
        high_ *= factor;
        return;
    }
    if (one_value) {
        const double half = low_ == 0 ? 1 : std::abs(low_) / 2;
        low_ -= half;
        high_ += half;
    }
    const double margin = share * (high_ - low_);
    low_ = start == Start::zero && low_ >= 0 && low_ < 0.25 * high_ ? 0 : low_ - margin;
    high_ += margin;
}

void Axis::place(double at_low, double at_high) {
    at_low_ = at_low;
    at_high_ = at_high;
}

std::vector<double> Axis::ticks(int most) const {
    return log_ ? log_ticks({low_, high_}, most) : linear_ticks({low_, high_}, most);
}

std::vector<double> Axis::fine_ticks() const {
    std::vector<double> fine;
    if (!log_ || high_ / low_ > 1e6) return fine;
    for (double decade = std::pow(10, std::floor(std::log10(low_))); decade < high_; decade *= 10) {
        for (int i = 2; i < 10; ++i) {
            if (i * decade > low_ && i * decade < high_) fine.push_back(i * decade);
        }
    }
    return fine;
}

double Axis::operator()(double value) const {
    const double share =
        log_ ? std::log(value / low_) / std::log(high_ / low_) : (value - low_) / (high_ - low_);
    return at_low_ + share * (at_high_ - at_low_);
}

}  // namespace dapple::report
