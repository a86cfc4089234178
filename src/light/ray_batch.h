#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "rays/ray_scene.h"

namespace dapple::light {

/// Rays of a grid's vertices that are traced at once: whole packets, and so few that they and what they hit
/// stay in the processor's caches. Used again and again: to allocate for each band of a grid costs more than
/// to trace it.
class RayBatch {
public:
    static constexpr std::size_t kMost = 256;

    bool full() const { return count_ == kMost; }
    void clear() { count_ = 0; }
    /// The vertex's ray, to be written in its place: to read at once, as a whole, what was just written in
    /// parts makes the processor wait.
    rays::Ray& add(std::size_t vertex) {
        vertices_[count_] = vertex;
        return rays_[count_++];
    }
    std::span<const rays::Ray> rays() const { return std::span(rays_).first(count_); }
    std::span<const std::size_t> vertices() const { return std::span(vertices_).first(count_); }

private:
    std::array<rays::Ray, kMost> rays_;
    std::array<std::size_t, kMost> vertices_;
    std::size_t count_ = 0;
};

}  // namespace dapple::light
