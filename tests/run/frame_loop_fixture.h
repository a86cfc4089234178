#pragma once
#include <gtest/gtest.h>

#include <string>

#include "run/fake_source.h"
#include "run/frame_loop.h"
#include "run/scratch_folder.h"

namespace dapple::run {

/// Runs the frame loop on made-up frames.
class FrameLoopTest : public testing::Test {
protected:
    ExitCode render(const std::string& folder, const std::string& frames,
                    Existing existing = Existing::verify, const Job& job = fake_job()) {
        source.rendered.clear();
        options.folder = folder;
        options.frames = FrameSet::parse(frames);
        options.existing = existing;
        const Interruption interruption;
        Reporter reporter(event_log);
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        try {
            const ExitCode code = render_frames(job, source, options, interruption, reporter);
            out = testing::internal::GetCapturedStdout();
            warnings = testing::internal::GetCapturedStderr();
            return code;
        } catch (const Error& error) {
            testing::internal::GetCapturedStdout();
            testing::internal::GetCapturedStderr();
            message = error.what();
            return error.code();
        }
    }

    FrameLoopTest() { options.encoder = "no-such-encoder"; }

    testing_tools::ScratchFolder scratch;
    FakeSource source;
    LoopOptions options;
    std::string event_log;
    std::string message;   ///< of the Error that the last render() met
    std::string out;       ///< what it printed
    std::string warnings;  ///< on standard error
};

}  // namespace dapple::run
