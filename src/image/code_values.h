#pragma once
#include <cstdint>
#include <vector>

#include "image/image.h"

/// A graded picture as integers, for PNG files and for video encoders.
namespace dapple::image {

/// Channels R, G and B as interleaved rows from the top left: round(v * (2^bits - 1)) with v held to [0, 1],
/// NaN is 0. 16-bit values are in the machine's byte order (ffmpeg's rgb48le on x86-64). The image must have
/// the three channels.
std::vector<std::uint8_t> to_rgb8(const Image& graded);
std::vector<std::uint16_t> to_rgb16(const Image& graded);

}  // namespace dapple::image
