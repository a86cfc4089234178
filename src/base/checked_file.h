#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Files that are either whole and verified under their final name, or not there.
namespace dapple {

/// What stands on disk after a checked write.
struct WrittenFile {
    std::uint64_t bytes = 0;
    std::string content_hash;  ///< `content_hash` of the whole file (base/hash.h)
};

/// Looks at bytes that were read back from the disk, and throws when they are not what was meant.
using VerifyBytes = std::function<void(std::span<const std::byte> read_back)>;

/// Writes `bytes` as `.NAME.<host>.<pid>.tmp` in the folder of `path`, syncs, reads the file back, compares,
/// calls `verify` on what was read, renames it to `path` and syncs the folder. So a file under its final name
/// is complete, also after a kill or a power cut. An existing regular file is replaced; anything else at
/// `path` is refused. Throws Error(output_unwritable) naming `path` and the system's reason; the temporary is
/// gone then. What `verify` throws passes through in the same way. One path is written by one thread of a
/// process at a time. A process that meets a limit on file size gets an error only where it ignores SIGXFSZ.
WrittenFile write_file_atomically(const std::string& path, std::span<const std::byte> bytes,
                                  const VerifyBytes& verify = {});
WrittenFile write_file_atomically(const std::string& path, std::string_view text);

/// Removes the temporaries of `write_file_atomically` in `folder` (not below it) whose process, of this host,
/// is gone. Returns how many it removed. A folder that does not exist has none.
std::size_t remove_stale_temporaries(const std::string& folder);

/// Writes all bytes to an open descriptor, whatever number of calls that takes. `name` stands in the message
/// of Error(output_unwritable).
void write_all(int descriptor, std::span<const std::byte> bytes, const std::string& name);

/// The whole of a regular file. Throws Error(input_unreadable) naming `path`, also for folders, devices and
/// files of more than `most_bytes`.
std::vector<std::byte> read_whole_file(const std::string& path,
                                       std::uint64_t most_bytes = std::uint64_t{1} << 34);

}  // namespace dapple
