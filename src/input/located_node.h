#pragma once
#include <string>
#include <string_view>
#include <vector>

/// Text files that people write, as trees whose every node knows its place, and meshes read from files.
namespace dapple::input {

/// Where something stands. Lines and columns count from 1, columns in characters; line 0: nowhere.
struct Place {
    int text = 0;  ///< which text: 0 the file, n the n-th override
    int line = 0;
    int column = 0;
};

/// One value of a YAML document. Empty values stand at the place of their key.
struct LocatedNode {
    enum class Kind { empty, scalar, sequence, map };
    struct Entry;

    Kind kind = Kind::empty;
    Place place;         ///< of the value
    Place key_place;     ///< of the key whose value this is; of the value itself where there is no key
    std::string scalar;  ///< as written, quotes and escapes resolved
    std::vector<LocatedNode> items;  ///< of a sequence
    std::vector<Entry> entries;      ///< of a map, in the order of the text; keys are unique

    const LocatedNode* find(std::string_view key) const;
    LocatedNode* find(std::string_view key);
};

struct LocatedNode::Entry {
    std::string key;
    LocatedNode value;
};

}  // namespace dapple::input
