#pragma once
#include <cstddef>
#include <string>

#include "input/located_node.h"
#include "scene/schema.h"
#include "timeline/curve.h"
#include "timeline/fault_list.h"

/// Reads single values as the schema describes them. Each function reports what is wrong and then returns
/// false.
namespace dapple::timeline {

/// A value on its way from the text.
struct Source {
    const input::LocatedNode& node;
    const scene::Field& field;
    const std::string& key_path;
    FaultList& faults;

    void fault(const std::string& message) const { faults.add(node.place, key_path, message); }
};

/// How many numbers the field has.
std::size_t component_count(const scene::Components& numbers);

/// The numbers of a field at one instant: a number, or a list of `components`.
bool read_numbers(const Source& source, std::size_t components, Values& values);

/// All kinds but numbers, structures and lists, into `object`. Relative paths are resolved from `folder`.
bool read_value(const Source& source, const std::string& folder, void* object);

/// "expected a number, got a list".
std::string expected_but_got(const std::string& expected, const input::LocatedNode& node);

/// "must be above 0 m; got -1 m", or empty where `value` is in range.
std::string range_fault(const scene::Field& field, double value);

}  // namespace dapple::timeline
