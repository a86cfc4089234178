#pragma once
#include <cstddef>
#include <functional>

namespace dapple {

/// Number of threads that `parallel_for` uses; 0 picks what the process may run on (affinity, control group).
/// Call once, before any other library starts its threads.
void set_thread_count(int threads);
int thread_count();

/// The only parallel loop of the program. [0, count) is cut into tiles of `tile` elements, fixed whatever the
/// number of threads; `body(begin, end)` runs once a tile, in any order. What a tile computes must depend on
/// nothing but its range, so that results have the same bits on any number of threads. The first exception of
/// a body is rethrown here.
void parallel_for(std::size_t count, std::size_t tile,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace dapple
