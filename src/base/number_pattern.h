#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
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

/// Of the files name(number), name(number - 1), ... name(first) the first that exists, where one of the next
/// 10 000 does: what a sequence with gaps shows at a number when its files hold. Throws
/// Error(input_unreadable) where none is there.
std::string held_file(std::int64_t number, std::int64_t first,
                      const std::function<std::string(std::int64_t)>& name);

}  // namespace dapple
