#include "base/stats.h"

#include <sys/resource.h>

#include <cstdio>
#include <ctime>
#include <fstream>

namespace dapple {
namespace {

double seconds(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

void FrameStats::add_pass(const PassTime& pass) {
    for (PassTime& known : passes_) {
        if (known.name == pass.name) {
            known.wall_s += pass.wall_s;
            known.cpu_s += pass.cpu_s;
            known.device_s += pass.device_s;
            return;
        }
    }
    passes_.push_back(pass);
}

void FrameStats::count(std::string_view name, double amount) {
    for (auto& [known, sum] : counts_) {
        if (known == name) {
            sum += amount;
            return;
        }
    }
    counts_.emplace_back(name, amount);
}

double FrameStats::counted(std::string_view name) const {
    for (const auto& [known, sum] : counts_) {
        if (known == name) return sum;
    }
    return 0;
}

ScopedPass::ScopedPass(FrameStats& stats, std::string_view name)
    : stats_(stats), name_(name), wall_start_s_(wall_seconds()), cpu_start_s_(cpu_seconds()) {}

ScopedPass::~ScopedPass() {
    stats_.add_pass({name_, wall_seconds() - wall_start_s_, cpu_seconds() - cpu_start_s_, 0});
}

double wall_seconds() {
    return seconds(CLOCK_MONOTONIC);
}
double cpu_seconds() {
    return seconds(CLOCK_PROCESS_CPUTIME_ID);
}

std::uint64_t peak_memory_bytes() {
    // Not from getrusage, which counts in what a parent held when it started this process.
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        unsigned long long kib = 0;
        if (std::sscanf(line.c_str(), "VmHWM: %llu", &kib) == 1) return std::uint64_t{kib} * 1024;
    }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace dapple
