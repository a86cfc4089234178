// PLY, the polygon file format (G. Turk, Stanford, 1994): a text header that lists elements and their
// properties, then the elements' values as text or binary, in that order.
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "input/mesh_file.h"

namespace dapple::input {
namespace {

enum class Type : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Encoding : std::uint8_t { ascii, little, big };

struct TypeName {
    std::string_view name;
    Type type;
};
constexpr std::array<TypeName, 16> kTypeNames{{{"char", Type::int8},
                                               {"int8", Type::int8},
                                               {"uchar", Type::uint8},
                                               {"uint8", Type::uint8},
                                               {"short", Type::int16},
                                               {"int16", Type::int16},
                                               {"ushort", Type::uint16},
                                               {"uint16", Type::uint16},
                                               {"int", Type::int32},
                                               {"int32", Type::int32},
                                               {"uint", Type::uint32},
                                               {"uint32", Type::uint32},
                                               {"float", Type::float32},
                                               {"float32", Type::float32},
                                               {"double", Type::float64},
                                               {"float64", Type::float64}}};

std::size_t size_of(Type type) {
    switch (type) {
        case Type::int8:
        case Type::uint8:
            return 1;
        case Type::int16:
        case Type::uint16:
            return 2;
        case Type::int32:
        case Type::uint32:
        case Type::float32:
            return 4;
        case Type::float64:
            return 8;
    }
    return 0;
}

struct Property {
    std::string name;
    Type type = Type::float32;
    std::optional<Type> count_type;  ///< of a list
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

struct Header {
    Encoding encoding = Encoding::ascii;
    std::vector<Element> elements;
};

constexpr std::string_view kBlanks = " \t\r\n\v\f";

// The next word of a text; empty at its end.
std::string_view next_word(std::string_view& text) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) {
        text = {};
        return {};
    }
    const std::size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    text.remove_prefix(end);
    return word;
}

Type type_of(std::string_view name) {
    for (const TypeName& known : kTypeNames) {
        if (known.name == name) return known.type;
    }
    throw MeshFault{"the header has an unknown type \"" + std::string(name) + "\""};
}

Encoding encoding_of(std::string_view name) {
    if (name == "ascii") return Encoding::ascii;
    if (name == "binary_little_endian") return Encoding::little;
    if (name == "binary_big_endian") return Encoding::big;
    throw MeshFault{"the header has an unknown format \"" + std::string(name) + "\""};
}

void read_element(std::string_view line, Header& header) {
    Element element;
    element.name = next_word(line);
    const std::string_view count = next_word(line);
    const auto parsed = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (count.empty() || parsed.ec != std::errc() || parsed.ptr != count.data() + count.size()) {
        throw MeshFault{"the header gives \"" + std::string(count) + "\" as number of \"" + element.name +
                        "\""};
    }
    header.elements.push_back(std::move(element));
}

void read_property(std::string_view line, Header& header) {
    if (header.elements.empty()) throw MeshFault{"the header has a property before any element"};
    Property property;
    std::string_view type = next_word(line);
    if (type == "list") {
        property.count_type = type_of(next_word(line));
        if (*property.count_type == Type::float32 || *property.count_type == Type::float64) {
            throw MeshFault{"the header counts a list in fractions"};
        }
        type = next_word(line);
    }
    property.type = type_of(type);
    property.name = next_word(line);
    header.elements.back().properties.push_back(std::move(property));
}

// Takes the header off the front of `contents`.
Header read_header(std::string_view& contents) {
    const auto next_line = [&] {
        const std::size_t end = contents.find('\n');
        if (end == std::string_view::npos) throw MeshFault{"ends within its header"};
        const std::string_view line = contents.substr(0, end);
        contents.remove_prefix(end + 1);
        return line;
    };
    if (contents.substr(0, 3) != "ply") throw MeshFault{"is not a PLY file: it does not begin with \"ply\""};
    next_line();
    Header header;
    bool has_format = false;
    while (true) {
        std::string_view line = next_line();
        const std::string_view keyword = next_word(line);
        if (keyword == "end_header") break;
        if (keyword == "format") {
            header.encoding = encoding_of(next_word(line));
            has_format = true;
        } else if (keyword == "element") {
            read_element(line, header);
        } else if (keyword == "property") {
            read_property(line, header);
        } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
            throw MeshFault{"the header has an unknown line \"" + std::string(keyword) + "\""};
        }
    }
    if (!has_format) throw MeshFault{"the header has no format"};
    return header;
}

