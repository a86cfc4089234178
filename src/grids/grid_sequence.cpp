#include "grids/grid_sequence.h"

#include <filesystem>

#include "base/error.h"
#include "base/number_pattern.h"

namespace dapple::grids {
namespace {

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
    const auto name = [&](std::int64_t n) { return scene::file_path(medium, n); };
    if (auto held = held_file(number - 1, medium.first_file, name)) return held;
    throw Error(ExitCode::input_unreadable, clipped(wanted) + ": no such file, and none before it to hold");
}

}  // namespace dapple::grids
