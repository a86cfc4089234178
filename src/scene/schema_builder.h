#pragma once
#include <algorithm>
#include <glm/glm.hpp>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "scene/schema.h"

/// Makes the rows of the tables of keys from pointers to members. `number<&Water::surface,
/// &WaterSurface::spectrum, &Spectrum::fetch>(...)` reaches through nested structs.
namespace dapple::scene::build {

inline constexpr double kMost = 2147483647;            // cells, photons, files: what fits an int
inline constexpr double kMostSeed = 9007199254740992;  // 2^53

inline bool has(const std::vector<std::string_view>& given, std::string_view key) {
    return std::find(given.begin(), given.end(), key) != given.end();
}

template <class Class, class Member>
Class class_of(Member Class::*);

template <auto First, auto... Rest>
auto& member_of(void* object) {
    auto& first = static_cast<decltype(class_of(First))*>(object)->*First;
    if constexpr (sizeof...(Rest) == 0)
        return first;
    else
        return member_of<Rest...>(&first);
}

template <auto... Members>
using MemberType = std::remove_reference_t<decltype(member_of<Members...>(nullptr))>;

template <auto... Members>
Components components_of(void* object) {
    auto& value = member_of<Members...>(object);
    using Value = MemberType<Members...>;
    if constexpr (std::is_same_v<Value, double>)
        return {&value, nullptr, nullptr};
    else if constexpr (std::is_same_v<Value, glm::dvec2>)
        return {&value.x, &value.y, nullptr};
    else
        return {&value.x, &value.y, &value.z};
}

/// A row, with what it may be told further.
struct Row {
    Field field;
    operator Field() && {
        return std::move(field);
    }  // NOLINT(google-explicit-constructor): rows list as fields

    Row&& within(double low, double high) && { return std::move(*this).range({low, high, false, false}); }
    Row&& above(double low) && { return std::move(*this).range({low, field.range.high, true, false}); }
    Row&& at_least(double low) && { return std::move(*this).range({low, field.range.high, false, false}); }
    Row&& range(Range allowed) && {
        field.range = allowed;
        return std::move(*this);
    }
    Row&& constant() && {
        field.keyable = false;
        return std::move(*this);
    }
    Row&& one_for_all() && {
        field.one_for_all = true;
        return std::move(*this);
    }
    Row&& required() && {
        field.required = field.no_default = true;
        return std::move(*this);
    }
    Row&& no_default() && {
        field.no_default = true;
        return std::move(*this);
    }
    Row&& only_for(std::initializer_list<std::string_view> types) && {
        field.only_for = types;
        return std::move(*this);
    }
};

template <auto... Members>
Row member(std::string_view key, FieldKind kind, std::string_view doc) {
    Field field;
    field.key = key;
    field.kind = kind;
    field.doc = doc;
    field.member = [](void* object) -> void* { return &member_of<Members...>(object); };
    return {field};
}

/// One, two or three doubles, constant or keyed.
template <auto... Members>
Row number(std::string_view key, Dimension dimension, std::string_view doc) {
    Field field;
    field.key = key;
    field.kind = FieldKind::numbers;
    field.doc = doc;
    field.dimension = dimension;
    field.components = &components_of<Members...>;
    field.keyable = true;
    return {field};
}

/// Whole numbers, booleans and enumerations, which all travel as integers.
template <auto... Members>
Row integral(std::string_view key, FieldKind kind, std::string_view doc) {
    using Value = MemberType<Members...>;
    Field field;
    field.key = key;
    field.kind = kind;
    field.doc = doc;
    field.get = [](const void* object) {
        return static_cast<std::int64_t>(member_of<Members...>(const_cast<void*>(object)));
    };
    field.set = [](void* object, std::int64_t value) {
        member_of<Members...>(object) = static_cast<Value>(value);
    };
    return {field};
}

/// `names` in the order of the enumeration.
template <auto... Members>
Row choice(std::string_view key, std::initializer_list<std::string_view> names, std::string_view doc) {
    Row row = integral<Members...>(key, FieldKind::choice, doc);
    row.field.choices = names;
    return row;
}

template <auto... Members>
Row structure(std::string_view key, const Structure& structure, std::string_view doc) {
    Row row = member<Members...>(key, FieldKind::structure, doc);
    row.field.structure = &structure;
    return row;
}

/// A std::vector of structs.
template <auto... Members>
Row list(std::string_view key, const Structure& element, std::string_view doc) {
    Row row = member<Members...>(key, FieldKind::list, doc);
    row.field.structure = &element;
    row.field.resize = [](void* object, std::size_t size) { member_of<Members...>(object).resize(size); };
    row.field.element = [](void* object, std::size_t index) -> void* {
        return &member_of<Members...>(object)[index];
    };
    row.field.size = [](const void* object) {
        return member_of<Members...>(const_cast<void*>(object)).size();
    };
    return row;
}

/// A field that is read from and written to the whole struct.
inline Row whole(std::string_view key, FieldKind kind, std::string_view doc) {
    Field field;
    field.key = key;
    field.kind = kind;
    field.doc = doc;
    field.member = [](void* object) { return object; };
    return {field};
}

}  // namespace dapple::scene::build
