#pragma once
#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace dapple {

/// Memory that is not initialised; of large sizes on huge pages, where the system has them on request: the
/// first touch of small ones costs more than all that is then done with a photon. Throws std::bad_alloc.
void* allocate_large(std::size_t bytes);
void free_large(void* memory, std::size_t bytes);
/// Asks for huge pages behind a range that was not touched yet, of any size.
void advise_huge_pages(void* memory, std::size_t bytes);

/// For arrays of a million elements that are written once. Elements made without a value, as by
/// resize(count), are not initialised.
template <class T>
struct LargeAllocator {
    using value_type = T;
    LargeAllocator() = default;
    template <class U>
    LargeAllocator(const LargeAllocator<U>&) {}  // NOLINT(google-explicit-constructor): vectors convert it

    T* allocate(std::size_t count) {
        if (count > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
        return static_cast<T*>(allocate_large(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) { free_large(memory, count * sizeof(T)); }

    template <class U>
    void construct(U* at) noexcept(std::is_nothrow_default_constructible_v<U>) {
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Values>
    void construct(U* at, Values&&... values) {
        ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
    }
    template <class U>
    friend bool operator==(const LargeAllocator&, const LargeAllocator<U>&) {
        return true;
    }
};

template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace dapple
