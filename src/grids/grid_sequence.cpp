#include "grids/grid_sequence.h"

#include <algorithm>
#include <filesystem>

#include "base/error.h"

namespace dapple::grids {
namespace {

/// How far back `hold` looks for a file.
constexpr std::int64_t kLongestHold = 10000;

bool exists(const std::string& path) {
    std::error_code ignored;  // a folder that cannot be read shows when the file is
    return std::filesystem::exists(path, ignored);
}

}  // namespace

std::optional<std::string> shown_file(const scene::Medium& medium, std::int64_t frames) {
    const std::int64_t number = scene::file_number(medium, frames);
    std::string wanted = scene::file_path(medium, number);
    if (medium.missing == scene::MissingGrid::error || exists(wanted)) return wanted;
    if (medium.missing == scene::MissingGrid::empty) return std::nullopt;
    const std::int64_t last_tried = std::max(medium.first_file, number - kLongestHold);
    for (std::int64_t earlier = number - 1; earlier >= last_tried; --earlier) {
        std::string path = scene::file_path(medium, earlier);
        if (exists(path)) return path;
    }
    throw Error(ExitCode::input_unreadable, clipped(wanted) + ": no such file, and none before it to hold");
}

}  // namespace dapple::grids
