#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

/// What keeps dapple-read-vdb within its bounds. Part of that program alone.
namespace dapple::grids {

/// Ends the process with its parent; leaves no core dump; keeps it to one thread, as others' stacks and
/// arenas would be taken out of what is allowed.
void confine_process();

/// From now on the process may take `most_bytes` and kSpareBytes more. Where it has no more, it says so in a
/// Reply and ends, in whatever place of a library that is: too_large, or unreadable where the piece that it
/// asked for is out of proportion to the file, as happens with damaged ones.
void limit_memory(const char* file, std::uint64_t most_bytes);

/// What happens then.
[[noreturn]] void run_out_of_memory(std::size_t piece);

/// To kReplyFile; ends the process where nobody reads it.
void write_all(const void* data, std::size_t size);

/// "12.3 MiB".
std::string mebibytes(std::uint64_t bytes);

/// As much of it as fits, and a 0.
template <std::size_t size>
void copy_text(char (&to)[size], const char* from) {
    const std::size_t length = ::strnlen(from, size - 1);
    std::memcpy(to, from, length);
    to[length] = 0;
}

}  // namespace dapple::grids
