#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "input/located_node.h"
#include "timeline/timeline.h"

namespace dapple::timeline {

/// Collects the faults of one timeline and gives each its source line.
class FaultList {
public:
    /// `name` and `text` of the file, and the overrides; all must outlive the list.
    FaultList(const std::string& name, std::string_view text, const std::vector<std::string>& overrides);

    void add(const input::Place& place, const std::string& key_path, const std::string& message);
    bool empty() const { return faults_.empty(); }
    /// Throws TimelineError with what was added, in the order of the places.
    [[noreturn]] void raise();

private:
    struct Placed {
        input::Place place;
        Fault fault;
    };
    const std::string& name_;
    std::string_view text_;
    const std::vector<std::string>& overrides_;
    std::vector<Placed> faults_;
};

}  // namespace dapple::timeline
