#include "judge/bench_runs.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/checked_file.h"
#include "base/error.h"
#include "judge/text.h"
#include "run/output_paths.h"
#include "run/timeline_source.h"
#include "timeline/timeline.h"

namespace dapple::judge {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kProgram = "/proc/self/exe";

/// The text of a file of ours; empty where there is none or it cannot be read.
std::string file_text(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return "";
    try {
        const std::vector<std::byte> bytes = read_whole_file(path);
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    } catch (const Error&) {
        return "";
    }
}

/// Time for the repeats to come: as before, and for runs without any as the others' mean.
std::string left(const std::vector<TimedRun>& runs, std::size_t wanted) {
    double known = 0, count = 0;
    for (const TimedRun& run : runs) {
        known += run.mean_process_s();
        count += run.repeats().empty() ? 0 : 1;
    }
    if (count == 0) return "unknown time";
    double sum = 0;
    for (const TimedRun& run : runs) {
        if (!run.failure().empty() || run.repeats().size() >= wanted) continue;
        sum += static_cast<double>(wanted - run.repeats().size()) *
               (run.repeats().empty() ? known / count : run.mean_process_s());
    }
    return run::format_duration(sum);
}

}  // namespace

Renderings::Renderings(int threads, std::string device, const run::Interruption& interruption,
                       run::Reporter& reporter)
    : threads_(threads),
      device_name_(std::move(device)),
      device_({.name = device_name_, .threads = threads}),
      interruption_(interruption),
      reporter_(reporter) {}

run::Job Renderings::job(const std::string& timeline, const std::vector<std::string>& overrides) {
    const auto loaded = timeline::Timeline::load(timeline, overrides);
    run::check_readable(loaded.input_files());
    const run::TimelineSource source(loaded, device_);
    return job_of(loaded, device_, source);
}

bool Renderings::fits(const std::string& folder, const std::string& timeline,
                      const std::vector<std::string>& overrides) {
    try {
        const auto manifest = run::read_manifest(folder + "/manifest.json");
        return !manifest || manifest->job_hash == job(timeline, overrides).hash();
    } catch (const Error&) {
        // No manifest that could be read: it is replaced. Or no job: the process will say why.
        return false;
    }
}

ProcessEnd Renderings::render(const std::string& name, const std::string& timeline,
                              const std::vector<std::string>& overrides,
                              const std::vector<std::int64_t>& frames, const std::string& folder, bool anew) {
    std::vector<std::string> arguments = call(timeline, overrides);
    arguments.insert(arguments.end(), {"-o", folder});
    if (!frames.empty()) arguments.insert(arguments.end(), {"-f", frames_text(frames)});
    if (anew || !fits(folder, timeline, overrides)) {
        arguments.insert(arguments.end(), {"--existing", "overwrite"});
    }
    return run_process(
        arguments, [this] { return interruption_.requested(); },
        [&](const std::string& line) {
            if (line.starts_with("WARNING ")) reporter_.warning(name + ": " + line.substr(8));
            if (line.starts_with("frame ")) reporter_.status(head_ + name + ": " + line);
        });
}

std::vector<std::string> Renderings::plan(const std::string& timeline,
                                          const std::vector<std::string>& overrides) {
    std::vector<std::string> arguments = call(timeline, overrides), lines;
    arguments.emplace_back("--plan");
    run_process(
        arguments, [this] { return interruption_.requested(); },
        [&](const std::string& line) { lines.push_back(line); });
    return lines;
}

std::vector<std::string> Renderings::call(const std::string& timeline,
                                          const std::vector<std::string>& overrides) const {
    std::vector<std::string> arguments = {kProgram, "render", timeline};
    for (const std::string& setting : overrides) arguments.insert(arguments.end(), {"--set", setting});
    if (threads_ > 0) arguments.insert(arguments.end(), {"--threads", std::to_string(threads_)});
    if (!device_name_.empty()) arguments.insert(arguments.end(), {"--device", device_name_});
    return arguments;
}

