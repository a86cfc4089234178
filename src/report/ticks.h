#pragma once
#include <string>
#include <vector>

/// Round numbers for the axes of plots.
namespace dapple::report {

/// A range of values, low < high by more than 1e-9 of the larger.
struct Range {
    double low = 0;
    double high = 1;
};

/// Multiples of 1, 2 or 5 times a power of ten in the range, at most `most` (>= 2) of them and as many as
/// that allows, ascending.
std::vector<double> linear_ticks(Range range, int most);

/// Ticks of a logarithmic axis over a range of positive values: powers of ten; over less than two decades
/// also their doubles and fivefolds, and round multiples where even these are fewer than two; every second,
/// third, ... power of ten where there are more than `most`.
std::vector<double> log_ticks(Range range, int most);

/// Ticks as text, with as many digits as they have.
std::vector<std::string> tick_labels(const std::vector<double>& ticks);

}  // namespace dapple::report
