#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/checked_file.h"
#include "image/image.h"

/// OpenEXR files of one part: scanlines, lossless ZIP in blocks of 16 lines, whose zlib checksum finds
/// damage. The bytes are a pure function of image and options (no dates, any number of threads).
namespace dapple::image {

/// Of the library: "3.1.5".
std::string openexr_version();

struct ExrOptions {
    /// Of the working space, for scene-linear files; none for display-referred ones.
    std::optional<Chromaticities> chromaticities;
    std::int64_t fps_numerator = 0;  ///< 0: no `framesPerSecond`; both must fit 32 bits
    std::int64_t fps_denominator = 1;
    /// zlib's effort, 1 (fast) to 9. Changes the bytes of the file, never the pixels.
    int zip_level = 1;
};

/// What had to be changed to store an image. Both are 0 for the frames of a healthy job.
struct StoredCounts {
    std::size_t clamped = 0;  ///< values beyond +-65504, the largest half, in half channels: held there
    std::size_t non_finite =
        0;  ///< NaN and infinity: replaced by 0 (renderers replace and locate them earlier)
};

struct EncodedExr {
    std::vector<std::byte> bytes;
    StoredCounts counts;
};

/// Threads that OpenEXR compresses and decompresses with, for the whole process; 1 works in the calling
/// thread.
void set_exr_threads(int threads);

/// The file in memory. Channels need not be sorted; half ones are rounded to nearest, ties to even. Data and
/// display window are the image. Metadata becomes string attributes; a name that OpenEXR itself uses with
/// another type
/// ("channels") is an Error(failure). Throws Error(failure) where OpenEXR refuses.
EncodedExr encode_exr(const Image& image, const ExrOptions& options = {});

/// Pixels of the data window. Half and unsigned channels become float; string attributes become metadata
/// (sorted by name, as OpenEXR holds them). Reads one part of scanlines or tiles, at most 16384 x 16384 and 8
/// GiB as floats, that is not compressed or compressed by RLE, ZIPS or ZIP: the other decoders either lose
/// data, pass damage on silently (PIZ) or have open security holes in the library's 3.1 line. Anything else,
/// and damage, throws Error(input_unreadable) that begins with `name`. Sizes are checked before memory is
/// taken.
///
/// `wanted` says which channels are decoded into memory (all, where it is empty); of an image without a
/// wanted channel only size and metadata come.
using WantedChannel = std::function<bool(const std::string& channel)>;
Image decode_exr(std::span<const std::byte> bytes, const std::string& name, const WantedChannel& wanted = {});
Image read_exr(const std::string& path, const WantedChannel& wanted = {});

/// Whether a file holds exactly what `encode_exr` stores of `image`: size, channels, types and every bit of
/// the pixels. Throws Error(input_unreadable) like `decode_exr`.
bool exr_holds(std::span<const std::byte> bytes, const Image& image, const std::string& name);

struct WrittenExr {
    std::uint64_t bytes = 0;
    std::string content_hash;  ///< of the file
    StoredCounts counts;
};

/// Writes a file that is known to be good: encoded in memory, written under a temporary name, read back from
/// there, decoded in full and compared with the image bit by bit, synced, renamed (base/checked_file.h).
/// Throws Error(output_unwritable); then nothing new stands at `path`.
WrittenExr write_exr_verified(const std::string& path, const Image& image, const ExrOptions& options = {});

}  // namespace dapple::image
