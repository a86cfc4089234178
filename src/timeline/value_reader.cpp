#include "timeline/value_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>
#include <string_view>

#include "base/number_pattern.h"
#include "base/suggest.h"
#include "base/units.h"

namespace dapple::timeline {
namespace {

using input::LocatedNode;
using scene::Field;
using scene::FieldKind;

constexpr int kVersion = 1;
constexpr double kLargestNumber =
    1e12;  // SI; above it sums and squares of sane scenes would lose all meaning
constexpr double kTwoTurns = 4 * std::numbers::pi;
constexpr std::int64_t kMostFrames = 10'000'000;
constexpr std::int64_t kMostFrameNumber = 1'000'000'000;
constexpr std::int64_t kMostRateTerm = 1'000'000'000;
constexpr std::int64_t kMostRate = 1000;  // frames a second
constexpr std::size_t kLongestName = 100;

std::string shown(const std::string& text) {
    return in_quotes(text.size() <= 60 ? text : text.substr(0, 57) + "...");
}

std::string shown(double value, const Field& field) {
    return field.kind == FieldKind::numbers ? format_quantity(value, field.dimension)
                                            : std::to_string(static_cast<std::int64_t>(value));
}

bool expect_scalar(const Source& source, const std::string& expected) {
    if (source.node.kind == LocatedNode::Kind::scalar) return true;
    source.fault(expected_but_got(expected, source.node));
    return false;
}

bool read_number(const Source& source, double& value) {
    const Field& field = source.field;
    if (!expect_scalar(source, std::string(dimension_name(field.dimension)))) return false;
    const std::string& text = source.node.scalar;

    // A frame rate may be a fraction; anything else with a '/' is a number and its unit.
    const std::size_t slash = text.find('/');
    if (field.dimension == Dimension::frame_rate && slash != std::string::npos) {
        const Integer numerator = parse_integer(text.substr(0, slash));
        const Integer denominator = parse_integer(text.substr(slash + 1));
        if (!numerator.error.empty() || !denominator.error.empty() || denominator.value <= 0) {
            source.fault("expected a frame rate such as 24 or 24000/1001, got " + shown(text));
            return false;
        }
        value = static_cast<double>(numerator.value) / static_cast<double>(denominator.value);
    } else {
        const Quantity quantity = parse_quantity(text, field.dimension);
        if (!quantity.error.empty()) {
            source.fault(quantity.error);
            return false;
        }
        value = quantity.value + 0.0;  // makes -0 plain 0
        const bool plain_angle = field.dimension == Dimension::angle && !quantity.has_unit;
        const bool meant_degrees =
            !field.range.contains(value) && field.range.contains(radians_from_degrees(value));
        if (plain_angle && (std::abs(value) > kTwoTurns || meant_degrees)) {
            source.fault("a plain number is in radians, and " + text + " rad is " +
                         format_quantity(value, Dimension::angle) + "; did you mean '" + text + " deg'?");
            return false;
        }
    }
    if (const std::string fault = range_fault(field, value); !fault.empty()) {
        source.fault(fault);
        return false;
    }
    return true;
}

bool read_integer(const Source& source, std::int64_t& value) {
    if (!expect_scalar(source, "a whole number")) return false;
    const Integer integer = parse_integer(source.node.scalar);
    std::string fault = integer.error;
    if (fault.empty()) fault = range_fault(source.field, static_cast<double>(integer.value));
    if (!fault.empty()) {
        source.fault(fault);
        return false;
    }
    value = integer.value;
    return true;
}

bool read_boolean(const Source& source, void* object) {
    if (!expect_scalar(source, "true or false")) return false;
    const std::string& text = source.node.scalar;
    if (text != "true" && text != "false") {
        source.fault("expected true or false, got " + shown(text));
        return false;
    }
    source.field.set(object, text == "true" ? 1 : 0);
    return true;
}

bool read_choice(const Source& source, void* object) {
    const auto& choices = source.field.choices;
    if (!expect_scalar(source, "one of " + joined(choices))) return false;
    const auto found = std::find(choices.begin(), choices.end(), source.node.scalar);
    if (found == choices.end()) {
        source.fault("unknown " + std::string(source.field.key) + " " + shown(source.node.scalar) +
                     suggestion(source.node.scalar, choices));
        return false;
    }
    source.field.set(object, found - choices.begin());
    return true;
}

bool read_version(const Source& source) {
    if (!expect_scalar(source, "the version of the timeline's grammar, 1,")) return false;
    const Integer version = parse_integer(source.node.scalar);
    if (version.error.empty() && version.value == kVersion) return true;
    source.fault("version " + shown(source.node.scalar) +
                 " is not supported; this program reads 'dapple: " + std::to_string(kVersion) + "'");
    return false;
}

bool read_file_name(const Source& source, std::string& name) {
    if (!expect_scalar(source, "a name")) return false;
    const std::string& text = source.node.scalar;
    const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-' || c == '.';
    });
    if (text.empty() || text.size() > kLongestName || !plain || text.front() == '.' || text.front() == '-') {
        source.fault("files are named after it, so it takes letters, digits, '_', '-' and '.', at most " +
                     std::to_string(kLongestName) + " of them, and starts with a letter, digit or '_'; got " +
                     shown(text));
        return false;
    }
    name = text;
    return true;
}

