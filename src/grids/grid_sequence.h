#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "scene/medium.h"

namespace dapple::grids {

/// The file that a grid medium shows `frames` frames after the clip's first one: scene::file_number's, or
/// where it is not there what `missing` asks for: itself (error; reading it fails), the last one before it
/// that is there (hold), or none (empty). Throws Error(input_unreadable) where there is none to hold.
std::optional<std::string> shown_file(const scene::Medium& medium, std::int64_t frames);

}  // namespace dapple::grids
