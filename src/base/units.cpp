#include "base/units.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <numbers>
#include <system_error>

#include "base/suggest.h"

namespace dapple {
namespace {

struct DimensionText {
    std::string_view name;
    std::string_view example;
    std::string_view si_unit;
};

DimensionText text_of(Dimension dimension) {
    switch (dimension) {
        case Dimension::number:
            return {"a number", "0.5", ""};
        case Dimension::length:
            return {"a length", "12 cm", "m"};
        case Dimension::angle:
            return {"an angle", "30 deg", "rad"};
        case Dimension::time:
            return {"a time", "2.5 s", "s"};
        case Dimension::speed:
            return {"a speed", "4 m/s", "m/s"};
        case Dimension::per_length:
            return {"a value per length", "0.2 /m", "/m"};
        case Dimension::wave_number:
            return {"a wave number", "6.3 rad/m", "rad/m"};
        case Dimension::irradiance:
            return {"an irradiance", "3 W/m2", "W/m2"};
        case Dimension::intensity:
            return {"a radiant intensity", "10 W/sr", "W/sr"};
        case Dimension::radiance:
            return {"a radiance", "0.2 W/m2/sr", "W/m2/sr"};
        case Dimension::frame_rate:
            return {"a frame rate", "24 fps", "fps"};
        case Dimension::exposure:
            return {"an exposure", "1.5 stops", "stops"};
    }
    return {};
}

/// value in SI = number * 10^decimal_exponent * factor. The power of ten is applied to the text, so that it
/// does not round.
struct Unit {
    std::string_view symbol;
    Dimension dimension;
    int decimal_exponent = 0;
    double multiplier = 1;
    double divisor = 1;
};

constexpr std::array kUnits{
    Unit{"%", Dimension::number, -2},
    Unit{"um", Dimension::length, -6},
    Unit{"mm", Dimension::length, -3},
    Unit{"cm", Dimension::length, -2},
    Unit{"m", Dimension::length},
    Unit{"km", Dimension::length, 3},
    Unit{"deg", Dimension::angle, 0, std::numbers::pi, 180},
    Unit{"rad", Dimension::angle},
    Unit{"mrad", Dimension::angle, -3},
    Unit{"ms", Dimension::time, -3},
    Unit{"s", Dimension::time},
    Unit{"min", Dimension::time, 0, 60},
    Unit{"cm/s", Dimension::speed, -2},
    Unit{"m/s", Dimension::speed},
    Unit{"km/h", Dimension::speed, 0, 1, 3.6},
    Unit{"/mm", Dimension::per_length, 3},
    Unit{"/cm", Dimension::per_length, 2},
    Unit{"/m", Dimension::per_length},
    Unit{"/km", Dimension::per_length, -3},
    Unit{"rad/cm", Dimension::wave_number, 2},
    Unit{"rad/m", Dimension::wave_number},
    Unit{"mW/m2", Dimension::irradiance, -3},
    Unit{"W/m2", Dimension::irradiance},
    Unit{"kW/m2", Dimension::irradiance, 3},
    Unit{"mW/sr", Dimension::intensity, -3},
    Unit{"W/sr", Dimension::intensity},
    Unit{"kW/sr", Dimension::intensity, 3},
    Unit{"mW/m2/sr", Dimension::radiance, -3},
    Unit{"W/m2/sr", Dimension::radiance},
    Unit{"kW/m2/sr", Dimension::radiance, 3},
    Unit{"fps", Dimension::frame_rate},
    Unit{"Hz", Dimension::frame_rate},
    Unit{"stops", Dimension::exposure},
    Unit{"stop", Dimension::exposure},
    Unit{"EV", Dimension::exposure},
};

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    return text;
}

/// Units are written "W/m2", "W/m^2", "W / m²" alike.
std::string normal_unit(std::string_view text) {
    std::string unit;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text.substr(i, 2) == "\xC2\xB2") {
            unit += '2';
            ++i;
        } else if (text[i] != ' ' && text[i] != '^') {
            unit += text[i];
        }
    }
    if (unit.substr(0, 2) == "1/") unit.erase(0, 1);
    return unit;
}

/// The parts of a decimal number at the head of a text.
struct Decimal {
    std::string mantissa;  ///< sign, digits, point
    int exponent = 0;
    std::string_view rest;  ///< what follows
    bool found = false;
    bool whole = true;  ///< neither point nor exponent
};

Decimal split_decimal(std::string_view text) {
    Decimal number;
    std::size_t i = 0;
    if (i < text.size() && (text[i] == '+' || text[i] == '-')) {
        if (text[i] == '-') number.mantissa = "-";
        ++i;
    }
    for (; i < text.size() && (is_digit(text[i]) || (text[i] == '.' && number.whole)); ++i) {
        number.found = number.found || is_digit(text[i]);
        number.whole = number.whole && text[i] != '.';
        number.mantissa += text[i];
    }
    if (!number.found) return number;
    if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
        std::size_t digits = i + 1;
        if (digits < text.size() && (text[digits] == '+' || text[digits] == '-')) ++digits;
        if (digits < text.size() && is_digit(text[digits])) {
            const std::size_t first = text[i + 1] == '+' ? i + 2 : i + 1;
            const auto [end, error] =
                std::from_chars(text.data() + first, text.data() + text.size(), number.exponent);
            if (error != std::errc() || number.exponent > 9999)
                number.exponent = 9999;  // fails as out of range
            if (number.exponent < -9999) number.exponent = -9999;
            i = static_cast<std::size_t>(end - text.data());
            number.whole = false;
        }
    }
    number.rest = text.substr(i);
    return number;
}

