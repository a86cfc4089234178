#include "run/preview.h"

#include <cassert>
#include <optional>
#include <utility>

#include "base/error.h"
#include "image/code_values.h"
#include "image/exr.h"
#include "video/video_writer.h"

namespace dapple::run {
namespace {

PreviewResult failed(std::string reason) {
    return {PreviewResult::State::failed, {}, std::move(reason)};
}

/// make_preview(), but throwing what fails.
PreviewResult encode(const PreviewRequest& request, const std::function<bool()>& stop) {
    std::optional<video::VideoWriter> writer;
    video::VideoFormat format;
    for (const std::string& path : request.pictures) {
        if (stop()) return {PreviewResult::State::stopped, {}, ""};
        const image::Image picture = image::read_exr(path);
        if (!picture.find("R") || !picture.find("G") || !picture.find("B")) {
            throw Error(ExitCode::input_unreadable, path + ": has no channels R, G and B");
        }
        if (!writer) {
            format = {picture.width, picture.height, request.fps.numerator, request.fps.denominator};
            writer.emplace(request.path, format, request.encoder);
        }
        if (picture.width != format.width || picture.height != format.height) {
            throw Error(ExitCode::input_unreadable, path + ": has another size than the first picture");
        }
        if (!writer->add(image::to_rgb8(picture))) break;  // finish() says why it left
    }
    return {PreviewResult::State::made, writer->finish(), ""};
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
