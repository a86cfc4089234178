#include "image/png.h"

#include <png.h>

#include <cassert>
#include <csetjmp>
#include <cstring>

#include "base/error.h"

namespace dapple::image {
namespace {

constexpr png_uint_32 kMostPixelsASide = 16384;

/// What libpng's callbacks reach: the bytes still to be read, and its last word when it gives up.
struct Session {
    std::span<const std::byte> left;
    char reason[256] = {};
    std::jmp_buf give_up;
};

[[noreturn]] void on_error(png_structp png, png_const_charp reason) {
    auto* session = static_cast<Session*>(png_get_error_ptr(png));
    std::strncpy(session->reason, reason, sizeof session->reason - 1);
    std::longjmp(session->give_up, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep target, std::size_t count) {
    auto* session = static_cast<Session*>(png_get_io_ptr(png));
    if (count > session->left.size()) png_error(png, "the file ends too early");
    std::memcpy(target, session->left.data(), count);
    session->left = session->left.subspan(count);
}

/// libpng's objects, released at the end of their scope.
class Reader {
public:
    explicit Reader(Session& session)
        : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &session, on_error, on_warning)),
          info(png != nullptr ? png_create_info_struct(png) : nullptr) {
        if (png != nullptr) png_set_read_fn(png, &session, on_read);
    }
    ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    png_structp png;
    png_infop info;
};

// libpng leaves a function by longjmp, which runs no destructors: the two functions that call it own nothing.

/// Reads the header and asks for 8 or 16 bits of RGB; false where libpng gave up.
bool read_header(Reader& reader, Session& session) {
    if (setjmp(session.give_up) != 0) return false;
    png_set_user_limits(reader.png, kMostPixelsASide, kMostPixelsASide);
    png_read_info(reader.png, reader.info);
    png_set_expand(reader.png);
    png_set_gray_to_rgb(reader.png);
    png_set_strip_alpha(reader.png);
    png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
    return true;
}

bool read_rows(Reader& reader, Session& session, png_bytepp rows) {
    if (setjmp(session.give_up) != 0) return false;
    png_read_image(reader.png, rows);
    png_read_end(reader.png, nullptr);  // checks the sums of what is left
    return true;
}

[[noreturn]] void refuse(const std::string& name, const Session& session) {
    throw Error(ExitCode::input_unreadable, name + ": is no readable PNG: " + clipped(session.reason));
}

}  // namespace

CodeValues decode_png(std::span<const std::byte> bytes, const std::string& name) {
    Session session;
    session.left = bytes;
    Reader reader(session);
    if (reader.info == nullptr) throw Error(ExitCode::failure, "libpng cannot start");
    if (!read_header(reader, session)) refuse(name, session);

    CodeValues picture;
    picture.width = static_cast<int>(png_get_image_width(reader.png, reader.info));
    picture.height = static_cast<int>(png_get_image_height(reader.png, reader.info));
    const bool wide = png_get_bit_depth(reader.png, reader.info) == 16;
    const std::size_t row_bytes = png_get_rowbytes(reader.png, reader.info);
    const auto height = static_cast<std::size_t>(picture.height);
    const std::size_t values = static_cast<std::size_t>(picture.width) * height * 3;
    assert(row_bytes * height == values * (wide ? 2 : 1));

    std::vector<png_byte> codes(row_bytes * height);
    std::vector<png_bytep> rows(height);
    for (std::size_t y = 0; y < height; ++y) rows[y] = codes.data() + y * row_bytes;
    if (!read_rows(reader, session, rows.data())) refuse(name, session);

    picture.rgb.resize(values);
    for (std::size_t i = 0; i < values; ++i) {
        // A division, so that the largest code is exactly 1 and the others are rounded once.
        picture.rgb[i] = wide ? static_cast<float>(codes[2 * i] * 256 + codes[2 * i + 1]) / 65535.0f
                              : static_cast<float>(codes[i]) / 255.0f;
    }
    return picture;
}

std::vector<std::byte> encode_png(int width, int height, std::span<const std::uint8_t> rgb) {
    assert(width > 0 && height > 0);
    assert(rgb.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    png_image picture{};
    picture.version = PNG_IMAGE_VERSION;
    picture.width = static_cast<png_uint_32>(width);
    picture.height = static_cast<png_uint_32>(height);
    picture.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(picture);
    std::vector<std::byte> bytes(size);
    if (png_image_write_to_memory(&picture, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0) {
        throw Error(ExitCode::failure, "a PNG cannot be encoded: " + clipped(picture.message));
    }
    bytes.resize(size);
    return bytes;
}

WrittenFile write_png(const std::string& path, int width, int height, std::span<const std::uint8_t> rgb) {
    return write_file_atomically(path, encode_png(width, height, rgb));
}

}  // namespace dapple::image
