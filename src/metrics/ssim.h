#pragma once
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

enum class SsimWindow {
    gaussian,  ///< 11 x 11, sigma 1.5, at all places where it fits (Wang et al. 2004)
    boxes,     ///< 8 x 8 at every fourth pixel, sums of a box unweighted: what ffmpeg's ssim filter does
};

struct SsimOptions {
    SsimWindow window = SsimWindow::gaussian;
    double peak = 1;  ///< L of C1 = (0.01 L)^2, C2 = (0.03 L)^2
};

/// Structural similarity (Wang et al. 2004) of luminance (gaussian) or the mean over R, G, B (boxes), in
/// [-1, 1], 1 for equal pictures: the mean over all windows that hold no excluded pixel, 1 where there is
/// none. A picture narrower or lower than the window is judged by windows of its width or height. Both
/// pictures must have one size and exclude the same pixels. `map`, if given, gets a value a pixel: that of
/// the nearest window, excluded pixels counting as equal.
///
/// Boxes follow ffmpeg: variances divide by 63, C1 and C2 are rounded to its integers for 8-bit values, and
/// rows and columns beyond the last whole 4 x 4 block are left out.
double ssim(const Picture& picture, const Picture& reference, const SsimOptions& options,
            std::vector<float>* map = nullptr);

}  // namespace dapple::metrics
