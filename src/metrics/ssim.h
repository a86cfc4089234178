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

/// Structural similarity of luminance (gaussian) or the mean over R, G, B (boxes), in [-1, 1], 1 for equal
/// pictures. A picture smaller than the window is judged by one window of its size. `map`, if given, gets a
/// value a pixel (that of the nearest window).
double ssim(const Picture& picture, const Picture& reference, const SsimOptions& options,
            std::vector<float>* map = nullptr);

}  // namespace dapple::metrics
