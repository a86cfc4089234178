#include "run/job.h"

#include <algorithm>

#include "base/checked_file.h"
#include "base/hash.h"

namespace dapple::run {

std::string Job::hash() const {
    std::string text;
    for (const auto& [name, value] : parts) text += name + '\0' + value + '\0';
    return content_hash(text);
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
    return std::string(DAPPLE_VERSION) + " " + hash_files({"/proc/self/exe"});
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
