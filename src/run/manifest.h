#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/checked_file.h"
#include "run/job.h"

namespace dapple::run {

/// A finished frame.
struct FrameEntry {
    WrittenFile linear;
    WrittenFile graded;
    std::size_t non_finite = 0;
    std::vector<std::string> partly;  ///< passes that the plan did "partly", with the reason
};

/// The preview, and the graded frames that it was made from.
struct PreviewEntry {
    WrittenFile file;
    std::string source_hash;
};

/// OUT/manifest.json: the job and its finished frames. A frame that is not entered here does not exist.
struct Manifest {
    std::string job_hash;
    scene::Clip clip;
    NamedTexts parts;
    NamedTexts provenance;
    std::optional<render::SettledCaustics> settled;  ///< so that a resumed run need not choose again
    std::map<std::int64_t, FrameEntry> frames;
    std::optional<PreviewEntry> preview;
};

/// Nothing where there is no file. Throws Error(usage) for a file that is no manifest: whose frames these are
/// cannot be said then.
std::optional<Manifest> read_manifest(const std::string& path);

/// The settings in the manifest, where it is of this job: they follow from it. Nothing where it is not, or
/// cannot be read.
std::optional<render::SettledCaustics> known_settings(const std::string& path, const Job& job);

/// Replaces the file atomically. Throws Error(output_unwritable).
void write_manifest(const std::string& path, const Manifest& manifest);

/// Whether the file has the size of its entry, and where `content` is set its hash too.
bool matches(const std::string& path, const WrittenFile& entry, bool content);

}  // namespace dapple::run
