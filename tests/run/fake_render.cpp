// fake_render FOLDER FRAMES [delay=MS] [threads=N] [encoder=PROGRAM] [large=FRAME] [fsize=BYTES] [slow=FRAME]
// [step=MS] Renders made-up frames through the frame loop; exits like dapple.
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "run/fake_source.h"
#include "run/frame_loop.h"

int main(int argc, char** argv) {
    using namespace dapple;
    try {
        const run::Interruption interruption;
        run::FakeSource source;
        run::LoopOptions options;
        options.folder = argv[1];
        options.frames = FrameSet::parse(argv[2]);
        options.encoder = "";
        for (int i = 3; i < argc; ++i) {
            const std::string argument = argv[i];
            const std::string value = argument.substr(argument.find('=') + 1);
            if (argument.starts_with("delay=")) source.delay = std::chrono::milliseconds(std::stoi(value));
            if (argument.starts_with("threads=")) set_thread_count(std::stoi(value));
            if (argument.starts_with("encoder=")) options.encoder = value;
            if (argument.starts_with("large=")) source.large.insert(std::stoi(value));
            if (argument.starts_with("slow=")) source.slow.insert(std::stoi(value));
            if (argument.starts_with("step=")) source.step = std::chrono::milliseconds(std::stoi(value));
            if (argument.starts_with("fsize=")) {
                const rlimit limit{std::stoul(value), std::stoul(value)};
                setrlimit(RLIMIT_FSIZE, &limit);
            }
        }
        run::Reporter reporter;
        return static_cast<int>(render_frames(run::fake_job(), source, options, interruption, reporter));
    } catch (const Error& error) {
        std::fprintf(stderr, "ERROR [%d] %s\n", static_cast<int>(error.code()), error.what());
        return static_cast<int>(error.code());
    }
}