/// What is wrong with how the digits are written; empty: nothing.
std::string notation_fault(std::string_view text, const Decimal& number) {
    const std::string shown = in_quotes(text);
    const std::string_view digits =
        std::string_view(number.mantissa).substr(number.mantissa.front() == '-' ? 1 : 0);
    const std::string_view rest = number.rest;
    if (digits == "0" && !rest.empty() &&
        (rest[0] == 'x' || rest[0] == 'X' || rest[0] == 'o' || rest[0] == 'b'))
        return shown + " is no decimal number; write it in decimal digits";
    if (digits.size() > 1 && digits[0] == '0' && is_digit(digits[1]))
        return shown + " starts with 0, which some readers take as octal; leave the 0 out";
    if (!rest.empty() && rest[0] == '_') return shown + ": write the number without '_'";
    if (!rest.empty() && rest[0] == ':')
        return shown + ": ':' is not part of a number; write a time as '90 s'";
    if (rest.size() > 1 && rest[0] == ',' && is_digit(rest[1]))
        return shown + ": write a decimal point, not a comma";
    return {};
}

bool is_not_finite_word(std::string_view text) {
    if (!text.empty() && (text[0] == '-' || text[0] == '+')) text.remove_prefix(1);
    if (!text.empty() && text[0] == '.') text.remove_prefix(1);
    std::string word(text);
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return word == "nan" || word == "inf" || word == "infinity";
}

std::string expected(Dimension dimension) {
    const DimensionText text = text_of(dimension);
    return std::string("expected ").append(text.name).append(" such as ").append(in_quotes(text.example));
}

}  // namespace

double radians_from_degrees(double degrees) {
    return degrees * std::numbers::pi / 180;
}

std::string_view dimension_name(Dimension dimension) {
    return text_of(dimension).name;
}

std::vector<std::string_view> unit_symbols(Dimension dimension) {
    std::vector<std::string_view> symbols;
    for (const Unit& unit : kUnits)
        if (unit.dimension == dimension) symbols.push_back(unit.symbol);
    return symbols;
}

std::string format_quantity(double value, Dimension dimension) {
    const bool angle = dimension == Dimension::angle;
    const std::string_view unit = angle ? "deg" : text_of(dimension).si_unit;
    std::array<char, 40> digits{};
    std::snprintf(digits.data(), digits.size(), "%.6g", angle ? value * 180 / std::numbers::pi : value);
    return std::string(digits.data()) + (unit.empty() ? "" : " ") + std::string(unit);
}

Quantity parse_quantity(std::string_view text, Dimension dimension) {
    Quantity quantity;
    const std::string_view trimmed_text = trimmed(text);
    const std::string shown = in_quotes(trimmed_text);
    const Decimal number = split_decimal(trimmed_text);
    if (!number.found) {
        quantity.error = is_not_finite_word(trimmed_text) ? shown + ": a number must be finite"
                                                          : expected(dimension) + ", got " + shown;
        return quantity;
    }
    quantity.error = notation_fault(trimmed_text, number);
    if (!quantity.error.empty()) return quantity;

    Unit unit{"", dimension};
    if (const std::string symbol = normal_unit(number.rest); !symbol.empty()) {
        // One dimension's unit may be another's too ("/m"), so the right dimension is looked for first.
        const auto same_symbol = [&](const Unit& u) { return u.symbol == symbol; };
        auto found = std::find_if(kUnits.begin(), kUnits.end(),
                                  [&](const Unit& u) { return same_symbol(u) && u.dimension == dimension; });
        if (found == kUnits.end()) found = std::find_if(kUnits.begin(), kUnits.end(), same_symbol);
        if (found == kUnits.end()) {
            quantity.error = "unknown unit " + in_quotes(symbol) +
                             suggestion(symbol, unit_symbols(dimension),
                                        std::string(dimension_name(dimension)) + " takes:");
            return quantity;
        }
        if (found->dimension != dimension) {
            quantity.error = expected(dimension) + " (" + joined(unit_symbols(dimension)) + "); " + shown +
                             " is " + std::string(dimension_name(found->dimension));
            return quantity;
        }
        unit = *found;
        quantity.has_unit = true;
    }
    const std::string digits =
        number.mantissa + "e" + std::to_string(number.exponent + unit.decimal_exponent);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), quantity.value);
    if (error != std::errc()) quantity.error = shown + " is out of the range of numbers";
    quantity.value = quantity.value * unit.multiplier / unit.divisor;
    return quantity;
}

Integer parse_integer(std::string_view text) {
    Integer integer;
    const std::string_view trimmed_text = trimmed(text);
    const std::string shown = in_quotes(trimmed_text);
    const Decimal number = split_decimal(trimmed_text);
    if (number.found) integer.error = notation_fault(trimmed_text, number);
    if (!integer.error.empty()) return integer;
    if (!number.found || !number.whole || !number.rest.empty()) {
        integer.error = "expected a whole number, got " + shown;
        return integer;
    }
    const char* const last = number.mantissa.data() + number.mantissa.size();
    const auto [end, error] = std::from_chars(number.mantissa.data(), last, integer.value);
    if (error != std::errc()) integer.error = shown + " is out of the range of whole numbers";
    return integer;
}

}  // namespace dapple
