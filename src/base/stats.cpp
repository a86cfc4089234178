#include "base/stats.h"

#include <sys/resource.h>

#include <ctime>

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
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace dapple
