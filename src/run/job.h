#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/settled_caustics.h"
#include "scene/frame_state.h"

namespace dapple::run {

using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// What a clip is made from. Frames of one job may be rendered by any number of runs, on any machine with the
/// same type of device, and fit together.
struct Job {
    scene::Clip clip;
    /// All that decides the pictures, but for the frame range and the machine: name and short text (a hash).
    NamedTexts parts;
    /// How it was made (versions, device, colour): for the reader of the manifest, not compared.
    NamedTexts provenance;
    /// Chosen for caustics.target_error, which follows from the parts.
    std::optional<render::SettledCaustics> settled;

    std::string hash() const;
};

/// Throws Error(input_unreadable) that names a file that cannot be opened, and how many others cannot.
void check_readable(const std::vector<std::string>& paths);

/// One hash of the contents of files, in their order; their paths do not count. Throws
/// Error(input_unreadable).
std::string hash_files(const std::vector<std::string>& paths);

/// Version and content hash of the running program and of the one that reads grids for it.
std::string program_identity();

/// Names of the parts in which two jobs differ: "the timeline, the program".
std::string differences(const NamedTexts& a, const NamedTexts& b);

}  // namespace dapple::run
