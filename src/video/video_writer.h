#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "base/checked_file.h"
#include "video/encoder_process.h"

/// Videos, encoded by ffmpeg as a program of its own.
namespace dapple::video {

struct VideoFormat {
    int width = 0;
    int height = 0;
    std::int64_t fps_numerator = 24;
    std::int64_t fps_denominator = 1;
};

/// Writes H.264 in MP4: 8 bits, 4:2:0, BT.709 matrix, primaries and transfer, limited range, exact frame
/// rate, playable while it loads. Odd sizes grow by one pixel, a copy of the last. The encoder is fed by a
/// pipe, without a shell, writes a temporary that is renamed when it is whole, and uses a fixed number of
/// threads, so that equal pictures make equal bytes. Without finish() nothing
/// is left. SIGPIPE must be ignored (run/interruption.h).
class VideoWriter {
public:
    /// `encoder`: program, looked for in $PATH. Throws Error(failure) where it cannot be started,
    /// Error(output_unwritable) where no file can be made beside `path`.
    VideoWriter(std::string path, const VideoFormat& format, const std::string& encoder = "ffmpeg");
    VideoWriter(const VideoWriter&) = delete;
    VideoWriter& operator=(const VideoWriter&) = delete;

    /// Interleaved 8-bit R'G'B' rows of the format's size. False where the encoder does not read any more:
    /// finish() says why.
    bool add(std::span<const std::uint8_t> rgb);
    /// Throws Error with what the encoder complained of: output_unwritable where the disk is full or the file
    /// cannot be put in place, else failure.
    WrittenFile finish();

private:
    std::string path_;
    VideoFormat format_;
    std::string encoder_name_;
    /// Removes the file at its end, which comes after the encoder's; after finish() there is none.
    struct Temporary {
        std::string path;
        ~Temporary();
    };
    Temporary temporary_;
    EncoderProcess encoder_;
};

}  // namespace dapple::video
