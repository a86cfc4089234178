#pragma once
#include <cstddef>
#include <vector>

#include "judge/box.h"
#include "judge/compare.h"

namespace dapple::judge {

/// A picture or a slice of the video, below its caption.
struct Panel {
    Box box;      ///< what it shows; 0 wide where the video has none
    Box caption;  ///< a line over it, at least as wide
    Box footer;   ///< a line under it; 0 high where it has none
};

/// Where the parts of the video stand, in its pixels. With n sequences: n columns, in rows the pictures; the
/// wipe and n - 1 differences; the slices; and two plots over the whole width.
struct Layout {
    int factor = 1;  ///< tiny pictures are enlarged, a pixel becoming a square of so many
    int width = 0, height = 0;
    Box header;
    std::vector<Panel> sides, differences, slices;  ///< of B, C, D: the differences; empty: not shown
    Panel wipe;
    int slice_frames = 0;  ///< so many frames are seen at once
    int slice_rows = 0;    ///< pixel rows of each
    Panel mean_plot, flicker_plot;
};

/// Throws Error(usage) where the video would be larger than H.264 can be.
Layout plan_layout(int width, int height, std::size_t sequences, std::size_t frames,
                   const CompareParts& parts);

}  // namespace dapple::judge
