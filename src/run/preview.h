#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/checked_file.h"
#include "scene/frame_state.h"

namespace dapple::run {

struct PreviewRequest {
    std::string path;                   ///< of the video
    std::vector<std::string> pictures;  ///< graded EXR files, in the order of frames
    scene::Rational fps;
    std::string encoder = "ffmpeg";  ///< program, looked for in $PATH
};

struct PreviewResult {
    enum class State { made, stopped, failed } state = State::failed;
    WrittenFile file;
    std::string reason;  ///< why it failed
};

/// Encodes the pictures (video/video_writer.h). What fails (no encoder, a picture that cannot be read or has
/// another size than the first) is no error of the job: State::failed and a reason. `stop` is asked between
/// pictures.
PreviewResult make_preview(const PreviewRequest& request, const std::function<bool()>& stop);

}  // namespace dapple::run
