#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "grids/grid_buffer.h"

namespace dapple::grids {

/// What a child process left behind.
struct ProcessOutput {
    std::vector<std::byte> text;  ///< what it wrote to file descriptor kReplyFile
    GridBuffer voxels;            ///< what it wrote to file descriptor kVoxelsFile
    std::string failure;          ///< empty where it ended with 0, else how it ended
};

/// Runs a program to its end, without a shell, in a process group of its own (Ctrl-C reaches only its
/// parent), with nothing open but these two; what it prints is thrown away. It is killed when
/// it takes longer than `most_seconds` or says more than `most_text` bytes. arguments[0] is the program's
/// path. Throws Error(failure) where it cannot be started.
ProcessOutput run_reader(const std::vector<std::string>& arguments, double most_seconds,
                         std::size_t most_text);

/// Path of dapple-read-vdb: beside this program, as installed, or else where it was built.
std::string reader_program();

}  // namespace dapple::grids
