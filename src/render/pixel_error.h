#pragma once
#include <functional>
#include <vector>

#include "render/pilot_frame.h"
#include "scene/frame_state.h"

namespace dapple::render {

/// E of a picture by one camera path a pixel, and what the pixels show.
struct PixelPicture {
    PixelIrradiance irradiance;
    std::vector<PixelSurface> surfaces;
};

/// Relative L1 that a method makes of the size of what its samples stand for, `samples` a pixel of `state`,
/// whose picture by one sample is `by_one`. Samples of a pixel are the pixels of a finer picture
/// (view::Camera::sample_cell), so that `look` is asked for pictures of one sample only: what one sample
/// blurs is told by quarters of pixels; how much less four do, by pixels twice as wide against means of
/// pixels and of their quarters; and any other number by a power law.
double pixel_error(const scene::FrameState& state, int samples, const PixelPicture& by_one,
                   const std::function<PixelPicture(const scene::FrameState&)>& look);

}  // namespace dapple::render
