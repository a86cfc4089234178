#pragma once
#include "denoise/upsample.h"
#include "scene/frame_scene.h"

namespace dapple::render {

/// Pixels a side of a buffer's pixel: 1, 2, 4.
int pixels_a_side(scene::BufferScale scale);

/// The same frame for a picture whose pixels are `scale` times as large: it covers the given one, and
/// reaches as far beyond it on opposite sides. Geometry is shared.
scene::FrameState at_scale(const scene::FrameState& state, int scale);
scene::FrameScene at_scale(const scene::FrameScene& scene, int scale);

/// How the pixels of at_scale() lie over the scene's own, and what E of a sample stands for in them.
denoise::CoarseGrid coarse_grid(const scene::FrameScene& scene, int scale, int sample);

}  // namespace dapple::render
