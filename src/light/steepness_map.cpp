#include "light/steepness_map.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace dapple::light {
namespace {

constexpr int kSide = 64;  // cells along either axis
constexpr int kNear = 1, kFar = 4;
constexpr std::size_t kTile = 1 << 13;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t index_of(int column, int row) {
    return static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column);
}

/// The largest of all that threads bring, in any order.
void raise(float& value, float to) {
    const std::atomic_ref<float> shared(value);
    float now = shared.load(std::memory_order_relaxed);
    while (now < to && !shared.compare_exchange_weak(now, to, std::memory_order_relaxed)) {
    }
}

}  // namespace

double slope_squared(glm::dvec3 normal) {
    if (!(normal.y > 0)) return normal == glm::dvec3(0) ? 0 : kInfinity;
    return (normal.x * normal.x + normal.z * normal.z) / (normal.y * normal.y);
}

glm::ivec2 SteepnessMap::cell(glm::dvec2 at) const {
    const glm::dvec2 scaled = (at - glm::dvec2(lower_.x, lower_.z)) / cell_size_;
    return glm::ivec2(glm::clamp(scaled, 0.0, kSide - 1.0));
}

std::vector<float> SteepnessMap::widened(const std::vector<float>& values, int reach) const {
    std::vector<float> rows(values.size(), 0), result(values.size(), 0);
    for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < kSide; ++column)
            for (int k = std::max(0, column - reach); k <= std::min(kSide - 1, column + reach); ++k)
                rows[index_of(column, row)] = std::max(rows[index_of(column, row)], values[index_of(k, row)]);
    for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < kSide; ++column)
            for (int k = std::max(0, row - reach); k <= std::min(kSide - 1, row + reach); ++k)
                result[index_of(column, row)] =
                    std::max(result[index_of(column, row)], rows[index_of(column, k)]);
    return result;
}

SteepnessMap::SteepnessMap(const scene::TriangleMesh& mesh) : lower_(kInfinity), upper_(-kInfinity) {
    for (const glm::dvec3 p : mesh.positions) {
        if (!(glm::dot(p, p) < kInfinity)) continue;
        lower_ = glm::min(lower_, p);
        upper_ = glm::max(upper_, p);
    }
    const glm::dvec3 size = glm::max(upper_ - lower_, glm::dvec3(1e-9));
    cell_size_ = glm::dvec2(size.x, size.z) / static_cast<double>(kSide);
    std::vector<float> cells(std::size_t{kSide} * kSide, 0);
    parallel_for(mesh.triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::uvec3 t = mesh.triangles[i];
            const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            if (!(glm::dot(normal, normal) < kInfinity)) continue;
            // Rounded up, so that float does not make the water less steep.
            const float slope = static_cast<float>(slope_squared(normal)) * (1 + 0x1p-22f);
            const glm::dvec3 least = glm::min(a, glm::min(b, c)), most = glm::max(a, glm::max(b, c));
            const glm::ivec2 first = cell({least.x, least.z}), last = cell({most.x, most.z});
            for (int row = first.y; row <= last.y; ++row)
                for (int column = first.x; column <= last.x; ++column)
                    raise(cells[index_of(column, row)], slope);
        }
    });
    near_ = widened(cells, kNear);
    far_ = widened(cells, kFar);
    steepest_ = *std::max_element(cells.begin(), cells.end());
}

bool SteepnessMap::may_meet(glm::dvec3 point, glm::dvec3 way, bool in_water) const {
    if (in_water ? way.y >= 0 : way.y <= 0) return true;  // it turns back to the water
    const double run_squared = way.x * way.x + way.z * way.z, rise_squared = way.y * way.y;
    const double height = in_water ? point.y - lower_.y : upper_.y - point.y;
    const double reach = std::max(0.0, height) * std::sqrt(run_squared / rise_squared);
    const double cell_side = std::min(cell_size_.x, cell_size_.y);
    const glm::ivec2 at = cell({point.x, point.z});
    float steep = steepest_;
    if (reach < kNear * cell_side) {
        steep = near_[index_of(at.x, at.y)];
    } else if (reach < kFar * cell_side) {
        steep = far_[index_of(at.x, at.y)];
    }
    return !(rise_squared > static_cast<double>(steep) * run_squared);
}

}  // namespace dapple::light
