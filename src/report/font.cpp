#include "report/font.h"

#include <freetype/freetype.h>
#include <freetype/ftoutln.h>

#include <cstddef>
#include <mutex>

#include "base/error.h"

namespace dapple::report {
namespace {

/// FreeType measures in 64ths of a pixel.
constexpr FT_Pos kOne = 64;

/// FreeType's library with the one face. Faces are not thread-safe: hold `mutex` while using one.
struct Font {
    Font() {
        const std::span<const unsigned char> data = font_data();
        if (FT_Init_FreeType(&library) != 0 ||
            FT_New_Memory_Face(library, data.data(), static_cast<FT_Long>(data.size()), 0, &face) != 0) {
            throw Error(ExitCode::failure, "FreeType cannot read the built-in font");
        }
    }
    ~Font() {
        FT_Done_Face(face);
        FT_Done_FreeType(library);
    }
    Font(const Font&) = delete;
    Font& operator=(const Font&) = delete;

    /// The whole line, ascender to descender, becomes `pixels` high.
    void set_size(int pixels) {
        FT_Size_RequestRec request{FT_SIZE_REQUEST_TYPE_REAL_DIM, 0, pixels * kOne, 0, 0};
        if (FT_Request_Size(face, &request) != 0) {
            throw Error(ExitCode::failure, "FreeType cannot scale the built-in font");
        }
    }

    FT_Library library = nullptr;
    FT_Face face = nullptr;
    std::mutex mutex;
};

Font& font() {
    static Font one;
    return one;
}

constexpr char32_t kBroken = 0xFFFFFFFF;  // no character: the font's box for what it lacks

/// Takes the next character off the text. RFC 3629: no overlong forms, no surrogates, up to U+10FFFF.
char32_t next_character(std::string_view& text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char head = byte(0);
    const std::size_t length = head < 0x80   ? 1
                               : head < 0xC2 ? 0
                               : head < 0xE0 ? 2
                               : head < 0xF0 ? 3
                               : head < 0xF5 ? 4
                                             : 0;
    char32_t character = length < 2 ? head : head & (0x7Fu >> length);
    bool whole = length > 0 && length <= text.size();
    for (std::size_t i = 1; whole && i < length; ++i) {
        whole = (byte(i) & 0xC0) == 0x80;
        character = character << 6 | (byte(i) & 0x3Fu);
    }
    if (whole && length == 3) whole = character >= 0x800 && (character < 0xD800 || character > 0xDFFF);
    if (whole && length == 4) whole = character >= 0x10000 && character <= 0x10FFFF;
    text.remove_prefix(whole ? length : 1);
    return whole ? character : kBroken;
}

void tell_ink(const FT_GlyphSlot glyph, int left, int baseline, const Ink& ink) {
    const FT_Bitmap& bitmap = glyph->bitmap;
    for (unsigned row = 0; row < bitmap.rows; ++row) {
        for (unsigned column = 0; column < bitmap.width; ++column) {
            const std::uint8_t coverage = bitmap.buffer[static_cast<std::ptrdiff_t>(row) * bitmap.pitch +
                                                        static_cast<std::ptrdiff_t>(column)];
            if (coverage == 0) continue;
            ink(left + glyph->bitmap_left + static_cast<int>(column),
                baseline - glyph->bitmap_top + static_cast<int>(row), coverage);
        }
    }
}

}  // namespace

int set_text(int size, std::string_view text, const Ink& ink) {
    if (size <= 0) return 0;
    Font& used = font();
    const std::lock_guard lock(used.mutex);
    used.set_size(size);
    const FT_Face face = used.face;
    // Of the unrounded scale: FreeType rounds the size's own ascender up to whole pixels.
    const int baseline =
        static_cast<int>((FT_MulFix(face->ascender, face->size->metrics.y_scale) + kOne / 2) / kOne);
    FT_Pos pen = 0;
    FT_UInt previous = 0;
    while (!text.empty()) {
        const FT_UInt glyph = FT_Get_Char_Index(face, next_character(text));
        FT_Vector kerning{0, 0};
        FT_Get_Kerning(face, previous, glyph, FT_KERNING_UNFITTED, &kerning);
        pen += kerning.x;
        previous = glyph;
        if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) != 0) continue;
        if (ink) {
            FT_Outline_Translate(&face->glyph->outline, pen % kOne, 0);
            if (FT_Render_Glyph(face->glyph, FT_RENDER_MODE_NORMAL) == 0) {
                tell_ink(face->glyph, static_cast<int>(pen / kOne), baseline, ink);
            }
        }
        // In 65536ths, not rounded to pixels as `advance` is.
        pen += (face->glyph->linearHoriAdvance + (1 << 9)) >> 10;
    }
    return static_cast<int>((pen + kOne - 1) / kOne);
}

}  // namespace dapple::report
