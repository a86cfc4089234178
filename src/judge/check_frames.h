#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "judge/check.h"
#include "judge/check_pilots.h"
#include "judge/sequence_reader.h"

namespace dapple::judge {

/// Measures frames one after the other. Memory: three frames and a few planes, beside what is kept of a frame
/// (FrameFigures).
class FrameMeasurer {
public:
    FrameMeasurer(const CheckOptions& options, const Pilots& pilots, double fps);
    ~FrameMeasurer();

    /// The next frame, and that of the reference where there is one. Numbers that are left out and what
    /// cannot be read are gaps: no frame has a neighbour across one.
    void add(ReadFrame frame, std::optional<ReadFrame> reference);
    /// After the last one.
    void finish(CheckResult& result);

    /// What it found on the way.
    struct Found {
        std::vector<Jump> jumps;
        std::vector<std::int64_t> repeats;          ///< frames equal to the frame before, which was there
        std::size_t pairs = 0;                      ///< of frames that were compared for that
        std::map<std::int64_t, std::int64_t> same;  ///< frame: an earlier one of equal pixels
        std::vector<Finding> findings;              ///< of single frames: values and the reference
    };
    const Found& found() const { return found_; }

private:
    struct Step {
        ReadFrame frame;
        std::optional<ReadFrame> reference;
        std::string hash, reference_hash;
        std::size_t figures = 0;  ///< index
        bool whole = false;       ///< it can be measured, with its reference where there is one
    };

    void check_values(const ReadFrame& frame, FindingKind kind, const std::string& whose);
    void begin_anew(std::int64_t frame);
    void pair(Step& step);
    void check_repeat(Step& step);
    void measure_errors(Step& step);
    void measure_flip(const Step* before, Step& step);
    void measure_changes(Step& before, Step& step);
    void measure_middle();
    void add_to_finder(const Step& step, bool repeat);
    void add_to_deviation(const Step& before, const Step& step, const Step& after);

    CheckOptions options_;
    Pilots pilots_;
    Found found_;
    std::deque<Step> steps_;  ///< of the last three frames
    std::vector<FrameFigures> figures_;
    std::map<std::int64_t, metrics::FrameFlicker> flicker_;
    metrics::BandFlicker bands_;
    metrics::BiasFlicker bias_;
    bool compared_ = false;
    std::unique_ptr<JumpFinder> finder_;
    std::map<std::string, std::int64_t> hashes_;
    std::vector<double> deviation_;
    std::size_t deviations_ = 0;
    FlipKind flip_kind_ = FlipKind::automatic;
    bool display_referred_ = false;
    int width_ = 0, height_ = 0;
};

}  // namespace dapple::judge
