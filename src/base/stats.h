#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dapple {

/// What one pass of a frame cost.
struct PassTime {
    std::string name;
    double wall_s = 0;
    double cpu_s = 0;     // process CPU time, all threads
    double device_s = 0;  // from the device's timestamps; 0 for passes of the CPU
};

/// Costs and counts of one frame. Owned by the frame loop and filled by the passes, in their fixed order,
/// from one thread. Passes of one name add up.
class FrameStats {
public:
    void add_pass(const PassTime& pass);
    void count(std::string_view name, double amount);
    const std::vector<PassTime>& passes() const { return passes_; }
    const std::vector<std::pair<std::string, double>>& counts() const { return counts_; }
    double counted(std::string_view name) const;

private:
    std::vector<PassTime> passes_;
    std::vector<std::pair<std::string, double>> counts_;
};

/// Adds the time between its construction and destruction to `stats` as a pass.
class ScopedPass {
public:
    ScopedPass(FrameStats& stats, std::string_view name);
    ~ScopedPass();
    ScopedPass(const ScopedPass&) = delete;
    ScopedPass& operator=(const ScopedPass&) = delete;

private:
    FrameStats& stats_;
    std::string name_;
    double wall_start_s_;
    double cpu_start_s_;
};

/// Seconds of a monotonic clock, of the process's CPU (all threads), and the process's peak memory in bytes.
double wall_seconds();
double cpu_seconds();
std::uint64_t peak_memory_bytes();

}  // namespace dapple
