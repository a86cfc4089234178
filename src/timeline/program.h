#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scene/frame_state.h"
#include "scene/schema.h"
#include "timeline/curve.h"

namespace dapple::timeline {

/// Where a struct stands in a FrameState: the maps and list elements that lead to it. It holds for every
/// FrameState with the same lists, so it is resolved anew for each frame.
struct Step {
    const scene::Field* field = nullptr;  ///< a structure or a list
    std::size_t index = 0;                ///< in a list
};
using Address = std::vector<Step>;

void* resolve(scene::FrameState& state, const Address& address);

/// A keyed field.
struct Track {
    Address owner;
    const scene::Field* field;
    std::string key_path;
    Curve curve;
};

/// A struct with values that follow from others.
struct Derivation {
    Address owner;
    const scene::Structure* structure;
    std::vector<std::string_view> given;
};

/// What a timeline boils down to: a state of constants, and what to change in it for a frame.
struct Program {
    scene::FrameState base;
    std::vector<Track> tracks;
    std::vector<Derivation> derivations;
    std::set<std::string, std::less<>> given;  ///< key paths that the timeline holds
};

/// Seconds from the clip's first frame to `frame` (which may be fractional or outside the clip). Rounded
/// once, so that a key in frames and the frame itself have the same bits.
double time_of_frame(const scene::Clip& clip, double frame);

/// The state of one frame. Pure.
scene::FrameState evaluate(const Program& program, std::int64_t frame);

/// "parent.key".
std::string join(const std::string& parent, std::string_view key);
/// "list[2]".
std::string join(const std::string& list, std::size_t index);

/// Name of the value of the structure's type key; empty where it has none.
std::string_view type_of(const scene::Structure& structure, const void* object);

/// Calls `visit` for each field of the schema that applies to `state` (its type is the one in use, its map is
/// there), maps and list elements unfolded; `object` is the struct that the field stands in.
using FieldVisitor =
    std::function<void(const scene::Field& field, void* object, const std::string& key_path)>;
void visit_fields(scene::FrameState& state, const FieldVisitor& visit);

}  // namespace dapple::timeline
