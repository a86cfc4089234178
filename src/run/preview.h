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

/// Encodes the pictures as H.264 in MP4: 8 bits, 4:2:0, BT.709 matrix, primaries and transfer, limited range,
/// exact frame rate, playable while it loads. Odd sizes grow by one pixel, a copy of the last. The encoder is
/// fed by a pipe, without a shell, writes a temporary that is renamed when it is whole, and uses a fixed
/// number of threads, so that equal pictures make equal bytes. What fails (no encoder, a picture that cannot
/// be read) is no error of the job: State::failed and a reason. `stop` is asked between pictures. SIGPIPE
/// must be ignored.
PreviewResult make_preview(const PreviewRequest& request, const std::function<bool()>& stop);

}  // namespace dapple::run
