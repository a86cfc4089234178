#include "base/large_vector.h"

#include <sys/mman.h>

#include <cstdint>

namespace dapple {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kLarge = 2 * kHugePage;

}  // namespace

void advise_huge_pages(void* memory, std::size_t bytes) {
    const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + kHugePage - 1) & ~(kHugePage - 1);
    const auto end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) & ~(kHugePage - 1);
    // It is a matter of speed only: systems without them refuse.
    if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

void* allocate_large(std::size_t bytes) {
    if (bytes < kLarge) return ::operator new(bytes);
    void* memory = ::operator new(bytes, std::align_val_t(kHugePage));
    advise_huge_pages(memory, bytes);
    return memory;
}

void free_large(void* memory, std::size_t bytes) {
    if (bytes < kLarge) {
        ::operator delete(memory);
    } else {
        ::operator delete(memory, std::align_val_t(kHugePage));
    }
}

}  // namespace dapple
