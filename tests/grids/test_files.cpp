#include "grids/test_files.h"

#include <unistd.h>

#include <fstream>
#include <iterator>

namespace dapple::grids {

TestFolder::TestFolder(const std::string& name)
    : path_(std::filesystem::temp_directory_path() /
            ("dapple_grids_" + std::to_string(::getpid()) + "_" + name)) {
    std::filesystem::create_directories(path_);
}

TestFolder::~TestFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::string read_bytes(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace dapple::grids
