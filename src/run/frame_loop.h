#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "base/error.h"
#include "base/frame_set.h"
#include "image/exr.h"
#include "run/frame_source.h"
#include "run/interruption.h"
#include "run/job.h"
#include "run/reporter.h"

namespace dapple::run {

/// What is done with frames that are there already.
enum class Existing {
    verify,     ///< kept where manifest, size and content agree, else rendered again
    skip,       ///< the same without looking at the content
    overwrite,  ///< rendered again; frames of another job in the folder are given up
    error,      ///< nothing is rendered: Error(usage)
};

struct LoopOptions {
    std::string folder;
    FrameSet frames;
    Existing existing = Existing::verify;
    bool strict = false;                    ///< exit 6 where values were not finite or a pass was done partly
    std::optional<double> max_flicker;      ///< exit 6 where a frame's is higher (metrics/flicker.h)
    std::uint64_t max_memory = UINT64_MAX;  ///< bytes
    std::string encoder = "ffmpeg";         ///< of the preview, looked for in $PATH
    image::ExrOptions linear_exr;
    image::ExrOptions graded_exr;
};

/// Throws Error(out_of_memory_budget) where a frame of the set needs more than `max_memory`. Of a large set,
/// a thousand frames spread over it are asked. Loads nothing.
void check_memory(const FrameSource& source, const FrameSet& frames, std::uint64_t max_memory);

/// Bytes on disk of one frame, if it could not be compressed at all.
double largest_frame_bytes(const scene::Clip& clip);

/// Renders the frames of the set into the folder, each written atomically and then entered in the manifest;
/// measures how they flicker, and makes the preview if the whole clip is there. May be ended at any moment,
/// also by SIGKILL: the same call goes on where it stopped, and all files get the bytes that they would have
/// had. Only one process at a time renders into a folder.
///
/// Returns done, interrupted, or check_failed (strict, max_flicker). Throws Error(usage) for a folder of
/// another job or another process, Error(out_of_memory_budget), Error(output_unwritable), and what the source
/// throws; finished frames are in the manifest then.
ExitCode render_frames(const Job& job, FrameSource& source, const LoopOptions& options,
                       const Interruption& interruption, Reporter& reporter);

}  // namespace dapple::run
