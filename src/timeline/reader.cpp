#include "timeline/reader.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/suggest.h"
#include "timeline/curve_reader.h"
#include "timeline/value_reader.h"

namespace dapple::timeline {
namespace {

using input::LocatedNode;
using scene::Alternatives;
using scene::Field;
using scene::FieldKind;
using scene::Structure;

bool contains(const std::vector<std::string_view>& words, std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

bool applies(const Field& field, std::string_view type) {
    return field.only_for.empty() ||
           std::find(field.only_for.begin(), field.only_for.end(), type) != field.only_for.end();
}

/// Keys that a struct of this type takes.
std::vector<std::string_view> keys_of(const Structure& structure, std::string_view type) {
    std::vector<std::string_view> keys;
    for (const Field& field : structure.fields)
        if (applies(field, type)) keys.push_back(field.key);
    return keys;
}

/// Values of the type key for which there is such a key.
std::vector<std::string_view> types_with(const Structure& structure, std::string_view key) {
    std::vector<std::string_view> types;
    for (const Field& field : structure.fields)
        if (field.key == key) types.insert(types.end(), field.only_for.begin(), field.only_for.end());
    return types;
}

class ProgramReader {
public:
    ProgramReader(Program& program, const std::string& folder, FaultList& faults)
        : program_(program), folder_(folder), faults_(faults) {}

    void read_structure(const Structure& structure, const LocatedNode& node, const Address& address,
                        const std::string& path) {
        if (node.kind != LocatedNode::Kind::map) {
            faults_.add(node.place, path,
                        expected_but_got("a map with the keys " + all_keys(structure), node));
            return;
        }
        const std::optional<std::string_view> type = read_type(structure, node, address, path);
        // A misspelt key is one fault, not also a missing one.
        std::vector<std::string_view> meant;
        for (const LocatedNode::Entry& entry : node.entries)
            if (const auto near = check_known(structure, entry, type, path); !near.empty())
                meant.push_back(near);
        for (const Field& field : structure.fields) {
            if (field.key == structure.type_key || !(type ? applies(field, *type) : field.only_for.empty()))
                continue;
            const LocatedNode* value = node.find(field.key);
            if (value != nullptr)
                read_field(field, *value, address, join(path, field.key));
            else if (field.required && !contains(meant, field.key))
                faults_.add(node.key_place, path,
                            "the key " + in_quotes(field.key) + " is missing: " + std::string(field.doc));
        }
        if (type) check_alternatives(structure, *type, node, meant, path);
        if (structure.derive != nullptr)
            program_.derivations.push_back({address, &structure, given_keys(structure, node)});
    }

private:
    static std::string all_keys(const Structure& structure) {
        std::vector<std::string_view> keys;
        for (const Field& field : structure.fields)
            if (!contains(keys, field.key)) keys.push_back(field.key);
        return joined(keys);
    }

    /// The value of the type key; nothing where it is missing or wrong, so that no key can be held against
    /// it.
    std::optional<std::string_view> read_type(const Structure& structure, const LocatedNode& node,
                                              const Address& address, const std::string& path) {
        if (structure.type_key.empty()) return std::string_view();
        const Field& field = *structure.find(structure.type_key, {});
        void* object = resolve(program_.base, address);
        if (const LocatedNode* value = node.find(field.key)) {
            const std::string key_path = join(path, field.key);
            program_.given.insert(key_path);
            if (!read_value({*value, field, key_path, faults_}, folder_, object)) return std::nullopt;
        } else if (field.required) {
            faults_.add(
                node.key_place, path,
                "the key " + in_quotes(field.key) + " is missing; it takes one of: " + joined(field.choices));
            return std::nullopt;
        }
        return type_of(structure, object);
    }

    void read_field(const Field& field, const LocatedNode& node, const Address& address,
                    const std::string& path) {
        program_.given.insert(path);
        switch (field.kind) {
            case FieldKind::numbers:
                read_numeric(field, node, address, path);
                break;
            case FieldKind::structure: {
                Address inner = address;
                inner.push_back({&field, 0});
                resolve(program_.base, inner);  // makes an optional map
                read_structure(*field.structure, node, inner, path);
                break;
            }
            case FieldKind::list:
                read_list(field, node, address, path);
                break;
            default:
                read_value({node, field, path, faults_}, folder_, resolve(program_.base, address));
                break;
        }
    }

    void read_numeric(const Field& field, const LocatedNode& node, const Address& address,
                      const std::string& path) {
        const scene::Components numbers = field.components(resolve(program_.base, address));
        const std::size_t count = component_count(numbers);
        const Source source{node, field, path, faults_};
        Values values{};
        if (node.kind == LocatedNode::Kind::map) {
            if (!field.keyable) {
                source.fault("is the same in all frames; it takes no keys");
                return;
            }
            std::optional<Curve> curve = read_curve(source, count, program_.base.clip);
            if (!curve) return;
            values = curve->keys().front().values;  // the base state is a valid one
            program_.tracks.push_back({address, &field, path, std::move(*curve)});
        } else if (!read_numbers(source, count, values)) {
            return;
        }
        for (std::size_t c = 0; c < count; ++c) *numbers[c] = values[c];
    }

    void read_list(const Field& field, const LocatedNode& node, const Address& address,
                   const std::string& path) {
        if (node.kind != LocatedNode::Kind::sequence) {
            faults_.add(node.place, path, expected_but_got("a list", node));
            return;
        }
        field.resize(resolve(program_.base, address), node.items.size());
        std::map<std::string, int, std::less<>> lines_of_names;
        for (std::size_t i = 0; i < node.items.size(); ++i) {
            Address element = address;
            element.push_back({&field, i});
            read_structure(*field.structure, node.items[i], element, join(path, i));
            const LocatedNode* name = node.items[i].find("name");
            if (name == nullptr || name->kind != LocatedNode::Kind::scalar) continue;
            const auto [other, unique] = lines_of_names.try_emplace(name->scalar, name->place.line);
            if (!unique)
                faults_.add(name->place, join(join(path, i), "name"),
                            "the name " + in_quotes(name->scalar) + " is taken already, in line " +
                                std::to_string(other->second));
        }
    }

    /// Reports a key that there is not; the known key that was probably meant, or nothing.
    std::string_view check_known(const Structure& structure, const LocatedNode::Entry& entry,
                                 std::optional<std::string_view> type, const std::string& path) {
        const input::Place& place = entry.value.key_place;
        const std::string key_path = join(path, entry.key);
        const auto has_key = [&](const Field& field) { return field.key == entry.key; };
        const bool exists = std::any_of(structure.fields.begin(), structure.fields.end(), has_key);
        if (exists && (!type || structure.find(entry.key, *type) != nullptr)) return {};
        const std::string owner = type && !type->empty()
                                      ? std::string(structure.type_key) + " " + std::string(*type)
                                      : "the " + std::string(structure.name);
        if (exists) {
            faults_.add(place, key_path,
                        "this key belongs to " + std::string(structure.type_key) + " " +
                            joined(types_with(structure, entry.key)) + ", not to " + std::string(*type) +
                            "; " + owner + " takes: " + joined(keys_of(structure, *type)));
            return {};
        }
        const std::vector<std::string_view> known =
            type ? keys_of(structure, *type) : std::vector<std::string_view>();
        std::string hint = suggestion(entry.key, known, owner + " takes:");
        if (!type) hint = suggestion(entry.key, {structure.type_key}, "known keys depend on:");
        faults_.add(place, key_path, "unknown key" + hint);
        return nearest(entry.key, known);
    }

    /// Exactly one way to say a thing must be used.
    void check_alternatives(const Structure& structure, std::string_view type, const LocatedNode& node,
                            const std::vector<std::string_view>& meant, const std::string& path) {
        for (const Alternatives& alternatives : structure.alternatives) {
            if (!alternatives.type.empty() && alternatives.type != type) continue;
            std::string ways;
            const LocatedNode* used = nullptr;
            std::string_view used_way;
            for (const auto& way : alternatives.ways) {
                ways.append(ways.empty() ? "" : " or ").append(in_quotes(way.front()));
                for (const std::string_view key : way) {
                    const LocatedNode* value = node.find(key);
                    if (value == nullptr) continue;
                    if (used != nullptr && used_way != way.front()) {
                        faults_.add(value->key_place, join(path, key),
                                    "says again what " + in_quotes(used_way) + " says; give one of them");
                        return;
                    }
                    used = value;
                    used_way = way.front();
                }
            }
            const bool misspelt = std::any_of(alternatives.ways.begin(), alternatives.ways.end(),
                                              [&](const auto& way) { return contains(meant, way.front()); });
            if ((used == nullptr || node.find(used_way) == nullptr) && !misspelt)
                faults_.add(
                    node.key_place, path,
                    (used == nullptr ? "the key " + ways : "the key " + in_quotes(used_way)) + " is missing");
        }
    }

    static std::vector<std::string_view> given_keys(const Structure& structure, const LocatedNode& node) {
        std::vector<std::string_view> given;
        for (const Field& field : structure.fields)
            if (node.find(field.key) != nullptr) given.push_back(field.key);
        return given;
    }

    Program& program_;
    const std::string& folder_;
    FaultList& faults_;
};

}  // namespace

Program read_program(const LocatedNode& root, const std::string& folder, FaultList& faults) {
    Program program;
    // Of another version nothing else can be said, so the wrong version is the only fault reported.
    const scene::Field& version = *scene::frame_schema().find("dapple", {});
    if (const LocatedNode* node = root.find(version.key))
        if (!read_value({*node, version, "dapple", faults}, folder, &program.base)) return program;
    ProgramReader(program, folder, faults).read_structure(scene::frame_schema(), root, {}, "");
    return program;
}

}  // namespace dapple::timeline
