#include "base/large_pages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

namespace dapple {
namespace {

// Less than a large page, where they have 2 MiB, cannot lie on one.
constexpr std::size_t kLeast = std::size_t{2} << 20;

}  // namespace

void prefer_large_pages(void* memory, std::size_t bytes) {
    if (bytes < kLeast) return;
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(memory);
    const std::uintptr_t first = (begin + page - 1) / page * page, last = (begin + bytes) / page * page;
    madvise(static_cast<char*>(memory) + (first - begin), last - first, MADV_HUGEPAGE);
}

}  // namespace dapple
