#include "denoise/line_filter.h"

#include <algorithm>
#include <cmath>

namespace dapple::denoise {
namespace {

constexpr float kUnitsAMetre = 100;  ///< Unreal's unit is 1 cm

}  // namespace

Reach::Reach(const Kernel& k) : kernel(k) {
    for (int d = 1; d <= k.radius; ++d) {
        const float apart = static_cast<float>(d) / k.distance_scale;
        weights.push_back(1 / (1 + 10 * apart * apart));
    }
}

void exchange(std::span<LinePixel> line, std::size_t largest_radius, LineScratch& scratch) {
    const std::size_t count = line.size(), reach = largest_radius;
    scratch.weights.assign(count * reach, 0);
    scratch.sums.assign(count, 1);
    scratch.received.assign(count, glm::vec3(0));
    for (std::size_t p = 0; p < count; ++p) {
        if (line[p].guide.surface == kNoSurface) continue;
        for (std::size_t d = 1; d <= reach && p + d < count; ++d) {
            const std::size_t q = p + d;
            if (line[q].guide.surface != line[p].guide.surface) continue;
            const float by_distance = std::max(line[p].reach->at(d), line[q].reach->at(d));
            if (by_distance == 0) continue;
            const float weight = by_distance * edge_stop(line[p].guide, line[q].guide, static_cast<float>(d));
            scratch.weights[p * reach + d - 1] = weight;
            scratch.sums[p] += weight;
            scratch.sums[q] += weight;
        }
    }
    for (std::size_t p = 0; p < count; ++p) {
        const float own = line[p].area / scratch.sums[p];
        for (std::size_t d = 1; d <= reach && p + d < count; ++d) {
            const float weight = scratch.weights[p * reach + d - 1];
            if (weight == 0) continue;
            const std::size_t q = p + d;
            const float exchanged = weight * std::min(own, line[q].area / scratch.sums[q]);
            if (!(exchanged > 0)) continue;
            const glm::vec3 power = exchanged * (line[q].irradiance - line[p].irradiance);
            scratch.received[p] += power / line[p].area;
            scratch.received[q] -= power / line[q].area;
        }
    }
    for (std::size_t p = 0; p < count; ++p) line[p].irradiance += scratch.received[p];
}

void gather(std::span<LinePixel> line, LineScratch& scratch) {
    const auto count = static_cast<std::ptrdiff_t>(line.size());
    scratch.received.resize(line.size());
    for (std::ptrdiff_t i = 0; i < count; ++i) {
        const LinePixel& p = line[static_cast<std::size_t>(i)];
        if (p.guide.surface == kNoSurface) continue;
        const Kernel& kernel = p.reach->kernel;
        glm::vec3 sum = p.irradiance;
        float weights = 1;
        for (std::ptrdiff_t d = -kernel.radius; d <= kernel.radius; d += kernel.step) {
            if (d == 0 || i + d < 0 || i + d >= count) continue;
            const LinePixel& q = line[static_cast<std::size_t>(i + d)];
            if (q.guide.surface == kNoSurface) continue;
            const glm::vec3 way = kUnitsAMetre * (p.guide.position - q.guide.position);
            const float by_depth = 1 / (kUnitsAMetre * std::abs(p.depth - q.depth) + 1);
            const float by_place =
                1 / (1 + 10 * glm::dot(way, way) / (kernel.distance_scale * kernel.distance_scale));
            const float weight = by_depth * by_place;
            sum += weight * q.irradiance;
            weights += weight;
        }
        scratch.received[static_cast<std::size_t>(i)] = sum / weights;
    }
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i].guide.surface != kNoSurface) line[i].irradiance = scratch.received[i];
    }
}

}  // namespace dapple::denoise
