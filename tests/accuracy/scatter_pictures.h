#pragma once
#include <string>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "image/image.h"
#include "methods/caustic_method.h"
#include "scene/frame_scene.h"

/// Pictures of the light that media scatter (S), for the programs that hold methods against kept frames of
/// the reference.
namespace dapple::test {

/// What pixels receive along the camera's first branch of light through or off the water, W/m^2/sr: S.R, S.G,
/// S.B, means over the clip's samples; "direct": 1 where none of it came to the camera by way of the water or
/// a mirror; and what the method says of sample 0 ("S.variance.R"). `checkpoint`: a file that the reference
/// goes on from; empty: none.
image::Image scattered(const scene::FrameScene& scene, methods::CausticMethod& method, gpu::Device& device,
                       FrameStats& stats, const std::string& checkpoint = {});

/// The channel's values. Throws Error(input_unreadable) where there is none.
const std::vector<float>& channel(const image::Image& image, const std::string& name);

/// The override of a timeline that makes the reference answer for it, to this standard error of pixels (their
/// root mean square over the mean) or by this many million rays a light.
std::string by_reference(const std::string& standard_error, int most_rays);

/// S of the reference in the scene's frame: FOLDER/reference.FRAME.exr, made where there is none; a run that
/// was ended goes on. Throws Error(input_unreadable) where the file's size is not the clip's.
image::Image kept_reference(const scene::FrameScene& scene, const std::string& folder, gpu::Device& device);

}  // namespace dapple::test
