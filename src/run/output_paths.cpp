#include "run/output_paths.h"

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace dapple::run {

OutputPaths::OutputPaths(std::string folder, std::string clip_name)
    : folder_(std::move(folder)), clip_name_(std::move(clip_name)) {
    // A name from a file must not lead out of the folder, nor hide what it names.
    if (clip_name_.empty() || clip_name_.front() == '.' || clip_name_.find('/') != std::string::npos ||
        clip_name_.find('\0') != std::string::npos) {
        throw Error(ExitCode::timeline_invalid, "clip.name '" + clipped(clip_name_) +
                                                    "' cannot name files: leave out '/' and a leading '.'");
    }
}

std::string OutputPaths::file_name(std::int64_t frame) const {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%04lld", static_cast<long long>(frame));
    return clip_name_ + "." + digits + ".exr";
}

void OutputPaths::make_folders() const {
    for (const std::string& path : {linear_folder(), graded_folder()}) {
        std::error_code reason;
        std::filesystem::create_directories(path, reason);
        if (reason) {
            throw Error(ExitCode::output_unwritable,
                        "cannot make the folder " + path + ": " + reason.message());
        }
    }
}

}  // namespace dapple::run
