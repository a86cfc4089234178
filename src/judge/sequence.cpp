#include "judge/sequence.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/number_pattern.h"
#include "run/manifest.h"
#include "run/output_paths.h"

namespace dapple::judge {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNamed = 8;    // of the files or sequences that a message lists
constexpr std::size_t kMostDigits = 18;  // more do not fit the number

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ExitCode::input_unreadable, clipped(message));
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

bool is_picture(std::string_view name) {
    if (name.size() < 5) return false;
    std::string extension(name.substr(name.size() - 4));
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".exr" || extension == ".png";
}

/// A file's name around its number.
struct NumberedName {
    std::string before, digits, after;  ///< the sign stands in the digits
    std::int64_t number = 0;
};

std::optional<std::int64_t> number_from(std::string_view digits) {
    std::int64_t number = 0;
    const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (fault != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
    return number;
}

/// The last run of digits before the extension is the number. A '-' before it is its sign where it stands
/// first or after '.' or '_' ("clip.-001.exr"), else it belongs to the name ("clip-001.exr").
std::optional<NumberedName> numbered(const std::string& name) {
    const std::size_t extension = name.rfind('.');
    std::size_t end = extension;
    while (end > 0 && !is_digit(name[end - 1])) --end;
    std::size_t begin = end;
    while (begin > 0 && is_digit(name[begin - 1])) --begin;
    if (begin == end || end - begin > kMostDigits) return std::nullopt;
    if (begin > 0 && name[begin - 1] == '-' &&
        (begin == 1 || name[begin - 2] == '.' || name[begin - 2] == '_')) {
        --begin;
    }
    NumberedName parts{name.substr(0, begin), name.substr(begin, end - begin), name.substr(end), 0};
    parts.number = *number_from(parts.digits);
    return parts;
}

/// Names of the regular files in a folder, sorted, without hidden ones: temporaries are hidden.
std::vector<std::string> files_in(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code reason;
    for (fs::directory_iterator entry(folder, reason), end; !reason && entry != end;
         entry.increment(reason)) {
        std::error_code unknown;
        const std::string name = entry->path().filename().string();
        if (!name.starts_with('.') && entry->is_regular_file(unknown)) names.push_back(name);
    }
    if (reason) refuse("the folder " + folder.string() + " cannot be read: " + reason.message());
    std::ranges::sort(names);
    return names;
}

std::string list_of(const std::vector<std::string>& names) {
    if (names.empty()) return "nothing";
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i) {
        text += (i > 0 ? ", " : "") + names[i];
    }
    if (names.size() > kMostNamed) text += " and " + std::to_string(names.size() - kMostNamed) + " more";
    return text;
}

std::string pattern_of(const NumberedName& name) {
    return name.before + "%0" + std::to_string(name.digits.size()) + "d" + name.after;
}

void add_file(Sequence& sequence, std::int64_t number, const fs::path& path) {
    const auto [place, added] = sequence.files.emplace(number, path.string());
    if (!added) {
        refuse(sequence.name + ": frame " + std::to_string(number) + " is there twice, as " + place->second +
               " and as " + path.string());
    }
}

void check_range(const std::string& name, std::int64_t first, std::int64_t last) {
    // The difference of any two numbers fits without a sign.
    const std::uint64_t length = static_cast<std::uint64_t>(last) - static_cast<std::uint64_t>(first);
    if (first > last || length >= kMostFrames) {
        refuse(name + ": frames " + std::to_string(first) + " to " + std::to_string(last) +
               " are no clip; at most " + std::to_string(kMostFrames) + " frames are judged");
    }
}

void set_range_of_files(Sequence& sequence) {
    sequence.first = sequence.files.begin()->first;
    sequence.last = sequence.files.rbegin()->first;
    check_range(sequence.name, sequence.first, sequence.last);
}

/// Whether printing the number by the pattern gives this text.
bool fits(std::string_view text, std::int64_t number, std::size_t digits) {
    std::string printed = std::to_string(number < 0 ? -number : number);
    const std::size_t sign = number < 0 ? 1 : 0;
    if (printed.size() + sign < digits) printed.insert(0, digits - sign - printed.size(), '0');
    return text == (number < 0 ? "-" + printed : printed);
}

Sequence by_pattern(const std::string& specification, const fs::path& folder, const std::string& name,
                    const NumberPattern& place) {
    const std::string before = name.substr(0, place.begin);
    const std::string after = name.substr(place.begin + place.length);
    Sequence sequence;
    sequence.name = specification;
    const std::vector<std::string> names = files_in(folder);
    for (const std::string& file : names) {
        if (file.size() <= before.size() + after.size() || !file.starts_with(before) ||
            !file.ends_with(after)) {
            continue;
        }
        const std::string_view text =
            std::string_view(file).substr(before.size(), file.size() - before.size() - after.size());
        const std::optional<std::int64_t> number =
            text.size() <= kMostDigits ? number_from(text) : std::nullopt;
        if (number && fits(text, *number, place.digits)) add_file(sequence, *number, folder / file);
    }
    if (sequence.files.empty()) {
        refuse("no file is called " + specification + "; in " + folder.string() + " there is " +
               list_of(names));
    }
    if (!is_picture(name)) refuse(specification + ": sequences of .exr and .png are read");
    set_range_of_files(sequence);
    return sequence;
}

