#include "run/preview.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "image/exr.h"
#include "run/encoder_process.h"

namespace dapple::run {
namespace {

/// 4:2:0 has one colour sample for two pixels each way.
int even(int size) {
    return size + size % 2;
}

/// Pictures as 8-bit R, G, B rows of even size.
std::vector<unsigned char> rgb24(const image::Image& picture, const std::string& path) {
    const image::Channel* channels[] = {picture.find("R"), picture.find("G"), picture.find("B")};
    if (std::find(std::begin(channels), std::end(channels), nullptr) != std::end(channels)) {
        throw Error(ExitCode::input_unreadable, path + ": has no channels R, G and B");
    }
    const int width = even(picture.width);
    const int height = even(picture.height);
    std::vector<unsigned char> bytes;
    bytes.reserve(std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto row = static_cast<std::size_t>(std::min(y, picture.height - 1));
            const auto column = static_cast<std::size_t>(std::min(x, picture.width - 1));
            const std::size_t pixel = row * static_cast<std::size_t>(picture.width) + column;
            for (const image::Channel* channel : channels) {
                const float value = std::clamp(channel->values[pixel], 0.0F, 1.0F);
                bytes.push_back(static_cast<unsigned char>(std::lround(value * 255.0F)));
            }
        }
    }
    return bytes;
}

/// BT.709 in limited range, and tagged so.
constexpr const char* kFilters =
    "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,"
    "setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709:range=tv";

std::vector<std::string> encoder_arguments(const PreviewRequest& request, int width, int height,
                                           const std::string& output) {
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    const std::string rate =
        std::to_string(request.fps.numerator) + "/" + std::to_string(request.fps.denominator);
    return {request.encoder, "-hide_banner", "-nostdin", "-loglevel", "error", "-y",
            // What comes in: full-range R'G'B'.
            "-f", "rawvideo", "-pix_fmt", "rgb24", "-video_size", size, "-framerate", rate, "-i", "pipe:0",
            // What goes out, converted and tagged alike.
            "-vf", kFilters, "-c:v", "libx264", "-crf", "16", "-threads", "2", "-color_primaries", "bt709",
            "-color_trc", "bt709", "-colorspace", "bt709", "-color_range", "tv", "-movflags", "+faststart",
            "-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", "mp4", "file:" + output};
}

/// A name that remove_stale_temporaries() knows.
std::string temporary_name(const std::string& path) {
    char host[256] = {};
    if (::gethostname(host, sizeof host - 1) != 0) std::strcpy(host, "localhost");
    const std::filesystem::path target(path);
    const std::string name =
        "." + target.filename().string() + "." + host + "." + std::to_string(::getpid()) + ".tmp";
    return (target.parent_path() / name).string();
}

/// Removes the file at the end of its scope; after a rename there is none.
struct RemovedAtExit {
    std::string path;
    ~RemovedAtExit() { ::unlink(path.c_str()); }
};

PreviewResult failed(std::string reason) {
    return {PreviewResult::State::failed, {}, std::move(reason)};
}

/// make_preview(), but throwing what fails.
PreviewResult encode(const PreviewRequest& request, const std::function<bool()>& stop) {
    const RemovedAtExit temporary{temporary_name(request.path)};
    std::optional<EncoderProcess> encoder;
    for (const std::string& path : request.pictures) {
        if (stop()) return {PreviewResult::State::stopped, {}, ""};
        const image::Image picture = image::read_exr(path);
        if (!encoder) {
            encoder.emplace(
                encoder_arguments(request, even(picture.width), even(picture.height), temporary.path));
        }
        if (!encoder->feed(rgb24(picture, path))) break;  // finish() says why it left
    }
    if (!encoder->finish()) return failed(request.encoder + " failed: " + encoder->complaint());

    const std::vector<std::byte> bytes = read_whole_file(temporary.path);
    const int file = ::open(temporary.path.c_str(), O_RDONLY | O_CLOEXEC);
    const bool synced = file >= 0 && ::fsync(file) == 0;
    if (file >= 0) ::close(file);
    if (!synced || ::rename(temporary.path.c_str(), request.path.c_str()) != 0) {
        return failed(request.path + ": " + std::strerror(errno));
    }
    return {PreviewResult::State::made, {bytes.size(), content_hash(bytes.data(), bytes.size())}, ""};
}

}  // namespace

PreviewResult make_preview(const PreviewRequest& request, const std::function<bool()>& stop) {
    assert(!request.pictures.empty());
    try {
        return encode(request, stop);
    } catch (const Error& error) {
        return failed(error.what());
    }
}

}  // namespace dapple::run