TimedRun::TimedRun(std::string name, std::string timeline, std::vector<std::string> overrides,
                   std::vector<std::int64_t> frames, std::int64_t warm_up, std::string folder,
                   Renderings& renderings)
    : name_(std::move(name)),
      timeline_(std::move(timeline)),
      overrides_(std::move(overrides)),
      frames_(std::move(frames)),
      warm_up_(warm_up),
      folder_(std::move(folder)),
      renderings_(renderings) {
    identity_ = renderings.job(timeline_, overrides_).hash() + ", frames " + frames_text(frames_) +
                " after " + std::to_string(warm_up_) + ", threads " + std::to_string(renderings.threads()) +
                ", " + renderings.device().info().name;
    const Json known = Json::parse(file_text(timings_file()), nullptr, false);
    if (!known.is_object() || known.value("identity", "") != identity_ || !known.contains("repeats")) return;
    repeats_ = repeats_from_json(known.at("repeats").dump()).value_or(std::vector<Repeat>{});
    // Times without their pictures are of no use.
    if (!holds_pictures()) repeats_.clear();
}

bool TimedRun::holds_pictures() const {
    const auto held = manifest();
    if (!held) return false;
    const run::OutputPaths paths(folder_, held->clip.name);
    return std::all_of(frames_.begin(), frames_.end(), [&](std::int64_t frame) {
        const auto entry = held->frames.find(frame);
        return entry != held->frames.end() && run::matches(paths.linear(frame), entry->second.linear, true);
    });
}

std::optional<run::Manifest> TimedRun::manifest() const {
    try {
        return run::read_manifest(folder_ + "/manifest.json");
    } catch (const Error&) {
        return std::nullopt;
    }
}

bool TimedRun::add_repeat() {
    std::vector<std::int64_t> frames = {warm_up_};
    frames.insert(frames.end(), frames_.begin(), frames_.end());
    const ProcessEnd end = renderings_.render(name_, timeline_, overrides_, frames, folder_, true);
    if (!end.done()) {
        if (renderings_.interrupted()) return false;
        failure_ = end.signal != 0 ? end.error : "exit " + std::to_string(end.exit_code) + ": " + end.error;
        return true;
    }
    std::optional<Repeat> repeat = read_repeat(folder_ + "/stats.jsonl", warm_up_, frames_);
    if (!repeat)
        throw Error(ExitCode::failure, folder_ + "/stats.jsonl: lines of finished frames are missing");
    repeat->process_wall_s = end.wall_s;
    repeat->process_cpu_s = end.cpu_s;
    repeats_.push_back(std::move(*repeat));
    save();
    return true;
}

double TimedRun::mean_process_s() const {
    double sum = 0;
    for (const Repeat& repeat : repeats_) sum += repeat.process_wall_s;
    return repeats_.empty() ? 0 : sum / static_cast<double>(repeats_.size());
}

void TimedRun::save() const {
    const Json json = {{"identity", identity_}, {"repeats", Json::parse(to_json(repeats_))}};
    write_file_atomically(timings_file(), json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

bool add_repeats(std::vector<TimedRun>& runs, std::size_t wanted, Renderings& renderings,
                 run::Reporter& reporter) {
    for (std::size_t repeat = 1; repeat <= wanted; ++repeat) {
        for (TimedRun& run : runs) {
            if (run.repeats().size() >= repeat || !run.failure().empty()) continue;
            if (renderings.interrupted()) return false;
            const std::string number = "repeat " + std::to_string(repeat) + " of " + std::to_string(wanted);
            renderings.set_head(number + ", " + left(runs, wanted) + " left: ");
            if (!run.add_repeat()) return false;
            renderings.set_head("");
            if (!run.failure().empty()) {
                reporter.warning(run.name() + " failed: " + run.failure());
                continue;
            }
            reporter.note(run.name() + ", " + number +
                          formatted(": %.3f s a frame, ", timing_of(run.repeats()).wall_s.median) +
                          left(runs, wanted) + " left");
        }
    }
    return true;
}

std::int64_t warm_up_frame(const std::vector<std::int64_t>& frames, const scene::Clip& clip) {
    const auto wanted = [&](std::int64_t frame) {
        return std::binary_search(frames.begin(), frames.end(), frame);
    };
    for (std::int64_t frame = frames.front(); frame <= clip.last_frame; ++frame)
        if (!wanted(frame)) return frame;
    std::int64_t frame = frames.front() - 1;
    while (wanted(frame)) --frame;
    return frame;
}

}  // namespace dapple::judge
