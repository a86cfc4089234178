#pragma once
#include <chrono>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "base/checked_file.h"
#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "run/frame_source.h"
#include "run/job.h"

namespace dapple::run {

/// Frames of hashed noise, made in parallel, with faults on demand.
class FakeSource : public FrameSource {
public:
    int width = 16;
    int height = 9;
    std::chrono::milliseconds delay{0};
    std::size_t memory = 1000;            ///< bytes a frame
    std::set<std::int64_t> broken;        ///< render() throws Error(input_unreadable)
    std::set<std::int64_t> not_finite;    ///< one value reported
    std::set<std::int64_t> partly;        ///< a pass of the plan
    std::set<std::int64_t> large;         ///< 64 times the pixels
    std::map<std::int64_t, float> flash;  ///< added to the linear picture
    std::vector<std::int64_t> rendered;   ///< frames asked for so far
    std::set<std::int64_t> slow;          ///< frames of kSteps steps, each kept in the checkpoint
    int steps_before_stop = -1;           ///< stops by itself after so many; -1: only where the loop asks
    std::chrono::milliseconds step{0};
    int steps_taken = 0;  ///< by all frames
    static constexpr int kSteps = 10;

    SourceFrame render(std::int64_t frame, FrameStats& stats,
                       const methods::Checkpoint& checkpoint) override {
        const ScopedPass pass(stats, "noise");
        if (broken.contains(frame)) throw Error(ExitCode::input_unreadable, "mesh.obj: no such file");
        rendered.push_back(frame);
        take_steps(frame, checkpoint);
        std::this_thread::sleep_for(delay);
        const int scale = large.contains(frame) ? 8 : 1;
        SourceFrame result;
        result.linear = noise(frame, scale, {"R", "G", "B", "A", "Z"}, image::PixelType::float32);
        result.graded = noise(frame, scale, {"R", "G", "B"}, image::PixelType::half_float);
        if (const auto more = flash.find(frame); more != flash.end()) {
            for (const char* name : {"R", "G", "B"}) {
                for (float& value : result.linear.find(name)->values) value += more->second;
            }
        }
        result.plan = {{"noise", partly.contains(frame) ? "partly" : "yes", "made up"}};
        stats.count("pixels", static_cast<double>(result.linear.pixels()));
        if (not_finite.contains(frame)) result.non_finite = {1, "R 3,4"};
        return result;
    }

    std::size_t bytes(std::int64_t) const override { return memory; }

private:
    /// Does the steps that the checkpoint does not hold yet.
    void take_steps(std::int64_t frame, const methods::Checkpoint& checkpoint) {
        if (!slow.contains(frame)) return;
        int done = 0;
        std::ifstream(checkpoint.file) >> done;
        while (done < kSteps) {
            if (steps_before_stop == 0 || checkpoint.stop()) throw Error(ExitCode::interrupted, "stopped");
            if (steps_before_stop > 0) --steps_before_stop;
            std::this_thread::sleep_for(step);
            ++steps_taken;
            write_file_atomically(checkpoint.file, std::to_string(++done));
        }
    }

    image::Image noise(std::int64_t frame, int scale, const std::vector<std::string>& names,
                       image::PixelType type) const {
        image::Image image;
        image.width = width * scale;
        image.height = height * scale;
        for (const std::string& name : names) {
            image::Channel channel{name, type, std::vector<float>(image.pixels())};
            parallel_for(image.pixels(), 16, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    channel.values[i] = static_cast<float>(hash_uniform(
                        1, static_cast<std::uint64_t>(frame), i, static_cast<std::uint32_t>(name[0])));
                }
            });
            image.channels.push_back(std::move(channel));
        }
        return image;
    }
};

/// A job of frames 1 to 6 for it.
inline Job fake_job(const std::string& timeline = "a") {
    Job job;
    job.clip.name = "fake";
    job.clip.first_frame = 1;
    job.clip.last_frame = 6;
    job.clip.fps = {24000, 1001};
    job.clip.width = 16;
    job.clip.height = 9;
    job.parts = {{"timeline", timeline}, {"program", "1"}};
    job.provenance = {{"device", "none"}};
    return job;
}

}  // namespace dapple::run