// Reads values one by one off the body.
class Body {
public:
    Body(std::string_view bytes, Encoding encoding) : bytes_(bytes), encoding_(encoding) {}

    std::size_t left() const { return bytes_.size(); }
    // Bytes that a value takes at least: as text a digit and (but for the last) a blank.
    std::size_t smallest(Type type) const { return encoding_ == Encoding::ascii ? 2 : size_of(type); }

    double value(Type type) {
        if (encoding_ == Encoding::ascii) return text_value();
        const std::size_t size = size_of(type);
        if (bytes_.size() < size) throw MeshFault{"is truncated"};
        std::array<unsigned char, 8> raw{};
        const bool swap = (encoding_ == Encoding::big) != (std::endian::native == std::endian::big);
        for (std::size_t i = 0; i < size; ++i) {
            raw[swap ? size - 1 - i : i] = static_cast<unsigned char>(bytes_[i]);
        }
        bytes_.remove_prefix(size);
        switch (type) {
            case Type::int8:
                return as<std::int8_t>(raw);
            case Type::uint8:
                return as<std::uint8_t>(raw);
            case Type::int16:
                return as<std::int16_t>(raw);
            case Type::uint16:
                return as<std::uint16_t>(raw);
            case Type::int32:
                return as<std::int32_t>(raw);
            case Type::uint32:
                return as<std::uint32_t>(raw);
            case Type::float32:
                return static_cast<double>(as<float>(raw));
            case Type::float64:
                return as<double>(raw);
        }
        return 0;
    }

    // Length of a list of values of `type`, which must fit into what is left.
    std::size_t list_length(const Property& list) {
        const double length = value(*list.count_type);
        if (!(length >= 0) ||
            length * static_cast<double>(smallest(list.type)) > static_cast<double>(left()) + 1) {
            throw MeshFault{"is truncated, or a list is longer than the file"};
        }
        return static_cast<std::size_t>(length);
    }

private:
    template <class T>
    static T as(const std::array<unsigned char, 8>& raw) {
        T value;
        std::memcpy(&value, raw.data(), sizeof value);
        return value;
    }

    double text_value() {
        std::string_view word = next_word(bytes_);
        if (word.empty()) throw MeshFault{"is truncated"};
        const std::string_view whole = word;
        if (word.front() == '+') word.remove_prefix(1);
        double number = 0;
        const auto parsed = std::from_chars(word.data(), word.data() + word.size(), number);
        if (parsed.ec == std::errc::result_out_of_range) return std::numeric_limits<double>::infinity();
        if (parsed.ec != std::errc() || parsed.ptr != word.data() + word.size()) {
            throw MeshFault{"has \"" + std::string(whole) + "\" where a number should be"};
        }
        return number;
    }

    std::string_view bytes_;
    Encoding encoding_;
};

// Whether `count` items of this element can be in what is left.
void check_count(const Element& element, const Body& body) {
    double item = 0;
    for (const Property& property : element.properties) {
        item += static_cast<double>(body.smallest(property.count_type.value_or(property.type)));
    }
    if (item * static_cast<double>(element.count) > static_cast<double>(body.left()) + 1) {
        throw MeshFault{"is truncated: " + std::to_string(element.count) + " of \"" + element.name +
                        "\" do not fit into the file"};
    }
}

void skip(const Property& property, Body& body) {
    const std::size_t values = property.count_type ? body.list_length(property) : 1;
    for (std::size_t i = 0; i < values; ++i) body.value(property.type);
}

