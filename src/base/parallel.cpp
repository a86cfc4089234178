#include "base/parallel.h"

#include <sched.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <memory>
#include <mutex>

namespace dapple {
namespace {

int available_threads() {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
    return 1;
}

int threads = 0;
std::unique_ptr<tbb::global_control> control;

}  // namespace

void set_thread_count(int count) {
    threads = count > 0 ? count : available_threads();
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(threads));
}

int thread_count() {
    // Threads of one's own (read-ahead) may ask first, at the same time.
    static std::once_flag chosen;
    std::call_once(chosen, [] {
        if (threads == 0) set_thread_count(0);
    });
    return threads;
}

void parallel_for(std::size_t count, std::size_t tile,
                  const std::function<void(std::size_t begin, std::size_t end)>& body) {
    assert(tile > 0);
    if (count == 0) return;
    thread_count();
    const std::size_t tiles = (count + tile - 1) / tile;
    tbb::parallel_for(
        std::size_t{0}, tiles,
        [&](std::size_t index) { body(index * tile, std::min(count, (index + 1) * tile)); },
        tbb::simple_partitioner{});
}

}  // namespace dapple
