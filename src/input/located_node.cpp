#include "input/located_node.h"

#include <algorithm>
#include <utility>

namespace dapple::input {

const LocatedNode* LocatedNode::find(std::string_view key) const {
    const auto entry =
        std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.key == key; });
    return entry == entries.end() ? nullptr : &entry->value;
}

LocatedNode* LocatedNode::find(std::string_view key) {
    return const_cast<LocatedNode*>(std::as_const(*this).find(key));
}

}  // namespace dapple::input
