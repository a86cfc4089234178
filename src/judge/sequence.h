#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/checked_file.h"

/// What the verbs check, compare and bench do: they judge sequences of pictures, of dapple or of any other
/// renderer.
namespace dapple::judge {

/// The numbered pictures (EXR or PNG) of one clip.
struct Sequence {
    std::string name;                           ///< how the user called it
    std::map<std::int64_t, std::string> files;  ///< paths of those that are there, by frame number
    std::int64_t first = 0, last = 0;           ///< of the clip: from the manifest, else of the files
    std::optional<double> fps;                  ///< from the manifest
    /// Finished frames of the manifest, to be checked against the files; empty without one.
    std::map<std::int64_t, WrittenFile> expected;
};

/// Frames that are judged at most, from the first to the last.
inline constexpr std::int64_t kMostFrames = 1 << 20;

enum class Pictures { linear, graded };

/// Finds a sequence by a pattern ("clip.%04d.exr", "clip.####.exr"), a folder that holds one numbered
/// sequence, a folder that dapple rendered (its manifest, linear or graded pictures), its manifest.json, or a
/// single picture, whose number stands in its name, or is 0. The last digits before the extension are the
/// number, with the sign as dapple writes it ("clip.-001.exr"). Hidden files are passed over: temporaries are
/// hidden. Throws Error(input_unreadable) where there is none or more than one, naming those there
/// are.
Sequence find_sequence(const std::string& specification, Pictures pictures = Pictures::linear);

/// Two single pictures are compared whatever numbers stand in their names: the reference takes that of the
/// sequence.
void pair_singles(const Sequence& sequence, Sequence& reference);

/// From the smallest first to the largest last of the sequences. Throws Error(input_unreadable) where these
/// are more than kMostFrames.
std::vector<std::int64_t> all_frames(const std::vector<Sequence>& sequences);

}  // namespace dapple::judge
