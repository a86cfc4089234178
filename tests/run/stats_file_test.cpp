#include "run/stats_file.h"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "run/json_number.h"
#include "run/scratch_folder.h"
#include "run/told_figures.h"

namespace dapple::run {
namespace {

TEST(JsonNumber, KeepsWhatJsonHasNoNumberFor) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(json_number(0.1).dump(), "0.1");
    EXPECT_EQ(json_number(infinity).dump(), "\"inf\"");
    EXPECT_EQ(json_number(-infinity).dump(), "\"-inf\"");
    EXPECT_EQ(json_number(std::numeric_limits<double>::quiet_NaN()).dump(), "\"nan\"");
}

/// What flickers about a mean of 0 does so infinitely: no figure that is missing, which null would be.
TEST(StatsFile, SaysInfiniteFlicker) {
    const testing_tools::ScratchFolder scratch;
    const std::string path = scratch / "stats.jsonl";
    std::map<std::int64_t, FrameEntry> finished;
    for (const std::int64_t frame : {1, 2, 3})
        finished[frame].linear.content_hash = "hash of " + std::to_string(frame);
    std::map<std::int64_t, metrics::FrameFlicker> frames;
    for (const std::int64_t frame : {1, 2, 3}) {
        if (frame == 2) {
            frames[frame].high_pass_energy = 0.25;
            frames[frame].histogram = {1};
        }
        append_stats(path, temporal_line(frame, {temporal_inputs(finished, frame), frames[frame]}));
    }
    const metrics::ClipFlicker clip = metrics::clip_flicker(frames);
    tidy_stats(path, finished, &clip);
    const testing_tools::Told told = testing_tools::told(scratch / "");
    EXPECT_EQ(nlohmann::json::parse(told.frames.at(2)).at("flicker"), "inf");
    const auto summary = nlohmann::json::parse(told.clip);
    EXPECT_EQ(summary.at("flicker"), "inf");
    EXPECT_EQ(summary.at("worst_flicker"), "inf");
    EXPECT_EQ(summary.at("worst_frame"), 2);
    EXPECT_EQ(read_temporal_records(path, finished).at(2).figures, frames.at(2));
}

}  // namespace
}  // namespace dapple::run