Sequence of_manifest(const std::string& specification, const fs::path& path, Pictures pictures) {
    std::optional<run::Manifest> manifest;
    try {
        manifest = run::read_manifest(path.string());
    } catch (const Error&) {
        refuse(path.string() + " is no manifest of dapple, or it is damaged");
    }
    if (!manifest) refuse("there is no " + path.string());
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    const run::OutputPaths paths(folder.string(), manifest->clip.name);
    Sequence sequence;
    sequence.name = specification;
    sequence.first = manifest->clip.first_frame;
    sequence.last = manifest->clip.last_frame;
    check_range(path.string(), sequence.first, sequence.last);
    const scene::Rational& fps = manifest->clip.fps;
    if (fps.numerator <= 0 || fps.denominator <= 0) {
        refuse(path.string() + ": " + std::to_string(fps.numerator) + "/" + std::to_string(fps.denominator) +
               " frames a second are no frame rate");
    }
    sequence.fps = static_cast<double>(fps.numerator) / static_cast<double>(fps.denominator);
    for (const auto& [frame, entry] : manifest->frames) {
        if (frame < sequence.first || frame > sequence.last) continue;
        const bool linear = pictures == Pictures::linear;
        const std::string file = linear ? paths.linear(frame) : paths.graded(frame);
        sequence.expected.emplace(frame, linear ? entry.linear : entry.graded);
        std::error_code unknown;
        if (fs::is_regular_file(file, unknown)) sequence.files.emplace(frame, file);
    }
    if (sequence.files.empty()) {
        refuse(path.string() + ": none of the clip's frames is there (" +
               std::to_string(sequence.expected.size()) + " are entered)");
    }
    return sequence;
}

/// The one numbered sequence of a folder.
Sequence of_folder(const std::string& specification, const fs::path& folder, const std::string& hint) {
    std::map<std::pair<std::string, std::string>, std::vector<NumberedName>> groups;
    const std::vector<std::string> names = files_in(folder);
    for (const std::string& name : names) {
        if (!is_picture(name)) continue;
        if (std::optional<NumberedName> parts = numbered(name)) {
            groups[{parts->before, parts->after}].push_back(std::move(*parts));
        }
    }
    if (groups.empty()) {
        refuse(folder.string() + " holds no numbered .exr or .png pictures" + hint + "; there is " +
               list_of(names));
    }
    if (groups.size() > 1) {
        std::vector<std::string> patterns;
        patterns.reserve(groups.size());
        for (const auto& [key, group] : groups) patterns.push_back(pattern_of(group.front()));
        refuse(folder.string() + " holds " + std::to_string(groups.size()) +
               " sequences; name one of them: " + list_of(patterns));
    }
    Sequence sequence;
    sequence.name = specification;
    for (const NumberedName& parts : groups.begin()->second) {
        add_file(sequence, parts.number, folder / (parts.before + parts.digits + parts.after));
    }
    set_range_of_files(sequence);
    return sequence;
}

Sequence in_folder(const std::string& specification, Pictures pictures) {
    const fs::path folder(specification);
    const fs::path manifest = folder / "manifest.json";
    std::error_code unknown;
    if (!fs::is_regular_file(manifest, unknown)) return of_folder(specification, folder, "");
    try {
        return of_manifest(specification, manifest, pictures);
    } catch (const Error& fault) {
        // Other programs write files of that name too: the pictures beside it may still be a sequence.
        return of_folder(specification, folder, std::string(" (") + fault.what() + ")");
    }
}

Sequence single(const std::string& specification) {
    if (!is_picture(specification)) {
        refuse(specification + ": is neither an .exr nor a .png picture, nor a manifest.json");
    }
    const fs::path path(specification);
    const std::optional<NumberedName> parts = numbered(path.filename().string());
    Sequence sequence;
    sequence.name = specification;
    sequence.files.emplace(parts ? parts->number : 0, path.string());
    set_range_of_files(sequence);
    return sequence;
}

}  // namespace

Sequence find_sequence(const std::string& specification, Pictures pictures) {
    if (specification.empty()) refuse("an empty name is no sequence");
    const fs::path path(specification);
    std::error_code unknown;
    const fs::file_status status = fs::status(path, unknown);
    if (fs::is_directory(status)) return in_folder(specification, pictures);
    if (fs::is_regular_file(status)) {
        return path.extension() == ".json" ? of_manifest(specification, path, pictures)
                                           : single(specification);
    }
    const std::string name = path.filename().string();
    const NumberPattern place = find_number(name);
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (place.length == 0 || !fs::is_directory(folder, unknown)) {
        refuse("there is no " + specification +
               "; a sequence is a pattern as clip.%04d.exr or clip.####.exr, a folder, a manifest.json or "
               "one picture");
    }
    return by_pattern(specification, folder, name, place);
}

void pair_singles(const Sequence& sequence, Sequence& reference) {
    if (sequence.files.size() != 1 || reference.files.size() != 1) return;
    if (!sequence.expected.empty() || !reference.expected.empty()) return;
    const std::int64_t frame = sequence.files.begin()->first;
    reference.files = {{frame, reference.files.begin()->second}};
    reference.first = reference.last = frame;
}

std::vector<std::int64_t> all_frames(const std::vector<Sequence>& sequences) {
    std::int64_t first = sequences.front().first;
    std::int64_t last = sequences.front().last;
    std::string names;
    for (const Sequence& sequence : sequences) {
        first = std::min(first, sequence.first);
        last = std::max(last, sequence.last);
        names += (names.empty() ? "" : " and ") + sequence.name;
    }
    check_range(names, first, last);
    std::vector<std::int64_t> frames;
    for (std::int64_t frame = first; frame <= last; ++frame) frames.push_back(frame);
    return frames;
}

}  // namespace dapple::judge
