#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace dapple {

/// The place for the number in a pattern of file names: "%04d", "%d" or "####".
struct NumberPattern {
    std::size_t begin = 0;
    std::size_t length = 0;  ///< of the place; 0: there is none, or more than one
    std::size_t digits = 1;  ///< at least so many, with zeros in front
};

NumberPattern find_number(std::string_view pattern);

/// The text with `number` in that place of it.
std::string with_number(std::string text, const NumberPattern& place, std::int64_t number);

}  // namespace dapple
