#include "run/stats_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>

#include "base/checked_file.h"
#include "base/error.h"
#include "run/json_number.h"

namespace dapple::run {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const WrittenFile& file) {
    return {{"bytes", file.bytes}, {"hash", file.content_hash}};
}

/// Most bins of a histogram are empty: those before the first pixel are not written.
Json histogram_json(const std::vector<std::uint32_t>& histogram) {
    const auto first = std::ranges::find_if(histogram, [](std::uint32_t pixels) { return pixels > 0; });
    return {{"first_bin", first - histogram.begin()},
            {"pixels", std::vector<std::uint32_t>(first, histogram.end())}};
}

std::vector<std::uint32_t> histogram_from(const Json& json) {
    const auto empty = json.at("first_bin").get<std::size_t>();
    const auto pixels = json.at("pixels").get<std::vector<std::uint32_t>>();
    if (empty + pixels.size() > metrics::kHistogramBins) throw std::out_of_range("first_bin");
    std::vector<std::uint32_t> histogram(empty);
    histogram.insert(histogram.end(), pixels.begin(), pixels.end());
    return histogram;
}

Json to_json(const TemporalRecord& record) {
    const metrics::FrameFlicker& figures = record.figures;
    Json json = {{"mean", figures.mean}, {"excluded", figures.excluded}, {"inputs", record.inputs}};
    if (figures.histogram.empty()) return json;
    json["change_before"] = figures.change_before;
    json["change_after"] = figures.change_after;
    json["high_pass_energy"] = figures.high_pass_energy;
    json["high_pass_histogram"] = histogram_json(figures.histogram);
    return json;
}

TemporalRecord record_from(const Json& json) {
    TemporalRecord record;
    record.inputs = json.at("inputs").get<TemporalInputs>();
    metrics::FrameFlicker& figures = record.figures;
    figures.mean = json.at("mean").get<double>();
    figures.excluded = json.at("excluded").get<std::size_t>();
    if (!json.contains("high_pass_histogram")) return record;
    figures.change_before = json.at("change_before").get<double>();
    figures.change_after = json.at("change_after").get<double>();
    figures.high_pass_energy = json.at("high_pass_energy").get<double>();
    figures.histogram = histogram_from(json.at("high_pass_histogram"));
    return record;
}

Json to_json(const metrics::ClipFlicker& clip) {
    return {{"measured_frames", clip.frames.size()},
            {"mean", clip.mean},
            {"flicker", json_number(clip.flicker)},
            {"median_term", clip.median_term},
            {"jump_term", clip.jump_term},
            {"worst_frame", *clip.worst_frame},
            {"worst_flicker", json_number(clip.frames.at(*clip.worst_frame).flicker)}};
}

/// What the file says of a frame.
struct FrameLines {
    Json cost;  ///< the last line that tells it, without temporal figures; null if there is none
    std::optional<TemporalRecord> temporal;
};

std::map<std::int64_t, FrameLines> read_lines(const std::string& path,
                                              const std::map<std::int64_t, FrameEntry>& finished) {
    std::map<std::int64_t, FrameLines> frames;
    std::ifstream stream(path);
    for (std::string line; std::getline(stream, line);) {
        Json json = Json::parse(line, nullptr, false);
        if (!json.is_object() || !json.contains("frame") || !json["frame"].is_number_integer()) continue;
        const auto frame = json["frame"].get<std::int64_t>();
        if (!finished.contains(frame)) continue;
        FrameLines& lines = frames[frame];
        if (json.contains("temporal")) {
            try {
                TemporalRecord record = record_from(json["temporal"]);
                if (record.inputs == temporal_inputs(finished, frame)) lines.temporal = std::move(record);
            } catch (const std::exception&) {
                // Not ours, or damaged: it will be measured again.
            }
            json.erase("temporal");
        }
        if (json.size() > 1) lines.cost = std::move(json);
    }
    return frames;
}

}  // namespace

std::string stats_line(std::int64_t frame, const FrameCost& cost, const FrameStats& stats,
                       const FrameEntry& entry) {
    Json passes = Json::array();
    for (const PassTime& pass : stats.passes()) {
        passes.push_back({{"name", pass.name},
                          {"wall_s", pass.wall_s},
                          {"cpu_s", pass.cpu_s},
                          {"device_s", pass.device_s}});
    }
    Json counts = Json::object();
    for (const auto& [name, amount] : stats.counts()) counts[name] = amount;
    const Json json = {{"frame", frame},
                       {"wall_s", cost.wall_s},
                       {"cpu_s", cost.cpu_s},
                       {"passes", std::move(passes)},
                       {"counts", std::move(counts)},
                       {"peak_memory", cost.peak_memory},
                       {"non_finite", entry.non_finite},
                       {"linear", to_json(entry.linear)},
                       {"graded", to_json(entry.graded)}};
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void append_stats(const std::string& path, const std::string& line) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (file < 0)
        throw Error(ExitCode::output_unwritable, path + ": cannot be opened: " + std::strerror(errno));
    const std::string text = line + "\n";
    try {
        write_all(file, std::as_bytes(std::span(text)), path);
    } catch (...) {
        ::close(file);
        throw;
    }
    const bool synced = ::fsync(file) == 0;
    const int reason = errno;
    ::close(file);
    if (!synced)
        throw Error(ExitCode::output_unwritable, path + ": cannot be synced: " + std::strerror(reason));
}

TemporalInputs temporal_inputs(const std::map<std::int64_t, FrameEntry>& finished, std::int64_t frame) {
    const auto before = finished.find(frame - 1), after = finished.find(frame + 1);
    const std::string& own = finished.at(frame).linear.content_hash;
    if (before == finished.end() || after == finished.end()) return {own};
    return {before->second.linear.content_hash, own, after->second.linear.content_hash};
}

std::string temporal_line(std::int64_t frame, const TemporalRecord& record) {
    return Json{{"frame", frame}, {"temporal", to_json(record)}}.dump();
}

std::map<std::int64_t, TemporalRecord> read_temporal_records(
    const std::string& path, const std::map<std::int64_t, FrameEntry>& finished) {
    std::map<std::int64_t, TemporalRecord> records;
    for (auto& [frame, lines] : read_lines(path, finished)) {
        if (lines.temporal) records[frame] = std::move(*lines.temporal);
    }
    return records;
}

void tidy_stats(const std::string& path, const std::map<std::int64_t, FrameEntry>& finished,
                const metrics::ClipFlicker* clip) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return;
    std::string text;
    for (const auto& [frame, lines] : read_lines(path, finished)) {
        Json json = lines.cost.is_null() ? Json{{"frame", frame}} : lines.cost;
        if (lines.temporal) {
            Json& temporal = json["temporal"] = to_json(*lines.temporal);
            if (clip != nullptr && clip->frames.contains(frame)) {
                temporal["flicker"] = json_number(clip->frames.at(frame).flicker);
                temporal["jump_share"] = clip->frames.at(frame).jump_share;
            }
        }
        text += json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    }
    if (clip != nullptr && clip->worst_frame) text += Json{{"clip", to_json(*clip)}}.dump() + "\n";
    write_file_atomically(path, text);
}

}  // namespace dapple::run
