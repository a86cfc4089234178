#include "run/output_paths.h"

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace dapple::run {
namespace {

constexpr const char* kCheckpointExtension = ".partial";

void make_folder(const std::string& path) {
    std::error_code reason;
    std::filesystem::create_directories(path, reason);
    if (reason) {
        throw Error(ExitCode::output_unwritable, "cannot make the folder " + path + ": " + reason.message());
    }
}

void remove_file(const std::string& path) {
    std::error_code reason;
    std::filesystem::remove(path, reason);
    if (reason) {
        throw Error(ExitCode::output_unwritable, "cannot remove " + path + ": " + reason.message());
    }
}

}  // namespace

OutputPaths::OutputPaths(std::string folder, std::string clip_name)
    : folder_(std::move(folder)), clip_name_(std::move(clip_name)) {
    // A name from a file must not lead out of the folder, nor hide what it names.
    if (clip_name_.empty() || clip_name_.front() == '.' || clip_name_.find('/') != std::string::npos ||
        clip_name_.find('\0') != std::string::npos) {
        throw Error(ExitCode::timeline_invalid, "clip.name '" + clipped(clip_name_) +
                                                    "' cannot name files: leave out '/' and a leading '.'");
    }
}

std::string OutputPaths::file_name(std::int64_t frame, const char* extension) const {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%04lld", static_cast<long long>(frame));
    return clip_name_ + "." + digits + extension;
}

std::string OutputPaths::checkpoint(std::int64_t frame) const {
    return checkpoint_folder() + "/" + file_name(frame, kCheckpointExtension);
}

void OutputPaths::make_folders() const {
    for (const std::string& path : {linear_folder(), graded_folder()}) make_folder(path);
}

void OutputPaths::make_checkpoint_folder() const {
    make_folder(checkpoint_folder());
}

void OutputPaths::remove_checkpoint(std::int64_t frame) const {
    remove_file(checkpoint(frame));
}

void OutputPaths::remove_checkpoints() const {
    std::error_code missing;
    std::filesystem::directory_iterator files(checkpoint_folder(), missing);
    if (missing) return;
    // Those of other clips too, but nothing that dapple did not write.
    for (const auto& file : files) {
        if (file.path().extension() == kCheckpointExtension) remove_file(file.path().string());
    }
}

void OutputPaths::remove_checkpoint_folder_if_empty() const noexcept {
    std::error_code not_empty;
    std::filesystem::remove(checkpoint_folder(), not_empty);
}

}  // namespace dapple::run
