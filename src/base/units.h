#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Numbers with units as people write them: "12 cm", "30 deg", "0.2 /m". Without a unit a number is SI
/// (angles: radians).
namespace dapple {

/// What a number measures, and so which units it takes.
enum class Dimension {
    number,  ///< a ratio; takes "%"
    length,
    angle,
    time,
    speed,
    per_length,   ///< absorption, scattering
    wave_number,  ///< rad/m
    irradiance,
    intensity,  ///< radiant intensity
    radiance,
    frame_rate,  ///< also a fraction such as 24000/1001
    exposure,    ///< stops
};

/// pi / 180 times `degrees`, rounded as parse_quantity rounds it.
double radians_from_degrees(double degrees);

/// "a length".
std::string_view dimension_name(Dimension dimension);
/// "um", "mm", "cm", "m", "km".
std::vector<std::string_view> unit_symbols(Dimension dimension);
/// The value with its unit for messages: angles in degrees, all else in SI.
std::string format_quantity(double value, Dimension dimension);

/// A number as read, or the sentence that says why it is none.
struct Quantity {
    double value = 0;       ///< SI
    bool has_unit = false;  ///< a unit was written
    std::string error;      ///< empty: fine
};

/// Reads a decimal number with an optional unit of `dimension`. The grammar is stricter than YAML 1.1's, in
/// which 010 is 8, 1:30 is 90 and .inf is a number: octal, hexadecimal, sexagesimal, underscores, decimal
/// commas, NaN and infinity are refused, with words on what to write. "12.3 cm" gives the same bits as
/// "0.123".
Quantity parse_quantity(std::string_view text, Dimension dimension);

struct Integer {
    std::int64_t value = 0;
    std::string error;  ///< empty: fine
};

/// Reads a decimal integer without unit, by the same rules.
Integer parse_integer(std::string_view text);

}  // namespace dapple
