#include "timeline/curve_reader.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "base/suggest.h"
#include "timeline/program.h"

namespace dapple::timeline {
namespace {

using input::LocatedNode;
using scene::Field;
using scene::FieldKind;

/// The parts of a curve's text have no place in a FrameState, so they are described here.
Field part(std::string_view key, FieldKind kind, Dimension dimension = Dimension::number) {
    Field field;
    field.key = key;
    field.kind = kind;
    field.dimension = dimension;
    return field;
}

const std::vector<std::string_view>& interpolations() {
    static const std::vector<std::string_view> names{"step", "linear", "cubic", "bezier"};
    return names;
}

class CurveReader {
public:
    CurveReader(const Source& source, std::size_t components, const scene::Clip& clip)
        : source_(source), components_(components), clip_(clip) {}

    std::optional<Curve> read() {
        const LocatedNode* list = source_.node.find("keys");
        const auto& entries = source_.node.entries;
        const bool misspelt = std::any_of(
            entries.begin(), entries.end(),
            [](const LocatedNode::Entry& entry) { return !nearest(entry.key, {"keys"}).empty(); });
        if (list != nullptr || misspelt)
            check_keys(source_.node, source_.key_path, "a curve", {"keys", "interpolation"});
        if (list == nullptr) {
            if (!misspelt)
                fault(source_.node.key_place, source_.key_path,
                      "expected a value or {keys: [{frame: 1, value: ...}, ...]}; there is no 'keys'");
            return std::nullopt;
        }
        if (const LocatedNode* node = source_.node.find("interpolation"))
            read_interpolation(*node, join(source_.key_path, "interpolation"), default_interpolation_);

        const std::string list_path = join(source_.key_path, "keys");
        if (list->kind != LocatedNode::Kind::sequence || list->items.empty()) {
            fault(list->place, list_path,
                  list->items.empty() && list->kind == LocatedNode::Kind::sequence
                      ? "a curve needs at least one key"
                      : expected_but_got("a list of keys, {frame: 1, value: ...}", *list));
            return std::nullopt;
        }
        for (std::size_t i = 0; i < list->items.size(); ++i) read_key(list->items[i], join(list_path, i));
        if (fine_) check_handles(*list, list_path);
        if (!fine_) return std::nullopt;
        return Curve(std::move(keys_), components_);
    }

private:
    void read_key(const LocatedNode& node, const std::string& path) {
        if (node.kind != LocatedNode::Kind::map) {
            fault(node.place, path, expected_but_got("a key such as {frame: 1, value: ...}", node));
            return;
        }
        check_keys(node, path, "a key", {"frame", "time", "value", "interpolation", "out", "in"});
        Key key;
        key.interpolation = default_interpolation_;
        if (const LocatedNode* own = node.find("interpolation"))
            read_interpolation(*own, join(path, "interpolation"), key.interpolation);
        if (const LocatedNode* handle = node.find("out")) read_handle(*handle, join(path, "out"), key.out);
        if (const LocatedNode* handle = node.find("in")) read_handle(*handle, join(path, "in"), key.in);

        if (const LocatedNode* value = node.find("value")) {
            const std::string value_path = join(path, "value");
            if (!read_numbers({*value, source_.field, value_path, source_.faults}, components_, key.values))
                fine_ = false;
        } else {
            fault(node.key_place, path, "the key has no 'value'");
        }
        if (read_time(node, path, key.time)) {
            if (last_time_ && key.time <= *last_time_)
                fault(time_node(node)->place, path,
                      key.time == *last_time_
                          ? "there is a key at this time already"
                          : "keys stand in order of time; this one is earlier than the one before");
            last_time_ = key.time;
        }
        keys_.push_back(key);
    }

    static const LocatedNode* time_node(const LocatedNode& key) {
        const LocatedNode* frame = key.find("frame");
        return frame != nullptr ? frame : key.find("time");
    }

