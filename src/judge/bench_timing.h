#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dapple::judge {

/// What one frame of one repeat cost, from a line of stats.jsonl.
struct FrameTime {
    double wall_s = 0;
    double cpu_s = 0;
    struct Pass {
        std::string name;
        double wall_s = 0;
        double cpu_s = 0;
    };
    std::vector<Pass> passes;
    std::map<std::string, double> counts;
    std::uint64_t peak_memory = 0;  ///< bytes, of the process so far
    std::size_t non_finite = 0;
    std::string content;  ///< hash of the linear picture
};

/// One process that rendered all frames of a run.
struct Repeat {
    double process_wall_s = 0;
    double process_cpu_s = 0;
    FrameTime warm_up;  ///< the frame before the others, which pays for what a process does once
    std::map<std::int64_t, FrameTime> frames;
};

/// Lines of a stats.jsonl as a repeat; `warm_up` is the number of its first frame. Nothing where a frame of
/// `frames` or the warm-up is missing.
std::optional<Repeat> read_repeat(const std::string& stats_file, std::int64_t warm_up,
                                  const std::vector<std::int64_t>& frames);

/// Frames of a stats.jsonl by number; lines of another form are left out.
std::map<std::int64_t, FrameTime> read_frames(const std::string& stats_file);

/// Repeats as JSON text, and back; what is not of this form gives nothing.
std::string to_json(const std::vector<Repeat>& repeats);
std::optional<std::vector<Repeat>> repeats_from_json(const std::string& text);

/// Seconds a frame: the mean over frames of their medians over repeats. `least` and `most` are the same times
/// the least and the largest ratio of one frame of one repeat to that frame's median.
struct Spread {
    double median = 0;
    double least = 0;
    double most = 0;
};

struct Timing {
    Spread
        wall_s;  ///< a frame, without writing its files and its temporal figures: the same for every method
    Spread cpu_s;
    struct Pass {
        std::string name;
        Spread wall_s;
        Spread cpu_s;
    };
    std::vector<Pass> passes;    ///< all of them, also those left out above
    double warm_up_s = 0;        ///< what the first frame took beyond the others' mean; median over repeats
    double start_up_s = 0;       ///< of the process outside its frames; median
    double peak_memory = 0;      ///< bytes; largest of all repeats
    std::size_t non_finite = 0;  ///< values, over all frames
    bool same_bits = true;       ///< every repeat gave the same pictures
};

/// At least one repeat of at least one frame.
Timing timing_of(const std::vector<Repeat>& repeats);

/// `values[r][f]`, repeat by repeat.
Spread spread_of(const std::vector<std::vector<double>>& values);

/// What a ladder says of the time that an error takes.
struct TimeToError {
    enum class State {
        reached,      ///< between two rungs, interpolated
        at_most,      ///< at a rung, and no line tells how much before it: `seconds` are its
        not_reached,  ///< no rung is there
        not_known,    ///< the reference's noise, and so its time, is not known
    };
    State state = State::not_reached;
    double seconds = 0;
};

/// The least time at which the error falls to `error`, along straight lines in log(time), log(error) between
/// neighbours in the order of time; no line leads to a point of error 0 (too small to be told), or from one
/// of infinite error. `points`: seconds, above 0, and error; others are left out.
TimeToError time_to_error(std::vector<std::pair<double, double>> points, double error);

}  // namespace dapple::judge
