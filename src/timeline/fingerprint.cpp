#include "timeline/fingerprint.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include "base/number_pattern.h"
#include "base/suggest.h"
#include "scene/water_surface.h"

namespace dapple::timeline {
namespace {

using scene::Field;
using scene::FieldKind;

std::string exact(double value) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.17g", value);
    return text.data();
}

std::string exact(const double* values, std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : " ") + exact(values[i]);
    return text;
}

std::string exact(const Curve& curve) {
    static constexpr std::array<const char*, 4> kNames{"step", "linear", "cubic", "bezier"};
    const std::vector<Key>& keys = curve.keys();
    std::string text;
    for (std::size_t i = 0; i < keys.size(); ++i) {
        text += "@" + exact(keys[i].time) + " " + exact(keys[i].values.data(), curve.components());
        if (i + 1 == keys.size()) break;
        text.append(" ").append(kNames[static_cast<std::size_t>(keys[i].interpolation)]);
        if (keys[i].interpolation == Interpolation::bezier)
            text += " " + exact(&keys[i].out.x, 1) + " " + exact(&keys[i].out.y, 1) + " " +
                    exact(&keys[i + 1].in.x, 1) + " " + exact(&keys[i + 1].in.y, 1);
        text += "; ";
    }
    return text;
}

std::string relative_path(const std::string& path, const std::string& folder) {
    if (path.empty()) return path;
    return std::filesystem::path(path).lexically_relative(folder).generic_string();
}

std::string exact(const Field& field, void* object, const std::string& folder) {
    switch (field.kind) {
        case FieldKind::version:
            return "1";
        case FieldKind::numbers: {
            Values values{};
            const scene::Components numbers = field.components(object);
            std::size_t count = 0;
            for (const double* number : numbers)
                if (number != nullptr) values[count++] = *number;
            return exact(values.data(), count);
        }
        case FieldKind::integer:
        case FieldKind::boolean:
            return std::to_string(field.get(object));
        case FieldKind::choice:
            return std::string(field.choices[static_cast<std::size_t>(field.get(object))]);
        case FieldKind::text:
        case FieldKind::file_name:
            return in_quotes(*static_cast<const std::string*>(field.member(object)));
        case FieldKind::path:
        case FieldKind::path_pattern:
            return in_quotes(relative_path(*static_cast<const std::string*>(field.member(object)), folder));
        case FieldKind::frame_rate: {
            const auto& rate = *static_cast<const scene::Rational*>(field.member(object));
            return std::to_string(rate.numerator) + "/" + std::to_string(rate.denominator);
        }
        case FieldKind::frame_range:
            return "from " + std::to_string(static_cast<const scene::Clip*>(object)->first_frame);
        case FieldKind::resolution: {
            const auto& clip = *static_cast<const scene::Clip*>(object);
            return std::to_string(clip.width) + "x" + std::to_string(clip.height);
        }
        case FieldKind::structure:
            return field.present == nullptr || field.present(object) ? "map" : "none";
        case FieldKind::list:
            return std::to_string(field.size(object));
    }
    return {};
}

bool exists(const std::string& path) {
    std::error_code ignored;  // unreadable folders are found when the file is loaded
    return std::filesystem::exists(path, ignored);
}

/// The file that a sequence shows for `number`; where it is missing and none is there to hold: Error.
template <class Sequence>
std::string shown_file(const Sequence& sequence, std::int64_t number, bool hold) {
    const auto name = [&](std::int64_t n) { return scene::file_path(sequence, n); };
    if (!hold) return name(number);
    return held_file(number, sequence.first_file, name);
}

void add_meshes(const Program& program, std::set<std::string>& files) {
    const scene::MeshSequence& meshes = program.base.water->surface.mesh_sequence;
    const scene::Clip& clip = program.base.clip;
    std::optional<std::int64_t> last;
    for (std::int64_t frame = clip.first_frame; frame <= clip.last_frame; ++frame) {
        const std::int64_t number =
            scene::file_number(meshes, time_of_frame(clip, static_cast<double>(frame)));
        if (number == last) continue;
        last = number;
        files.insert(shown_file(meshes, number, meshes.missing == scene::MissingFrames::hold));
    }
}

void add_grids(const scene::Medium& medium, const scene::Clip& clip, std::set<std::string>& files) {
    std::set<std::int64_t> numbers;
    for (std::int64_t frame = clip.first_frame; frame <= clip.last_frame; ++frame)
        numbers.insert(scene::file_number(medium, frame - clip.first_frame));
    for (const std::int64_t number : numbers) {
        const std::string path = shown_file(medium, number, medium.missing == scene::MissingGrid::hold);
        if (medium.missing != scene::MissingGrid::empty || exists(path)) files.insert(path);
    }
}

}  // namespace

std::string fingerprint(const Program& program, const std::string& folder) {
    scene::FrameState state = program.base;
    std::string text;
    visit_fields(state, [&](const Field& field, void* object, const std::string& path) {
        if (field.no_default && program.given.count(path) == 0) return;
        const auto track = std::find_if(program.tracks.begin(), program.tracks.end(),
                                        [&](const Track& t) { return t.key_path == path; });
        text += path + " = " +
                (track != program.tracks.end() ? exact(track->curve) : exact(field, object, folder)) + "\n";
    });
    return text;
}

std::vector<std::string> input_files(const Program& program) {
    scene::FrameState state = program.base;
    std::set<std::string> files;
    visit_fields(state, [&](const Field& field, void* object, const std::string& key_path) {
        if (field.kind == FieldKind::path) {
            const auto& path = *static_cast<const std::string*>(field.member(object));
            if (!path.empty() && key_path.rfind("media[", 0) != 0) files.insert(path);
        } else if (field.kind == FieldKind::path_pattern) {
            add_meshes(program, files);
        }
    });
    for (const scene::Medium& medium : state.media)
        if (medium.type == scene::MediumType::grid) add_grids(medium, state.clip, files);
    return {files.begin(), files.end()};
}

}  // namespace dapple::timeline
