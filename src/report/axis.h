#pragma once
#include <limits>
#include <vector>

namespace dapple::report {

/// One axis of a plot, from values to pixels. First include() all values, then finish() and place() it.
class Axis {
public:
    explicit Axis(bool log) : log_(log) {}

    /// Finite, and positive where the axis is logarithmic.
    bool shows(double value) const;
    void include(double value);
    bool empty() const { return low_ > high_; }

    enum class Start { values, zero };
    /// Widens a single value to a range and leaves a margin of `share` at both ends. Start::zero: a linear
    /// axis begins at 0 where values come near to it and are never negative.
    void finish(double share, Start start);
    /// Pixels of the ends.
    void place(double at_low, double at_high);

    /// Round values, at most `most` (report/ticks.h).
    std::vector<double> ticks(int most) const;
    /// All of 2, ..., 9 times a power of ten of a logarithmic axis, where they are few enough to read a value
    /// by.
    std::vector<double> fine_ticks() const;
    double operator()(double value) const;

private:
    bool log_;
    double low_ = std::numeric_limits<double>::infinity();
    double high_ = -std::numeric_limits<double>::infinity();
    double at_low_ = 0, at_high_ = 1;
};

}  // namespace dapple::report
