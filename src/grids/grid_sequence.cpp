#include "grids/grid_sequence.h"

#include <filesystem>

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
    const auto name = [&](std::int64_t n) { return scene::file_path(medium, n); };
    if (medium.missing == scene::MissingGrid::hold) return held_file(number, medium.first_file, name);
    if (medium.missing == scene::MissingGrid::error || exists(name(number))) return name(number);
    return std::nullopt;
}

}  // namespace dapple::grids
