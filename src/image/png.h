#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/checked_file.h"

namespace dapple::image {

/// Code values of a PNG: 3 floats a pixel in [0, 1], row-major from the top left, as they stand in the file
/// (neither linearised nor corrected for a gAMA chunk). Grey and palettes are widened to RGB; alpha is
/// dropped, colour is not multiplied by it.
struct CodeValues {
    int width = 0;
    int height = 0;
    std::vector<float> rgb;
};

/// Reads 1 to 16 bits a channel, at most 16384 x 16384. Throws Error(input_unreadable) that begins with
/// `name`.
CodeValues decode_png(std::span<const std::byte> bytes, const std::string& name);

/// 8-bit sRGB PNG of interleaved rows (`rgb.size() == 3 * width * height`). The same picture gives the same
/// bytes. Throws Error(failure) where libpng refuses.
std::vector<std::byte> encode_png(int width, int height, std::span<const std::uint8_t> rgb);

/// The same, written atomically. Throws Error(output_unwritable).
WrittenFile write_png(const std::string& path, int width, int height, std::span<const std::uint8_t> rgb);

}  // namespace dapple::image
