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
    /// What a method keeps of frames that are not finished.
    std::string checkpoint_folder() const { return folder_ + "/checkpoint"; }
    std::string checkpoint(std::int64_t frame) const;
    std::string preview() const { return folder_ + "/" + clip_name_ + ".mp4"; }
    std::string manifest() const { return folder_ + "/manifest.json"; }
    std::string stats() const { return folder_ + "/stats.jsonl"; }

    /// Makes the folders of pictures. Throws Error(output_unwritable).
    void make_folders() const;
    void make_checkpoint_folder() const;
    /// Each removes what is there; throws Error(output_unwritable).
    void remove_checkpoint(std::int64_t frame) const;
    void remove_checkpoints() const;
    void remove_checkpoint_folder_if_empty() const noexcept;

private:
    /// NAME.%04d.EXTENSION; larger numbers grow, the sign counts as a digit.
    std::string file_name(std::int64_t frame, const char* extension = ".exr") const;

    std::string folder_;
    std::string clip_name_;
};

}  // namespace dapple::run
