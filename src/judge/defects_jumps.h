#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "judge/block_signals.h"
#include "judge/box.h"
#include "metrics/picture.h"

namespace dapple::judge {

/// A frame that does not continue the motion of those around it.
struct Jump {
    enum class Kind {
        flash,        ///< the whole frame is brighter or darker than both its neighbours
        pop,          ///< a region differs from what it is in both neighbours
        step,         ///< the picture jumps between the frame before and this one, and stays
        region_step,  ///< the same in a region
    };
    Kind kind = Kind::flash;
    std::int64_t frame = 0;
    double score = 0;  ///< multiple of the threshold, at least 1
    Box region;        ///< of the blocks that jump; the picture for flash and step
};

/// Finds jumps without false alarms from moving water, by comparing what is measured of each frame
/// (BlockSignals) with what its surroundings in space and time usually do.
///
/// A region pops where `lone` exceeds the usual `change`, or `offset` kOffset times the usual `bend`, and
/// both exceed kAnywhere times what any block has of them in the nearest frames, the one largest frame left
/// out: foci that pass show for one frame too, now here and now there. A region steps where its `change`
/// exceeds kRegionStep times the usual one. A block counts where one beside it does too, or where its score
/// is kSingle; a step where four in a square do. What differs from one neighbour far more than from the other
/// is weighed down: it belongs to that neighbour. "Usual" is the larger of the block's median over kReach
/// frames to either side, and of the most, but for the one largest, that it and the blocks around it do in
/// the nearest kNear frames of either side that neither the jump itself nor one before it touches. A frame
/// flashes where its mean offset exceeds kFlash times the median mean bend, unless a region explains it, and
/// steps where its mean change exceeds kStep times those of the nearest frames. All have floors. The first
/// and the last frame of a clip, or before a gap, have one neighbour: what is odd about them is found as a
/// step. Below 6 frames in a row nothing is usual, and nothing is found.
class JumpFinder {
public:
    /// `level`: m, of luminance; a clip of level 0 has no jumps.
    JumpFinder(int width, int height, double level);

    /// The next frame; `reference` of the same frame, or null.
    void add(std::int64_t frame, const metrics::Picture& picture, const metrics::Picture* reference);
    /// The next frame cannot be had.
    void add_gap(std::int64_t frame);
    /// The next frame shows what the frame before shows: what it leaves out is no jump of the frame after.
    void add_repeat(std::int64_t frame, const metrics::Picture& picture, const metrics::Picture* reference);

    /// In the order of frames, after the last one.
    std::vector<Jump> finish();

    static constexpr int kReach = 8;  ///< frames to either side that say what is usual
    static constexpr int kNear = 3;
    static constexpr double kLone = 1;  ///< thresholds, in multiples of what is usual
    static constexpr double kOffset = 3;
    static constexpr double kAnywhere = 1.5;
    static constexpr double kSingle = 2;  ///< score above which one block alone counts as a region
    static constexpr double kRegionStep = 3;
    static constexpr double kFlash = 8;
    static constexpr double kStep = 1.4;

private:
    struct Signals : BlockSignals {
        std::int64_t frame = 0;
        bool repeat = false;
        bool alone = false;  ///< found to flash or pop
        double alone_score = 0;
    };
    using Field = std::vector<float> Signals::*;
    using Mean = std::optional<double> Signals::*;
    /// Indices of signals that an event touches.
    struct Touched {
        std::size_t first = 0, last = 0;
    };
    /// What is usual near a frame that is judged.
    struct Around {
        std::vector<std::size_t> changes, bends;  ///< near() of these fields
        double lone = 0, offset = 0;              ///< alone_anywhere() of these fields
    };

    void measure(std::int64_t frame, bool repeat, const metrics::Picture& picture,
                 const metrics::Picture* reference);
    void judge_ready();
    void judge_next();
    void judge_lone(std::size_t index);
    void judge_step(std::size_t index);
    double flash_score(std::size_t index) const;
    double step_score(std::size_t index) const;
    double alone_anywhere(Field field, const std::vector<std::size_t>& nearest) const;
    double lone_score(std::size_t index, std::size_t block, const Around& around) const;
    double explained_share(std::size_t index, const std::vector<std::size_t>& blocks) const;
    std::vector<std::size_t> grouped(const std::vector<double>& scores, double single) const;
    std::vector<std::size_t> squares(const std::vector<double>& scores) const;
    Jump region_jump(Jump::Kind kind, std::int64_t frame, const std::vector<double>& scores,
                     const std::vector<std::size_t>& blocks) const;
    std::optional<Jump> find_lone(std::size_t index) const;
    std::vector<std::size_t> near(Field field, Touched touched) const;
    double usual(Field field, Touched touched, const std::vector<std::size_t>& nearest,
                 std::size_t block) const;
    std::vector<double> values_of(Mean mean, Touched touched) const;

    BlockGrid grid_;
    bool has_light_;  ///< a level above 0
    SignalMeter meter_;
    std::deque<Signals> signals_;  ///< from kReach frames before the next to judge
    std::size_t next_ = 0;         ///< index in signals_ of the next frame to judge
    std::vector<Jump> jumps_;
};

}  // namespace dapple::judge
