#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "judge/compare_layout.h"
#include "judge/compare_look.h"
#include "judge/compare_plan.h"
#include "judge/compare_survey.h"
#include "report/canvas.h"
#include "report/canvas_plot.h"

namespace dapple::judge {

/// Composes the frames of the video. Pictures are put in bit by bit, and nothing is drawn over them but the
/// divider of the wipe.
class Composer {
public:
    /// `view`: Look::description.
    Composer(const Comparison& comparison, const Survey& survey, const Layout& layout,
             const std::string& view);

    /// Frame number `index` of Comparison::frames; a picture of each sequence.
    report::Canvas compose(std::size_t index, const std::vector<ComparedPicture>& pictures) const;

    /// The wipe goes from the middle to the right, to the left end and back to the middle, with B, C, D one
    /// after the other in equal parts of the clip.
    struct Wipe {
        std::size_t sequence = 1;  ///< right of the divider; A is left of it
        int divider = 0;           ///< x in the panel; kDividerWidth pixels around it are the divider
    };
    Wipe wipe_at(std::size_t index) const;
    static constexpr int kDividerWidth = 2;

private:
    void draw_still_parts(const std::string& view);
    void draw_sides(report::Canvas& canvas, const std::vector<ComparedPicture>& pictures) const;
    void draw_wipe(report::Canvas& canvas, std::size_t index,
                   const std::vector<ComparedPicture>& pictures) const;
    void draw_differences(report::Canvas& canvas, const std::vector<ComparedPicture>& pictures) const;
    void draw_slices(report::Canvas& canvas, std::size_t index) const;

    const Comparison& comparison_;
    const Survey& survey_;
    const Layout& layout_;
    std::optional<report::CanvasPlot> mean_plot_, flicker_plot_;
    report::Canvas still_;  ///< what is the same in all frames
};

}  // namespace dapple::judge
