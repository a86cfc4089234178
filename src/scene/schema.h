#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "scene/frame_state.h"

/// The one description of what a timeline can say: a table of keys for every struct of a FrameState. Parsing,
/// unknown keys and their suggestions, units, ranges, curves, fingerprint and key reference are all driven by
/// it.
namespace dapple::scene {

/// What a key takes.
enum class FieldKind {
    version,       ///< of the timeline's grammar
    numbers,       ///< 1 to 3 doubles, constant or keyed
    integer,       ///< a whole number
    boolean,       ///< true or false
    choice,        ///< one word of a list
    text,          ///< any words
    file_name,     ///< the stem of file names
    path,          ///< of a file, from the timeline's folder
    path_pattern,  ///< a path with a place for a number: %04d or ####
    frame_rate,    ///< a whole number or an exact fraction
    frame_range,   ///< "1-48"
    resolution,    ///< two whole numbers
    structure,     ///< a map
    list,          ///< a list of maps
};

/// Ends of what is allowed, in SI; an open end is excluded.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_open = false;
    bool high_open = false;
    bool contains(double value) const {
        return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
    }
};

/// Where the numbers of a field stand in its struct; null beyond their count.
using Components = std::array<double*, 3>;

struct Structure;

/// One key. `object` is always the struct whose table the field stands in.
struct Field {
    std::string_view key;
    FieldKind kind = FieldKind::text;
    std::string_view doc;

    // numbers
    Components (*components)(void* object) = nullptr;
    Dimension dimension = Dimension::number;
    Range range;  ///< of each number, or of the integer
    bool keyable = false;
    bool one_for_all = false;  ///< a single number may stand for all components (grey, uniform scale)

    // integer, boolean, choice (its index)
    std::int64_t (*get)(const void* object) = nullptr;
    void (*set)(void* object, std::int64_t value) = nullptr;
    std::vector<std::string_view> choices;

    // all other kinds: the member; for a version, frame range or resolution the struct itself
    void* (*member)(void* object) = nullptr;
    const Structure* structure = nullptr;  ///< of the map, or of the list's elements
    void (*resize)(void* object, std::size_t size) = nullptr;
    void* (*element)(void* object, std::size_t index) = nullptr;
    std::size_t (*size)(const void* object) = nullptr;
    bool (*present)(const void* object) = nullptr;  ///< an optional map; null: always there

    bool required = false;
    bool no_default = false;  ///< only what is given counts (one of several ways to say something)
    std::vector<std::string_view> only_for;  ///< values of the struct's type key; empty: all
};

/// Several ways to say one thing. Exactly one way must be used; the first key of a way is needed, the rest
/// may follow.
struct Alternatives {
    std::string_view type;  ///< value of the struct's type key that this holds for; empty: all
    std::vector<std::vector<std::string_view>> ways;
};

/// The keys of one struct.
struct Structure {
    std::string_view name;      ///< "light", for messages
    std::vector<Field> fields;  ///< one key may stand for several types, with a field each
    std::string_view type_key;  ///< the choice that decides which other keys there are; empty: none
    std::vector<Alternatives> alternatives;
    /// Computes what follows from the numbers of one instant (a direction from angles). `given` are the keys
    /// that the timeline holds. Null: nothing follows.
    void (*derive)(void* object, const std::vector<std::string_view>& given) = nullptr;

    /// The field of that key for a value of the type key (ignored where the field holds for all); null: none.
    const Field* find(std::string_view key, std::string_view type) const;
};

/// The table of a FrameState, and so of a timeline.
const Structure& frame_schema();

/// Unit direction of travel of a sun that stands at these angles (rad; CONVENTIONS.md).
glm::dvec3 sun_direction(double elevation, double azimuth);

/// All keys with type, unit, range, default and meaning, for people.
std::string key_reference();

}  // namespace dapple::scene
