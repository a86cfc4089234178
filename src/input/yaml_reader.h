#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "input/located_node.h"

namespace dapple::input {

/// Larger texts are refused unread.
inline constexpr std::size_t kMaxYamlBytes = std::size_t{16} << 20;

struct YamlFault {
    Place place;
    std::string key_path;  ///< empty where the fault belongs to no key
    std::string message;
};

/// A YAML text as a tree. Where `faults` is not empty the tree holds what could be read before or beside
/// them.
struct YamlDocument {
    LocatedNode root;
    std::vector<YamlFault> faults;
    bool broken_off = false;  ///< the last fault ended the reading; the tree is not whole
};

/// Reads one YAML document. yaml-cpp serves as the tokenizer only, because it accepts much that a person
/// would want to hear of: duplicate keys, merge keys left unresolved, second documents, invalid UTF-8, NUL
/// bytes, aliases of themselves, and aliases that unfold without end. All of these are faults here, as are
/// tags and keys that are no scalars. Aliases are unfolded into copies. `text_index` enters all places. Never
/// throws on account of the text.
YamlDocument read_yaml(std::string_view text, int text_index = 0);

}  // namespace dapple::input
