#include "run/stats_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "base/checked_file.h"
#include "base/error.h"

namespace dapple::run {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const WrittenFile& file) {
    return {{"bytes", file.bytes}, {"hash", file.content_hash}};
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

void tidy_stats(const std::string& path, const std::map<std::int64_t, FrameEntry>& finished) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return;
    std::map<std::int64_t, std::string> lines;
    std::ifstream stream(path);
    for (std::string line; std::getline(stream, line);) {
        const Json json = Json::parse(line, nullptr, false);
        if (!json.is_object() || !json.contains("frame") || !json["frame"].is_number_integer()) continue;
        const auto frame = json["frame"].get<std::int64_t>();
        if (finished.contains(frame)) lines[frame] = line;
    }
    std::string text;
    for (const auto& [frame, line] : lines) text += line + "\n";
    write_file_atomically(path, text);
}

}  // namespace dapple::run
