#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace dapple {

/// Number of single-character insertions, removals, replacements and swaps of neighbours that turn `a` into
/// `b`, no stretch being edited twice (Damerau-Levenshtein in its optimal-string-alignment form).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate nearest to `word`, case and hyphens aside; empty where none is near enough to be meant: a
/// third of the word's length, at least 2, but 1 for words of three characters or fewer.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates);

/// "'word'".
std::string in_quotes(std::string_view word);

/// "a, b, c".
std::string joined(const std::vector<std::string_view>& words);

/// "; did you mean 'near'?" where a candidate is near, else "; <lead> a, b, c".
std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates,
                       std::string_view lead = "expected one of:");

}  // namespace dapple
