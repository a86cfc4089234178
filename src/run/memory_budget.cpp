#include "run/memory_budget.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string_view>

#include "base/error.h"

namespace dapple::run {
namespace {

/// Bytes a unit of the text, 0 where it is none.
double unit_of(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    if (text.empty() || text == "b") return 1;
    constexpr std::string_view prefixes = "kmgt";
    const std::size_t power = prefixes.find(text.front());
    if (power == std::string_view::npos) return 0;
    const std::string rest = text.substr(1);
    if (!rest.empty() && rest != "b" && rest != "ib") return 0;
    return std::exp2(10.0 * static_cast<double>(power + 1));
}

std::uint64_t limit_in(const std::string& file) {
    std::ifstream stream(file);
    std::uint64_t bytes = 0;
    return stream >> bytes ? bytes : UINT64_MAX;  // no file, or "max": no limit
}

/// The lowest limit of the process's control group and those that hold it (version 2, then version 1).
std::uint64_t control_group_limit() {
    const std::string root = "/sys/fs/cgroup";
    std::uint64_t limit =
        std::min(limit_in(root + "/memory.max"), limit_in(root + "/memory/memory.limit_in_bytes"));
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        if (!line.starts_with("0::")) continue;
        for (std::string path = line.substr(3); path.size() > 1; path.resize(path.rfind('/'))) {
            limit = std::min(limit, limit_in(root + path + "/memory.max"));
        }
    }
    return limit;
}

}  // namespace

std::uint64_t parse_bytes(const std::string& text) {
    double number = 0;
    const char* end_of_text = text.data() + text.size();
    const auto [end, fault] = std::from_chars(text.data(), end_of_text, number);
    const std::size_t unit_begin =
        std::min(text.find_first_not_of(' ', static_cast<std::size_t>(end - text.data())), text.size());
    const double bytes = number * unit_of(text.substr(unit_begin));
    if (fault != std::errc{} || !(bytes >= 1) || bytes >= 0x1p63) {
        throw Error(ExitCode::usage,
                    "'" + clipped(text) + "' is no amount of memory; write 8G, 512M or bytes");
    }
    return static_cast<std::uint64_t>(bytes);
}

std::string format_bytes(double bytes) {
    constexpr const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB", "PiB"};
    std::size_t unit = 0;
    while (bytes >= 1024 && unit + 1 < std::size(units)) {
        bytes /= 1024;
        ++unit;
    }
    char text[32];
    std::snprintf(text, sizeof text, unit == 0 ? "%.0f %s" : "%.1f %s", bytes, units[unit]);
    return text;
}

std::uint64_t default_memory_budget() {
    const auto physical = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                          static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
    return std::min(physical, control_group_limit()) / 4 * 3;
}

}  // namespace dapple::run