    bool read_time(const LocatedNode& key, const std::string& path, double& time) {
        const LocatedNode* node = time_node(key);
        if (node == nullptr || (key.find("frame") != nullptr && key.find("time") != nullptr)) {
            fault(key.key_place, path,
                  node == nullptr ? "the key has no 'frame' or 'time'"
                                  : "give the key's 'frame' or its 'time', not both");
            return false;
        }
        const bool in_frames = key.find("frame") != nullptr;
        static const Field kFrame = part("frame", FieldKind::numbers);
        static const Field kTime = part("time", FieldKind::numbers, Dimension::time);
        const std::string node_path = join(path, in_frames ? "frame" : "time");
        Values values{};
        if (!read_numbers({*node, in_frames ? kFrame : kTime, node_path, source_.faults}, 1, values)) {
            fine_ = false;
            return false;
        }
        time = in_frames ? time_of_frame(clip_, values[0]) : values[0];
        return true;
    }

    void read_interpolation(const LocatedNode& node, const std::string& path, Interpolation& interpolation) {
        const auto& names = interpolations();
        if (node.kind != LocatedNode::Kind::scalar) {
            fault(node.place, path, expected_but_got("one of " + joined(names), node));
            return;
        }
        const auto found = std::find(names.begin(), names.end(), node.scalar);
        if (found == names.end())
            fault(node.place, path,
                  "unknown interpolation " + in_quotes(node.scalar) + suggestion(node.scalar, names));
        else
            interpolation = static_cast<Interpolation>(found - names.begin());
    }

    void read_handle(const LocatedNode& node, const std::string& path, glm::dvec2& handle) {
        static const Field kHandle = part("handle", FieldKind::numbers);
        Values values{};
        if (!read_numbers({node, kHandle, path, source_.faults}, 2, values)) {
            fine_ = false;
            return;
        }
        if (!(values[0] >= 0 && values[0] <= 1))
            fault(node.place, path,
                  "the first number of a handle is a share of the time to the next key, from 0 to 1");
        handle = {values[0], values[1]};
    }

    /// Handles stand only at bezier segments, and keep what they bend within the range of the field.
    void check_handles(const LocatedNode& list, const std::string& list_path) {
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            const bool leaves = i + 1 < keys_.size() && keys_[i].interpolation == Interpolation::bezier;
            const bool arrives = i > 0 && keys_[i - 1].interpolation == Interpolation::bezier;
            const std::string path = join(list_path, i);
            if (const LocatedNode* out = list.items[i].find("out"); out != nullptr && !leaves)
                fault(out->place, join(path, "out"),
                      "no bezier segment starts here; set 'interpolation: bezier'");
            if (const LocatedNode* in = list.items[i].find("in"); in != nullptr && !arrives)
                fault(in->place, join(path, "in"),
                      "no bezier segment ends here; set 'interpolation: bezier'");
            if (leaves) check_reach(keys_[i], keys_[i + 1], list.items[i].place, path);
        }
    }

    /// A Bezier curve stays in the hull of its control points, so these are what must be in range.
    void check_reach(const Key& key, const Key& next, const input::Place& place, const std::string& path) {
        for (std::size_t c = 0; c < components_; ++c) {
            for (const double share : {key.out.y, next.in.y}) {
                const double reached = key.values[c] + share * (next.values[c] - key.values[c]);
                const std::string message = range_fault(source_.field, reached);
                if (message.empty()) continue;
                fault(place, path, "the handles to the next key reach too far: the value " + message);
                return;
            }
        }
    }

    void check_keys(const LocatedNode& node, const std::string& path, const std::string& what,
                    const std::vector<std::string_view>& known) {
        for (const LocatedNode::Entry& entry : node.entries)
            if (std::find(known.begin(), known.end(), entry.key) == known.end())
                fault(entry.value.key_place, join(path, entry.key),
                      "unknown key" + suggestion(entry.key, known, what + " takes:"));
    }

    void fault(const input::Place& place, const std::string& path, const std::string& message) {
        source_.faults.add(place, path, message);
        fine_ = false;
    }

    const Source& source_;
    std::size_t components_;
    const scene::Clip& clip_;
    Interpolation default_interpolation_ = Interpolation::linear;
    std::vector<Key> keys_;
    std::optional<double> last_time_;
    bool fine_ = true;
};

}  // namespace

std::optional<Curve> read_curve(const Source& source, std::size_t components, const scene::Clip& clip) {
    return CurveReader(source, components, clip).read();
}

}  // namespace dapple::timeline
