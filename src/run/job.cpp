#include "run/job.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/checked_file.h"
#include "base/error.h"
#include "base/hash.h"
#include "grids/reader_process.h"

namespace dapple::run {

std::string Job::hash() const {
    std::string text;
    for (const auto& [name, value] : parts) {
        // With the zeros at their ends, so that no letter can move from one to the next.
        text.append(name.c_str(), name.size() + 1);
        text.append(value.c_str(), value.size() + 1);
    }
    return content_hash(text);
}

void check_readable(const std::vector<std::string>& paths) {
    std::string first;
    std::size_t others = 0;
    for (const std::string& path : paths) {
        std::error_code reason;
        const bool regular = std::filesystem::is_regular_file(path, reason);
        if (regular && ::access(path.c_str(), R_OK) == 0) continue;
        if (!first.empty()) {
            ++others;
        } else if (regular) {
            first = path + ": cannot be read: " + std::strerror(errno);
        } else {
            first = path + ": cannot be read: " + (reason ? reason.message() : "it is no regular file");
        }
    }
    if (first.empty()) return;
    if (others > 0) first += " (and " + std::to_string(others) + " more input files)";
    throw Error(ExitCode::input_unreadable, first);
}

std::string hash_files(const std::vector<std::string>& paths) {
    std::string hashes;
    for (const std::string& path : paths) {
        const std::vector<std::byte> content = read_whole_file(path);
        hashes += content_hash(content.data(), content.size()) + "\n";
    }
    return content_hash(hashes);
}

std::string program_identity() {
    std::vector<std::string> files = {"/proc/self/exe"};
    // Where it is missing, clips that need no grids are rendered all the same.
    std::error_code ignored;
    const std::string reader = grids::reader_program();
    if (std::filesystem::exists(reader, ignored)) files.push_back(reader);
    return std::string(DAPPLE_VERSION) + " " + hash_files(files);
}

std::string differences(const NamedTexts& a, const NamedTexts& b) {
    std::string names;
    const auto add = [&](const std::string& name) {
        if (!names.empty()) names += ", ";
        names += "the " + name;
    };
    for (const auto& part : a) {
        if (std::find(b.begin(), b.end(), part) == b.end()) add(part.first);
    }
    for (const auto& part : b) {
        const auto same_name = [&](const auto& other) { return other.first == part.first; };
        if (std::none_of(a.begin(), a.end(), same_name)) add(part.first);
    }
    return names;
}

}  // namespace dapple::run