bool read_text(const Source& source, std::string& text) {
    if (!expect_scalar(source, "a text")) return false;
    if (source.node.scalar.empty()) {
        source.fault("the text is empty; leave the key out instead");
        return false;
    }
    text = source.node.scalar;
    return true;
}

bool read_path(const Source& source, const std::string& folder, std::string& path) {
    if (!read_text(source, path)) return false;
    if (source.field.kind == FieldKind::path_pattern && find_number(path).length == 0) {
        source.fault(
            "the pattern needs one place for the file's number, such as sea.%04d.ply or sea.####.ply; got " +
            shown(path));
        return false;
    }
    path = (std::filesystem::path(folder) / path).lexically_normal().string();
    return true;
}

bool read_frame_rate(const Source& source, scene::Rational& rate) {
    const std::string expected = "a frame rate, whole (24) or an exact fraction (24000/1001)";
    if (!expect_scalar(source, expected)) return false;
    const std::string& text = source.node.scalar;
    const std::size_t slash = text.find('/');
    const Integer numerator = parse_integer(std::string_view(text).substr(0, slash));
    Integer denominator{1, {}};
    if (slash != std::string::npos) denominator = parse_integer(std::string_view(text).substr(slash + 1));
    if (!numerator.error.empty() || !denominator.error.empty()) {
        const bool decimal = text.find('.') != std::string::npos;
        source.fault("expected " + expected + ", got " + shown(text) +
                     (decimal ? "; 23.976 is 24000/1001, 29.97 is 30000/1001" : ""));
        return false;
    }
    const std::int64_t n = numerator.value;
    const std::int64_t d = denominator.value;
    if (n < 1 || d < 1 || n > kMostRateTerm || d > kMostRateTerm || n > kMostRate * d) {
        source.fault("a frame rate is above 0 and at most " + std::to_string(kMostRate) + "; got " +
                     shown(text));
        return false;
    }
    const std::int64_t divisor = std::gcd(n, d);
    rate = {n / divisor, d / divisor};
    return true;
}

bool read_frame_range(const Source& source, scene::Clip& clip) {
    const std::string expected = "the first and last frame, such as 1-48, or one frame";
    if (!expect_scalar(source, expected)) return false;
    const std::string& text = source.node.scalar;
    // A '-' at the very begin is a sign.
    const std::size_t dash = text.find('-', 1);
    const Integer first = parse_integer(std::string_view(text).substr(0, dash));
    const Integer last =
        dash == std::string::npos ? first : parse_integer(std::string_view(text).substr(dash + 1));
    if (!first.error.empty() || !last.error.empty()) {
        const bool large =
            text.find_first_not_of("0123456789- ") == std::string::npos && dash != text.size() - 1;
        source.fault(large ? shown(text) + " holds a frame number that is too large or badly written"
                           : "expected " + expected + ", got " + shown(text));
        return false;
    }
    if (last.value < first.value) {
        source.fault("the last frame, " + std::to_string(last.value) + ", comes before the first, " +
                     std::to_string(first.value));
        return false;
    }
    if (first.value < -kMostFrameNumber || last.value > kMostFrameNumber ||
        last.value - first.value >= kMostFrames) {
        source.fault("too many frames: a clip has at most " + std::to_string(kMostFrames) +
                     ", numbered from -10^9 to 10^9; got " + shown(text));
        return false;
    }
    clip.first_frame = first.value;
    clip.last_frame = last.value;
    return true;
}

