#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "base/suggest.h"
#include "scene/schema.h"

namespace dapple::scene {
namespace {

std::string bound(double value, const Field& field) {
    return field.kind == FieldKind::numbers ? format_quantity(value, field.dimension)
                                            : std::to_string(static_cast<std::int64_t>(value));
}

std::string type_text(const Field& field, void* object) {
    switch (field.kind) {
        case FieldKind::version:
            return "1";
        case FieldKind::integer:
            return "whole number";
        case FieldKind::boolean:
            return "true or false";
        case FieldKind::choice:
            return joined(field.choices);
        case FieldKind::text:
        case FieldKind::file_name:
            return "text";
        case FieldKind::path:
        case FieldKind::path_pattern:
            return "path";
        case FieldKind::frame_rate:
            return "frame rate";
        case FieldKind::frame_range:
            return "frames";
        case FieldKind::resolution:
            return "[width, height]";
        case FieldKind::structure:
            return "map";
        case FieldKind::list:
            return "list";
        case FieldKind::numbers:
            break;
    }
    const Components numbers = field.components(object);
    std::string text;
    if (numbers[1] != nullptr) text = numbers[2] != nullptr ? "3 x " : "2 x ";
    if (field.one_for_all) text = "1 or 3 x ";
    const std::string_view name = dimension_name(field.dimension);
    text.append(name.substr(name.find(' ') + 1));  // without its article
    const auto units = unit_symbols(field.dimension);
    return text.append(" (").append(joined(units)).append(")");
}

std::string range_text(const Field& field) {
    const bool low = std::isfinite(field.range.low);
    const bool high = std::isfinite(field.range.high);
    std::string text;
    if (low) text.append(field.range.low_open ? ", > " : ", >= ").append(bound(field.range.low, field));
    if (high) text.append(field.range.high_open ? ", < " : ", <= ").append(bound(field.range.high, field));
    return text;
}

std::string default_text(const Field& field, void* object) {
    if (field.required) return ", required";
    if (field.no_default) return {};
    std::string text = ", default ";
    switch (field.kind) {
        case FieldKind::numbers: {
            const Components numbers = field.components(object);
            std::string values;
            for (const double* number : numbers) {
                if (number == nullptr) continue;
                values.append(values.empty() ? "" : ", ").append(format_quantity(*number, field.dimension));
            }
            return numbers[1] == nullptr ? text.append(values) : text.append("[").append(values).append("]");
        }
        case FieldKind::integer:
            return text.append(std::to_string(field.get(object)));
        case FieldKind::boolean:
            return text.append(field.get(object) != 0 ? "true" : "false");
        case FieldKind::choice:
            return text.append(field.choices[static_cast<std::size_t>(field.get(object))]);
        case FieldKind::text:
        case FieldKind::file_name: {
            const std::string& value = *static_cast<const std::string*>(field.member(object));
            return value.empty() ? std::string() : text.append(value);
        }
        case FieldKind::frame_rate:
            return text.append("24");
        case FieldKind::frame_range:
            return text.append("1");
        case FieldKind::resolution:
            return text.append("[960, 540]");
        default:
            return {};
    }
}

void describe(const Structure& structure, void* object, int depth, std::string& text) {
    const std::string indent(static_cast<std::size_t>(2 * depth), ' ');
    for (const Field& field : structure.fields) {
        text.append(indent).append(field.key).append(": ").append(type_text(field, object));
        text.append(range_text(field)).append(default_text(field, object));
        if (field.keyable) text.append(", keyed or constant");
        if (!field.only_for.empty())
            text.append(" [")
                .append(structure.type_key)
                .append(": ")
                .append(joined(field.only_for))
                .append("]");
        if (!field.doc.empty()) text.append("\n").append(indent).append("    ").append(field.doc);
        text.append("\n");
        if (field.kind == FieldKind::structure)
            describe(*field.structure, field.member(object), depth + 1, text);
        if (field.kind == FieldKind::list) {
            field.resize(object, 1);
            describe(*field.structure, field.element(object, 0), depth + 1, text);
        }
    }
}

}  // namespace

std::string key_reference() {
    FrameState state;
    std::string text =
        "Numbers without a unit are SI, angles radians. A keyed number is written\n"
        "  {keys: [{frame: 1, value: 10 deg}, {time: 2 s, value: 20 deg}], interpolation: linear}\n"
        "with step, linear, cubic (monotone) or bezier (out: [x, y] and in: [x, y] of each key).\n\n";
    describe(frame_schema(), &state, 0, text);
    return text;
}

}  // namespace dapple::scene
