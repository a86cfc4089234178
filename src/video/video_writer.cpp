#include "video/video_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/hash.h"

namespace dapple::video {
namespace {

/// 4:2:0 has one colour sample for two pixels each way.
int even(int size) {
    return size + size % 2;
}

/// BT.709 in limited range, and tagged so.
constexpr const char* kFilters =
    "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,"
    "setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709:range=tv";

std::vector<std::string> encoder_arguments(const VideoFormat& format, const std::string& encoder,
                                           const std::string& output) {
    const std::string size = std::to_string(even(format.width)) + "x" + std::to_string(even(format.height));
    const std::string rate =
        std::to_string(format.fps_numerator) + "/" + std::to_string(format.fps_denominator);
    return {encoder, "-hide_banner", "-nostdin", "-loglevel", "error", "-y",
            // What comes in: full-range R'G'B'.
            "-f", "rawvideo", "-pix_fmt", "rgb24", "-video_size", size, "-framerate", rate, "-i", "pipe:0",
            // What goes out, converted and tagged alike.
            "-vf", kFilters, "-c:v", "libx264", "-crf", "16", "-threads", "2", "-color_primaries", "bt709",
            "-color_trc", "bt709", "-colorspace", "bt709", "-color_range", "tv", "-movflags", "+faststart",
            "-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", "mp4", "file:" + output};
}

/// A new, empty file with a name that remove_stale_temporaries() knows. The encoder would say less clearly
/// why it cannot be.
std::string make_temporary(const std::string& path) {
    char host[256] = {};
    if (::gethostname(host, sizeof host - 1) != 0) std::strcpy(host, "localhost");
    const std::filesystem::path target(path);
    const std::string name =
        "." + target.filename().string() + "." + host + "." + std::to_string(::getpid()) + ".tmp";
    const std::string temporary = (target.parent_path() / name).string();
    const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0) throw Error(ExitCode::output_unwritable, path + ": " + std::strerror(errno));
    ::close(file);
    return temporary;
}

}  // namespace

VideoWriter::VideoWriter(std::string path, const VideoFormat& format, const std::string& encoder)
    : path_(std::move(path)),
      format_(format),
      encoder_name_(encoder),
      temporary_{make_temporary(path_)},
      encoder_(encoder_arguments(format, encoder, temporary_.path)) {
    assert(format.width > 0 && format.height > 0);
}

VideoWriter::Temporary::~Temporary() {
    ::unlink(path.c_str());
}

bool VideoWriter::add(std::span<const std::uint8_t> rgb) {
    const auto width = static_cast<std::size_t>(format_.width);
    const auto height = static_cast<std::size_t>(format_.height);
    assert(rgb.size() == 3 * width * height);
    if (even(format_.width) == format_.width && even(format_.height) == format_.height) {
        return encoder_.feed(rgb);
    }
    std::vector<std::uint8_t> grown;
    grown.reserve(3 * (width + 1) * (height + 1));
    for (int y = 0; y < even(format_.height); ++y) {
        const auto row =
            rgb.subspan(3 * width * std::min(static_cast<std::size_t>(y), height - 1), 3 * width);
        grown.insert(grown.end(), row.begin(), row.end());
        if (format_.width % 2 != 0) grown.insert(grown.end(), row.end() - 3, row.end());
    }
    return encoder_.feed(grown);
}

WrittenFile VideoWriter::finish() {
    if (!encoder_.finish()) {
        const std::string complaint = encoder_.complaint();
        const bool full = complaint.find(std::strerror(ENOSPC)) != std::string::npos;
        throw Error(full ? ExitCode::output_unwritable : ExitCode::failure,
                    encoder_name_ + " failed: " + complaint);
    }
    const std::vector<std::byte> bytes = read_whole_file(temporary_.path);
    const int file = ::open(temporary_.path.c_str(), O_RDONLY | O_CLOEXEC);
    const bool synced = file >= 0 && ::fsync(file) == 0;
    if (file >= 0) ::close(file);
    if (!synced || ::rename(temporary_.path.c_str(), path_.c_str()) != 0) {
        throw Error(ExitCode::output_unwritable, path_ + ": " + std::strerror(errno));
    }
    return {bytes.size(), content_hash(bytes.data(), bytes.size())};
}

}  // namespace dapple::video
