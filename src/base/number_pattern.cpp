#include "base/number_pattern.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "base/error.h"

namespace dapple {
namespace {

constexpr std::size_t kMostDigits = 18;  // more do not fit the number

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/// The place that begins at `begin`, if one does.
NumberPattern place_at(std::string_view text, std::size_t begin) {
    NumberPattern place{begin, 0, 1};
    if (text[begin] == '#') {
        place.length = std::min(text.find_first_not_of('#', begin), text.size()) - begin;
        place.digits = place.length;
    } else if (text[begin] == '%') {
        std::size_t end = begin + 1;
        std::size_t digits = 0;
        while (end < text.size() && is_digit(text[end]) && digits <= kMostDigits)
            digits = 10 * digits + static_cast<std::size_t>(text[end++] - '0');
        if (end < text.size() && text[end] == 'd') place.length = end + 1 - begin;
        place.digits = std::max<std::size_t>(digits, 1);
    }
    if (place.digits > kMostDigits) place.length = 0;
    return place;
}

}  // namespace

NumberPattern find_number(std::string_view pattern) {
    NumberPattern found;
    for (std::size_t i = 0; i < pattern.size(); ++i) {
        const NumberPattern place = place_at(pattern, i);
        if (place.length == 0) continue;
        if (found.length != 0) return {};
        found = place;
        i += place.length - 1;
    }
    return found;
}

std::string with_number(std::string text, const NumberPattern& place, std::int64_t number) {
    std::string digits = std::to_string(number);
    if (digits.size() < place.digits) digits.insert(0, place.digits - digits.size(), '0');
    return text.replace(place.begin, place.length, digits);
}

std::string held_file(std::int64_t number, std::int64_t first,
                      const std::function<std::string(std::int64_t)>& name) {
    constexpr std::int64_t longest_hold = 10000;  // a wrong pattern must not cost millions of looks
    for (std::int64_t n = number; n >= std::max(first, number - longest_hold); --n) {
        std::string path = name(n);
        std::error_code ignored;  // a folder that cannot be read shows when the file is
        if (std::filesystem::exists(path, ignored)) return path;
    }
    throw Error(ExitCode::input_unreadable,
                clipped(name(number)) + ": no such file, and none before it to hold");
}

}  // namespace dapple
