#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace dapple::run {

/// A number as all JSON files of dapple have it: JSON itself knows no infinity, which becomes "inf", "-inf"
/// or "nan" and not null, so that it is not taken for a figure that is missing.
inline nlohmann::ordered_json json_number(double value) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    return value;
}

}  // namespace dapple::run
