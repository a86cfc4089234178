#pragma once
#include <cstdint>
#include <string>

namespace dapple::run {

/// Names of the files of a job (CONVENTIONS.md, "Files").
class OutputPaths {
public:
    OutputPaths(std::string folder, std::string clip_name);

    const std::string& folder() const { return folder_; }
    std::string linear_folder() const { return folder_ + "/linear"; }
    std::string graded_folder() const { return folder_ + "/graded"; }
    std::string linear(std::int64_t frame) const { return linear_folder() + "/" + file_name(frame); }
    std::string graded(std::int64_t frame) const { return graded_folder() + "/" + file_name(frame); }
    std::string preview() const { return folder_ + "/" + clip_name_ + ".mp4"; }
    std::string manifest() const { return folder_ + "/manifest.json"; }
    std::string stats() const { return folder_ + "/stats.jsonl"; }

    /// Makes the folders. Throws Error(output_unwritable).
    void make_folders() const;

private:
    /// NAME.%04d.exr; larger numbers grow, the sign counts as a digit.
    std::string file_name(std::int64_t frame) const;

    std::string folder_;
    std::string clip_name_;
};

}  // namespace dapple::run
