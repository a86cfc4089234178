#include "run/manifest.h"

#include <sys/stat.h>

#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/hash.h"

namespace dapple::run {
namespace {

using Json = nlohmann::ordered_json;  // keeps the order in which keys are written

constexpr int kFormat = 1;

Json to_json(const WrittenFile& file) {
    return {{"bytes", file.bytes}, {"hash", file.content_hash}};
}

WrittenFile file_from(const Json& json) {
    return {json.at("bytes").get<std::uint64_t>(), json.at("hash").get<std::string>()};
}

Json to_json(const NamedTexts& texts) {
    Json json = Json::object();
    for (const auto& [name, text] : texts) json[name] = text;
    return json;
}

NamedTexts texts_from(const Json& json) {
    NamedTexts texts;
    for (const auto& [name, text] : json.items()) texts.emplace_back(name, text.get<std::string>());
    return texts;
}

Json to_json(const FrameEntry& entry) {
    return {{"linear", to_json(entry.linear)},
            {"graded", to_json(entry.graded)},
            {"non_finite", entry.non_finite},
            {"partly", entry.partly}};
}

FrameEntry frame_from(const Json& json) {
    return {file_from(json.at("linear")), file_from(json.at("graded")),
            json.at("non_finite").get<std::size_t>(), json.at("partly").get<std::vector<std::string>>()};
}

Json to_json(const render::SettledCaustics& settled) {
    Json pilots = Json::array();
    for (const render::PilotError& pilot : settled.pilots)
        pilots.push_back({{"frame", pilot.frame},
                          {"error", pilot.error},
                          {"by_mesh", pilot.by_mesh},
                          {"by_pixels", pilot.by_pixels}});
    return {{"target_error", settled.target},
            {"map_resolution", settled.map_resolution},
            {"footprint", static_cast<int>(settled.footprint)},
            {"denoise_passes", settled.denoise_passes},
            {"pilots", std::move(pilots)},
            {"finest_tried", settled.finest_tried},
            {"most_memory", settled.most_memory}};
}

render::SettledCaustics settled_from(const Json& json) {
    render::SettledCaustics settled;
    settled.target = json.at("target_error").get<double>();
    settled.map_resolution = json.at("map_resolution").get<int>();
    settled.footprint = static_cast<scene::PhotonFootprint>(json.at("footprint").get<int>());
    settled.denoise_passes = json.at("denoise_passes").get<int>();
    for (const Json& pilot : json.at("pilots"))
        settled.pilots.push_back({pilot.at("frame").get<std::int64_t>(), pilot.at("error").get<double>(),
                                  pilot.at("by_mesh").get<double>(), pilot.at("by_pixels").get<double>()});
    settled.finest_tried = json.at("finest_tried").get<int>();
    settled.most_memory = json.at("most_memory").get<std::uint64_t>();
    return settled;
}

std::int64_t number_from(const std::string& text) {
    std::int64_t number = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (fault != std::errc{} || end != text.data() + text.size()) {
        throw Error(ExitCode::usage, "'" + text + "' is no frame number");
    }
    return number;
}

Manifest manifest_from(const Json& json) {
    if (json.at("format").get<int>() != kFormat) throw Error(ExitCode::usage, "it has another format");
    Manifest manifest;
    manifest.job_hash = json.at("job").get<std::string>();
    manifest.parts = texts_from(json.at("made_of"));
    manifest.provenance = texts_from(json.at("made_with"));
    if (json.contains("settled")) manifest.settled = settled_from(json.at("settled"));
    const Json& clip = json.at("clip");
    manifest.clip.name = clip.at("name").get<std::string>();
    manifest.clip.fps = {clip.at("fps").at(0).get<std::int64_t>(), clip.at("fps").at(1).get<std::int64_t>()};
    manifest.clip.first_frame = clip.at("frames").at(0).get<std::int64_t>();
    manifest.clip.last_frame = clip.at("frames").at(1).get<std::int64_t>();
    manifest.clip.width = clip.at("size").at(0).get<int>();
    manifest.clip.height = clip.at("size").at(1).get<int>();
    for (const auto& [number, entry] : json.at("frames").items()) {
        manifest.frames.emplace(number_from(number), frame_from(entry));
    }
    if (json.contains("preview")) {
        const Json& preview = json.at("preview");
        manifest.preview = {file_from(preview), preview.at("source").get<std::string>()};
    }
    return manifest;
}

}  // namespace

std::optional<Manifest> read_manifest(const std::string& path) {
    std::error_code reason;
    if (!std::filesystem::exists(path, reason) && !reason) return std::nullopt;
    try {
        const std::vector<std::byte> bytes = read_whole_file(path);
        const auto* text = reinterpret_cast<const char*>(bytes.data());
        return manifest_from(Json::parse(text, text + bytes.size()));
    } catch (const std::exception& fault) {
        throw Error(ExitCode::usage,
                    path + " cannot be read (" + clipped(fault.what()) +
                        "): choose another folder with -o, or start anew with --existing overwrite");
    }
}

std::optional<render::SettledCaustics> known_settings(const std::string& path, const Job& job) {
    try {
        const std::optional<Manifest> manifest = read_manifest(path);
        if (manifest && manifest->job_hash == job.hash()) return manifest->settled;
    } catch (const Error&) {
        // The frame loop says what is wrong with it.
    }
    return std::nullopt;
}

void write_manifest(const std::string& path, const Manifest& manifest) {
    const scene::Clip& clip = manifest.clip;
    Json frames = Json::object();
    for (const auto& [number, entry] : manifest.frames) frames[std::to_string(number)] = to_json(entry);
    Json json = {{"format", kFormat},
                 {"job", manifest.job_hash},
                 {"made_of", to_json(manifest.parts)},
                 {"made_with", to_json(manifest.provenance)},
                 {"clip",
                  {{"name", clip.name},
                   {"fps", {clip.fps.numerator, clip.fps.denominator}},
                   {"frames", {clip.first_frame, clip.last_frame}},
                   {"size", {clip.width, clip.height}}}},
                 {"frames", std::move(frames)}};
    if (manifest.settled) json["settled"] = to_json(*manifest.settled);
    if (manifest.preview) {
        json["preview"] = to_json(manifest.preview->file);
        json["preview"]["source"] = manifest.preview->source_hash;
    }
    // Names may come from files in any encoding; what is no UTF-8 is replaced, never thrown.
    write_file_atomically(path, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

bool matches(const std::string& path, const WrittenFile& entry, bool content) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
    if (static_cast<std::uint64_t>(status.st_size) != entry.bytes) return false;
    if (!content) return true;
    try {
        const std::vector<std::byte> bytes = read_whole_file(path);
        return content_hash(bytes.data(), bytes.size()) == entry.content_hash;
    } catch (const Error&) {
        return false;  // unreadable is as good as damaged: the frame is made again
    }
}

}  // namespace dapple::run
