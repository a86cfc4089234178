#include "timeline/key_path.h"

#include <algorithm>
#include <charconv>
#include <system_error>

namespace dapple::timeline {

KeyPath parse_key_path(std::string_view text) {
    KeyPath path;
    const auto fail = [&](std::size_t at, const char* message) {
        path.error = message;
        path.error_column = at + 1;
        return path;
    };
    std::size_t i = 0;
    while (i < text.size()) {
        if (text[i] == '[') {
            const std::size_t close = text.find(']', i);
            if (close == std::string_view::npos) return fail(i, "the ']' is missing");
            if (close == i + 1) return fail(i, "the brackets are empty; expected an index or a name");
            path.steps.push_back({std::string(text.substr(i + 1, close - i - 1)), true, i + 2});
            i = close + 1;
        } else {
            if (i > 0 && text[i] != '.') return fail(i, "expected '.' or '[' here");
            if (i > 0) ++i;
            const std::size_t end = std::min(text.find_first_of(".[", i), text.size());
            if (end == i) return fail(i, "a key is missing here");
            path.steps.push_back({std::string(text.substr(i, end - i)), false, i + 1});
            i = end;
        }
    }
    if (path.steps.empty()) return fail(0, "a key is missing here");
    return path;
}

std::size_t find_element(const input::LocatedNode& list, const PathStep& step) {
    std::size_t index = 0;
    const char* const end = step.name.data() + step.name.size();
    const auto [rest, error] = std::from_chars(step.name.data(), end, index);
    if (step.in_brackets && error == std::errc() && rest == end) return std::min(index, list.items.size());
    for (index = 0; index < list.items.size(); ++index) {
        const input::LocatedNode* name = list.items[index].find("name");
        if (name != nullptr && name->scalar == step.name) break;
    }
    return index;
}

const input::LocatedNode& nearest_node(const input::LocatedNode& root, std::string_view path) {
    const input::LocatedNode* node = &root;
    for (const PathStep& step : parse_key_path(path).steps) {
        const input::LocatedNode* next = node->find(step.name);
        if (node->kind == input::LocatedNode::Kind::sequence) {
            const std::size_t index = find_element(*node, step);
            next = index < node->items.size() ? &node->items[index] : nullptr;
        }
        if (next == nullptr) break;
        node = next;
    }
    return *node;
}

}  // namespace dapple::timeline