bool read_resolution(const Source& source, scene::Clip& clip) {
    const std::string expected = "width and height in pixels, such as [960, 540]";
    if (source.node.kind != LocatedNode::Kind::sequence) {
        source.fault(expected_but_got(expected, source.node));
        return false;
    }
    if (source.node.items.size() != 2) {
        source.fault("expected " + expected + ", got a list of " + std::to_string(source.node.items.size()));
        return false;
    }
    std::int64_t width = 0;
    std::int64_t height = 0;
    const bool width_read =
        read_integer({source.node.items[0], source.field, source.key_path, source.faults}, width);
    const bool height_read =
        read_integer({source.node.items[1], source.field, source.key_path, source.faults}, height);
    if (!width_read || !height_read) return false;
    clip.width = static_cast<int>(width);
    clip.height = static_cast<int>(height);
    return true;
}

}  // namespace

std::size_t component_count(const scene::Components& numbers) {
    return static_cast<std::size_t>(std::count_if(numbers.begin(), numbers.end(),
                                                  [](const double* number) { return number != nullptr; }));
}

std::string expected_but_got(const std::string& expected, const LocatedNode& node) {
    switch (node.kind) {
        case LocatedNode::Kind::empty:
            return "has no value; expected " + expected;
        case LocatedNode::Kind::sequence:
            return "expected " + expected + ", got a list";
        case LocatedNode::Kind::map:
            return "expected " + expected + ", got a map";
        case LocatedNode::Kind::scalar:
            break;
    }
    return "expected " + expected + ", got " + shown(node.scalar);
}

std::string range_fault(const Field& field, double value) {
    const scene::Range& range = field.range;
    if (std::abs(value) > kLargestNumber && field.kind == FieldKind::numbers)
        return "no number may be larger than 1e12; got " + shown(value, field);
    if (range.contains(value)) return {};
    const std::string low = (range.low_open ? "above " : "at least ") + shown(range.low, field);
    const std::string high = (range.high_open ? "below " : "at most ") + shown(range.high, field);
    std::string text = "must be ";
    if (std::isfinite(range.low)) text += low;
    if (std::isfinite(range.low) && std::isfinite(range.high)) text += " and ";
    if (std::isfinite(range.high)) text += high;
    return text + "; got " + shown(value, field);
}

bool read_numbers(const Source& source, std::size_t components, Values& values) {
    if (components == 1) return read_number(source, values[0]);
    const LocatedNode& node = source.node;
    if (node.kind == LocatedNode::Kind::scalar && source.field.one_for_all) {
        if (!read_number(source, values[0])) return false;
        values = {values[0], values[0], values[0]};
        return true;
    }
    const std::string expected = (source.field.one_for_all ? "one number or a list of " : "a list of ") +
                                 std::to_string(components) + " numbers";
    if (node.kind != LocatedNode::Kind::sequence) {
        source.fault(expected_but_got(expected, node));
        return false;
    }
    if (node.items.size() != components) {
        source.fault("expected " + expected + ", got a list of " + std::to_string(node.items.size()));
        return false;
    }
    bool fine = true;
    for (std::size_t c = 0; c < components; ++c)
        fine = read_number({node.items[c], source.field, source.key_path, source.faults}, values[c]) && fine;
    return fine;
}

bool read_value(const Source& source, const std::string& folder, void* object) {
    const Field& field = source.field;
    const auto text = [&]() -> std::string& { return *static_cast<std::string*>(field.member(object)); };
    switch (field.kind) {
        case FieldKind::version:
            return read_version(source);
        case FieldKind::integer: {
            std::int64_t value = 0;
            if (!read_integer(source, value)) return false;
            field.set(object, value);
            return true;
        }
        case FieldKind::boolean:
            return read_boolean(source, object);
        case FieldKind::choice:
            return read_choice(source, object);
        case FieldKind::text:
            return read_text(source, text());
        case FieldKind::file_name:
            return read_file_name(source, text());
        case FieldKind::path:
        case FieldKind::path_pattern:
            return read_path(source, folder, text());
        case FieldKind::frame_rate:
            return read_frame_rate(source, *static_cast<scene::Rational*>(field.member(object)));
        case FieldKind::frame_range:
            return read_frame_range(source, *static_cast<scene::Clip*>(object));
        case FieldKind::resolution:
            return read_resolution(source, *static_cast<scene::Clip*>(object));
        case FieldKind::numbers:
        case FieldKind::structure:
        case FieldKind::list:
            break;
    }
    return false;
}

}  // namespace dapple::timeline
