#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "report/heat_map.h"
#include "report/ticks.h"

namespace dapple::report {
namespace {

std::string printed(double value, std::chars_format format, int digits) {
    char text[400];  // 1e308 in full has 309 digits
    return {text, std::to_chars(text, text + sizeof text, value, format, digits).ptr};
}

/// "0.2500" is "0.25", "1.00e-05" is "1e-05".
std::string without_zeros(std::string text) {
    const std::size_t point = text.find('.');
    if (point == std::string::npos) return text;
    const std::size_t end = std::min(text.find('e'), text.size());
    std::size_t keep = text.find_last_not_of('0', end - 1);
    if (keep != point) ++keep;
    return text.erase(keep, end - keep);
}

/// With so many digits, in the shorter form.
std::string rounded(double value, int digits) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    if (value == 0) return "0";
    const std::string scientific = printed(value, std::chars_format::scientific, digits - 1);
    const double kept = std::strtod(scientific.c_str(), nullptr);
    const int exponent = std::atoi(scientific.c_str() + scientific.find('e') + 1);
    const std::string with_exponent = without_zeros(scientific);
    const std::string plain =
        without_zeros(printed(kept, std::chars_format::fixed, std::max(digits - 1 - exponent, 0)));
    return plain.size() <= with_exponent.size() ? plain : with_exponent;
}

}  // namespace

std::string short_number(double value) {
    return rounded(value, 3);
}

std::vector<std::string> tick_labels(const std::vector<double>& ticks) {
    constexpr int kMostDigits = 12;  // ticks are no closer (Range)
    std::vector<std::string> labels;
    for (int digits = 3; digits <= kMostDigits; ++digits) {
        labels.clear();
        bool exact = true;
        for (const double tick : ticks) {
            labels.push_back(rounded(tick, digits));
            exact &= std::abs(std::strtod(labels.back().c_str(), nullptr) - tick) <= 1e-9 * std::abs(tick);
        }
        if (exact) break;
    }
    return labels;
}

}  // namespace dapple::report
