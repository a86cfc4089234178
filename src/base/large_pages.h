#pragma once
#include <cstddef>

#include "base/large_vector.h"

namespace dapple {

/// Asks the system to lay memory that nothing has been written to yet on large pages. Each small page that is
/// touched for the first time costs more than most of what is then done with its 4 KiB. A hint: it changes
/// speed only, and nothing below 2 MiB, or where the system has no large pages or would not give any.
void prefer_large_pages(void* memory, std::size_t bytes);

/// Makes the vector that large, on large pages. What it held is lost, but for the memory.
template <class T>
void renew_large(LargeVector<T>& vector, std::size_t size) {
    vector.clear();  // or else it would be copied to a larger place
    vector.reserve(size);
    prefer_large_pages(vector.data(), size * sizeof(T));
    vector.resize(size);
}

}  // namespace dapple