constexpr std::size_t kNone = 8;

// Which of x y z nx ny nz u v a property is.
std::size_t slot_of(const Property& property) {
    constexpr std::array<std::string_view, 8> names{"x", "y", "z", "nx", "ny", "nz", "u", "v"};
    if (property.count_type) return kNone;
    std::string_view name = property.name;
    if (name == "s" || name == "texture_u") name = "u";
    if (name == "t" || name == "texture_v") name = "v";
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == name) return i;
    }
    return kNone;
}

void read_vertices(const Element& element, Body& body, scene::TriangleMesh& mesh) {
    std::vector<std::size_t> slots;
    std::array<bool, 9> given{};
    for (const Property& property : element.properties) {
        slots.push_back(slot_of(property));
        given[slots.back()] = true;
    }
    if (!given[0] || !given[1] || !given[2]) throw MeshFault{"its vertices lack x, y or z"};
    const bool normals = given[3] && given[4] && given[5];
    const bool uv = given[6] && given[7];
    if (element.count > std::numeric_limits<std::uint32_t>::max()) throw MeshFault{"has too many vertices"};
    mesh.positions.reserve(element.count);
    if (normals) mesh.normals.reserve(element.count);
    if (uv) mesh.uv.reserve(element.count);
    std::array<double, 8> v{};
    for (std::uint64_t i = 0; i < element.count; ++i) {
        for (std::size_t p = 0; p < slots.size(); ++p) {
            if (slots[p] == kNone) {
                skip(element.properties[p], body);
            } else {
                v[slots[p]] = body.value(element.properties[p].type);
            }
        }
        mesh.positions.emplace_back(v[0], v[1], v[2]);
        if (normals) mesh.normals.emplace_back(v[3], v[4], v[5]);
        if (uv) mesh.uv.emplace_back(v[6], v[7]);
    }
}

void read_faces(const Element& element, Body& body, std::uint64_t vertices, scene::TriangleMesh& mesh) {
    mesh.triangles.reserve(element.count);
    std::vector<std::uint32_t> corners;
    for (std::uint64_t face = 0; face < element.count; ++face) {
        for (const Property& property : element.properties) {
            const bool indices = property.name == "vertex_indices" || property.name == "vertex_index";
            if (!indices || !property.count_type) {
                skip(property, body);
                continue;
            }
            corners.resize(body.list_length(property));
            for (std::uint32_t& corner : corners) {
                const double index = body.value(property.type);
                if (!(index >= 0 && index < static_cast<double>(vertices))) {
                    throw MeshFault{"face " + std::to_string(face) + " names a vertex that is not there"};
                }
                corner = static_cast<std::uint32_t>(index);
            }
            for (std::size_t i = 2; i < corners.size(); ++i) {
                mesh.triangles.emplace_back(corners[0], corners[i - 1], corners[i]);
            }
        }
    }
}

}  // namespace

scene::TriangleMesh parse_ply(std::string_view contents) {
    const Header header = read_header(contents);
    std::uint64_t vertices = 0;  // faces may stand before the vertices
    for (const Element& element : header.elements) {
        if (element.name == "vertex") vertices = element.count;
    }
    if (vertices == 0) throw MeshFault{"has no vertices"};
    Body body(contents, header.encoding);
    scene::TriangleMesh mesh;
    for (const Element& element : header.elements) {
        if (element.properties.empty()) continue;
        check_count(element, body);
        if (element.name == "vertex") {
            read_vertices(element, body, mesh);
        } else if (element.name == "face") {
            read_faces(element, body, vertices, mesh);
        } else {
            for (std::uint64_t i = 0; i < element.count; ++i) {
                for (const Property& property : element.properties) skip(property, body);
            }
        }
    }
    if (mesh.positions.size() != vertices) throw MeshFault{"its vertices lack x, y or z"};
    return mesh;
}

}  // namespace dapple::input
