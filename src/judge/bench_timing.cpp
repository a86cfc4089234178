#include "judge/bench_timing.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

namespace dapple::judge {
namespace {

using Json = nlohmann::ordered_json;

/// The same work for every method, and at the disk's mercy.
constexpr const char* kOutputPasses[] = {"write", "temporal figures"};

FrameTime frame_from(const Json& json) {
    FrameTime frame;
    frame.wall_s = json.at("wall_s").get<double>();
    frame.cpu_s = json.at("cpu_s").get<double>();
    for (const Json& pass : json.at("passes")) {
        frame.passes.push_back({pass.at("name").get<std::string>(), pass.at("wall_s").get<double>(),
                                pass.at("cpu_s").get<double>()});
    }
    for (const auto& [name, amount] : json.at("counts").items()) frame.counts[name] = amount.get<double>();
    frame.peak_memory = json.at("peak_memory").get<std::uint64_t>();
    frame.non_finite = json.at("non_finite").get<std::size_t>();
    frame.content = json.at("linear").at("hash").get<std::string>();
    return frame;
}

Json to_json(const FrameTime& frame) {
    Json passes = Json::array();
    for (const FrameTime::Pass& pass : frame.passes)
        passes.push_back({{"name", pass.name}, {"wall_s", pass.wall_s}, {"cpu_s", pass.cpu_s}});
    return {{"wall_s", frame.wall_s},
            {"cpu_s", frame.cpu_s},
            {"passes", passes},
            {"counts", frame.counts},
            {"peak_memory", frame.peak_memory},
            {"non_finite", frame.non_finite},
            {"linear", {{"hash", frame.content}}}};
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

/// spread_of() what `value` says of each frame.
template <class Value>
Spread spread_over(const std::vector<Repeat>& repeats, const Value& value) {
    std::vector<std::vector<double>> values;
    for (const Repeat& repeat : repeats) {
        values.emplace_back();
        for (const auto& [number, frame] : repeat.frames) values.back().push_back(value(frame));
    }
    return spread_of(values);
}

const FrameTime::Pass* find(const FrameTime& frame, const std::string& name) {
    const auto pass = std::find_if(frame.passes.begin(), frame.passes.end(),
                                   [&](const FrameTime::Pass& p) { return p.name == name; });
    return pass == frame.passes.end() ? nullptr : &*pass;
}

double wall_of(const FrameTime& frame, const std::string& pass) {
    const FrameTime::Pass* found = find(frame, pass);
    return found == nullptr ? 0 : found->wall_s;
}
double cpu_of(const FrameTime& frame, const std::string& pass) {
    const FrameTime::Pass* found = find(frame, pass);
    return found == nullptr ? 0 : found->cpu_s;
}
double rendering_wall(const FrameTime& frame) {
    double wall_s = frame.wall_s;
    for (const char* pass : kOutputPasses) wall_s -= wall_of(frame, pass);
    return wall_s;
}
double rendering_cpu(const FrameTime& frame) {
    double cpu_s = frame.cpu_s;
    for (const char* pass : kOutputPasses) cpu_s -= cpu_of(frame, pass);
    return cpu_s;
}

}  // namespace

std::map<std::int64_t, FrameTime> read_frames(const std::string& stats_file) {
    std::map<std::int64_t, FrameTime> frames;
    std::ifstream stream(stats_file);
    for (std::string line; std::getline(stream, line);) {
        try {
            const Json json = Json::parse(line);
            frames[json.at("frame").get<std::int64_t>()] = frame_from(json);
        } catch (const Json::exception&) {
            continue;
        }
    }
    return frames;
}

std::optional<Repeat> read_repeat(const std::string& stats_file, std::int64_t warm_up,
                                  const std::vector<std::int64_t>& frames) {
    const std::map<std::int64_t, FrameTime> found = read_frames(stats_file);
    Repeat repeat;
    const auto first = found.find(warm_up);
    if (first == found.end()) return std::nullopt;
    repeat.warm_up = first->second;
    for (const std::int64_t frame : frames) {
        const auto entry = found.find(frame);
        if (entry == found.end()) return std::nullopt;
        repeat.frames[frame] = entry->second;
    }
    return repeat;
}

std::string to_json(const std::vector<Repeat>& repeats) {
    Json json = Json::array();
    for (const Repeat& repeat : repeats) {
        Json frames = Json::array();
        for (const auto& [number, frame] : repeat.frames) {
            frames.push_back(to_json(frame));
            frames.back()["frame"] = number;
        }
        json.push_back({{"process_wall_s", repeat.process_wall_s},
                        {"process_cpu_s", repeat.process_cpu_s},
                        {"warm_up", to_json(repeat.warm_up)},
                        {"frames", frames}});
    }
    return json.dump(1, ' ', false, Json::error_handler_t::replace);
}

std::optional<std::vector<Repeat>> repeats_from_json(const std::string& text) {
    try {
        std::vector<Repeat> repeats;
        for (const Json& json : Json::parse(text)) {
            Repeat repeat;
            repeat.process_wall_s = json.at("process_wall_s").get<double>();
            repeat.process_cpu_s = json.at("process_cpu_s").get<double>();
            repeat.warm_up = frame_from(json.at("warm_up"));
            for (const Json& frame : json.at("frames"))
                repeat.frames[frame.at("frame").get<std::int64_t>()] = frame_from(frame);
            if (repeat.frames.empty()) return std::nullopt;
            repeats.push_back(std::move(repeat));
        }
        return repeats;
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

Spread spread_of(const std::vector<std::vector<double>>& values) {
    const std::size_t frames = values.front().size();
    double sum = 0, least = 1, most = 1;
    for (std::size_t f = 0; f < frames; ++f) {
        std::vector<double> of_frame;
        of_frame.reserve(values.size());
        for (const std::vector<double>& repeat : values) of_frame.push_back(repeat[f]);
        const double middle = median(of_frame);
        sum += middle;
        if (!(middle > 0)) continue;
        for (const double value : of_frame) {
            least = std::min(least, value / middle);
            most = std::max(most, value / middle);
        }
    }
    const double mean = sum / static_cast<double>(frames);
    return {mean, least * mean, most * mean};
}

Timing timing_of(const std::vector<Repeat>& repeats) {
    Timing timing;
    timing.wall_s = spread_over(repeats, rendering_wall);
    timing.cpu_s = spread_over(repeats, rendering_cpu);
    for (const FrameTime::Pass& pass : repeats.front().frames.begin()->second.passes) {
        timing.passes.push_back(
            {pass.name,
             spread_over(repeats, [&](const FrameTime& frame) { return wall_of(frame, pass.name); }),
             spread_over(repeats, [&](const FrameTime& frame) { return cpu_of(frame, pass.name); })});
    }
    std::vector<double> warm_up, start_up;
    for (const Repeat& repeat : repeats) {
        double frames_s = 0;
        double mean = 0;
        for (const auto& [number, frame] : repeat.frames) {
            frames_s += frame.wall_s;
            mean += rendering_wall(frame) / static_cast<double>(repeat.frames.size());
            timing.peak_memory = std::max(timing.peak_memory, static_cast<double>(frame.peak_memory));
            timing.same_bits = timing.same_bits && frame.content == repeats.front().frames.at(number).content;
        }
        warm_up.push_back(rendering_wall(repeat.warm_up) - mean);
        start_up.push_back(repeat.process_wall_s - repeat.warm_up.wall_s - frames_s);
    }
    for (const auto& [number, frame] : repeats.front().frames) timing.non_finite += frame.non_finite;
    timing.warm_up_s = median(warm_up);
    timing.start_up_s = median(start_up);
    return timing;
}

TimeToError time_to_error(std::vector<std::pair<double, double>> points, double error) {
    std::erase_if(points, [](const auto& point) { return !(point.first > 0 && point.second >= 0); });
    std::sort(points.begin(), points.end());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& [t1, e1] = points[i];
        if (e1 > error) continue;
        if (i == 0 || e1 == 0 || std::isinf(points[i - 1].second)) return {TimeToError::State::at_most, t1};
        const auto& [t0, e0] = points[i - 1];
        const double way = std::log(e0 / error) / std::log(e0 / e1);
        return {TimeToError::State::reached, t0 * std::pow(t1 / t0, way)};
    }
    return {};
}

}  // namespace dapple::judge
