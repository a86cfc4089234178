#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

/// The built-in font, DejaVu Sans, as coverage of pixels.
namespace dapple::report {

/// The bytes of the font's file.
std::span<const unsigned char> font_data();

/// What is told of a pixel that a glyph touches: its place from the text's top left, and its coverage.
using Ink = std::function<void(int x, int y, std::uint8_t coverage)>;

/// Walks over UTF-8 text on one line of `size` pixels, from the highest ascender to the lowest descender, and
/// tells of its ink, where `ink` is given. Outlines are not hinted, so that glyphs stand at fractions of
/// pixels and text grows evenly with its size. Returns the width in pixels, rounded up. Bytes that are no
/// UTF-8 count as a character each that the font lacks. Thread-safe.
int set_text(int size, std::string_view text, const Ink& ink = {});

}  // namespace dapple::report
