#include "timeline/overrides.h"

#include <string_view>
#include <utility>

#include "base/suggest.h"
#include "input/yaml_reader.h"
#include "timeline/key_path.h"

namespace dapple::timeline {
namespace {

using input::LocatedNode;
using input::Place;

std::string element_fault(const LocatedNode& list, const PathStep& step) {
    std::vector<std::string_view> names;
    for (const LocatedNode& item : list.items)
        if (const LocatedNode* name = item.find("name")) names.emplace_back(name->scalar);
    std::string text = "the list has no element " + in_quotes(step.name);
    const std::size_t size = list.items.size();
    text += size == 0 ? "; it is empty" : "; its indices are 0 to " + std::to_string(size - 1);
    return names.empty() ? text : text + suggestion(step.name, names, "its names are:");
}

/// The node that the step leads to, made where a key is not there; null where it cannot be.
LocatedNode* descend(LocatedNode& node, const PathStep& step, const Place& place, const std::string& path,
                     FaultList& faults) {
    if (node.kind == LocatedNode::Kind::sequence) {
        const std::size_t index = find_element(node, step);
        if (index < node.items.size()) return &node.items[index];
        faults.add(place, path, element_fault(node, step));
        return nullptr;
    }
    if (node.kind == LocatedNode::Kind::scalar) {
        faults.add(place, path,
                   in_quotes(step.name) + " leads into a single value, " + in_quotes(node.scalar));
        return nullptr;
    }
    if (LocatedNode* known = node.find(step.name)) return known;
    node.kind = LocatedNode::Kind::map;
    LocatedNode made;
    made.kind = LocatedNode::Kind::map;
    made.place = made.key_place = place;
    node.entries.push_back({step.name, std::move(made)});
    return &node.entries.back().value;
}

void apply(const std::string& text, int text_index, LocatedNode& root, FaultList& faults) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
        faults.add({text_index, 1, 1}, "", "expected path=value, such as camera.field_of_view=40 deg");
        return;
    }
    const std::string path = text.substr(0, equals);
    const KeyPath steps = parse_key_path(path);
    if (!steps.error.empty()) {
        faults.add({text_index, 1, static_cast<int>(steps.error_column)}, "", steps.error);
        return;
    }
    // Blanks in place of the path keep the columns of the override's text.
    const std::string padded = std::string(equals + 1, ' ') + text.substr(equals + 1);
    input::YamlDocument value = input::read_yaml(padded, text_index);
    for (const input::YamlFault& fault : value.faults) faults.add(fault.place, path, fault.message);
    if (!value.faults.empty()) return;

    LocatedNode* node = &root;
    Place place{text_index, 1, 1};
    for (const PathStep& step : steps.steps) {
        place.column = static_cast<int>(step.column);
        node = descend(*node, step, place, path, faults);
        if (node == nullptr) return;
    }
    *node = std::move(value.root);
    node->key_place = place;
    if (node->kind == LocatedNode::Kind::empty) node->place = place;
}

}  // namespace

void apply_overrides(const std::vector<std::string>& overrides, LocatedNode& root, FaultList& faults) {
    for (std::size_t i = 0; i < overrides.size(); ++i)
        apply(overrides[i], static_cast<int>(i) + 1, root, faults);
}

}  // namespace dapple::timeline
