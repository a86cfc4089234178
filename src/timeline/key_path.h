#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "input/located_node.h"

namespace dapple::timeline {

/// One step of a path such as "lights[0].elevation" or "lights.sun.elevation".
struct PathStep {
    std::string name;  ///< a key, or the name of a list's element; digits in brackets are an index
    bool in_brackets = false;
    std::size_t column = 1;  ///< where the step begins in the path's text
};

/// A path cut into steps; `error` says why it is none.
struct KeyPath {
    std::vector<PathStep> steps;
    std::string error;
    std::size_t error_column = 1;
};

KeyPath parse_key_path(std::string_view text);

/// Index of the element of `list` that the step means, by its number or by the element's `name`; the list's
/// size where there is none.
std::size_t find_element(const input::LocatedNode& list, const PathStep& step);

/// The node that the path leads to, or the last one on the way to it that there is.
const input::LocatedNode& nearest_node(const input::LocatedNode& root, std::string_view path);

}  // namespace dapple::timeline
