#include "denoise/upsample.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "denoise/guide.h"

namespace dapple::denoise {
namespace {

constexpr std::size_t kTile = 4096;  ///< pixels
constexpr int kNearestReach = 4;     ///< coarse pixels

/// Where a fine pixel's value lies in the coarse picture: whole numbers are those of coarse pixels.
glm::dvec2 coarse_place(const view::ReceiverLayer& fine, std::size_t pixel, const CoarseGrid& grid) {
    const auto width = static_cast<std::size_t>(fine.width);
    const glm::uvec2 corner(pixel % width, pixel / width);
    return (glm::dvec2(corner) + grid.place + grid.margin) / static_cast<double>(grid.scale) - grid.place;
}

/// Runs `visit(coarse pixel, x, y)` over the part of a square of the coarse picture that lies in it.
template <class Visit>
void visit_square(const view::ReceiverLayer& coarse, glm::ivec2 low, glm::ivec2 high, Visit visit) {
    for (int y = std::max(0, low.y); y <= std::min(coarse.height - 1, high.y); ++y) {
        for (int x = std::max(0, low.x); x <= std::min(coarse.width - 1, high.x); ++x) {
            visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(coarse.width) +
                      static_cast<std::size_t>(x),
                  x, y);
        }
    }
}

std::vector<Guide> guides_of(const view::ReceiverLayer& layer) {
    std::vector<Guide> guides(layer.pixels());
    parallel_for(guides.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t pixel = begin; pixel < end; ++pixel) guides[pixel] = guide_of(layer, pixel);
    });
    return guides;
}

/// Whether a coarse receiver fits. `guides` are those of `coarse`.
bool find_mean(const view::ReceiverLayer& fine, const view::ReceiverLayer& coarse,
               const std::vector<Guide>& guides, const Irradiance& from, const CoarseGrid& grid,
               std::size_t pixel, Irradiance& to) {
    const glm::dvec2 place = coarse_place(fine, pixel, grid);
    const glm::ivec2 low(glm::floor(place));
    const Guide own = guide_of(fine, pixel);
    bool fits = false;
    float weights = 0;
    glm::vec3 sum(0);
    visit_square(coarse, low, low + 1, [&](std::size_t other, int x, int y) {
        const glm::dvec2 apart = glm::abs(glm::dvec2(x, y) - place);
        const double tent = (1 - apart.x) * (1 - apart.y);
        if (!(tent > 0)) return;
        const double pixels = std::max(1.0, grid.scale * std::max(apart.x, apart.y));
        const float weight =
            static_cast<float>(tent) * edge_stop(own, guides[other], static_cast<float>(pixels));
        if (!(weight > 0)) return;
        fits = true;
        if (!from.covered[other]) return;
        weights += weight;
        sum += weight * from.values[other];
    });
    if (weights > 0) {
        to.values[pixel] = sum / weights;
        to.covered[pixel] = 1;
    }
    return fits;
}

}  // namespace

std::vector<std::size_t> upsample(const view::ReceiverLayer& fine, const view::ReceiverLayer& coarse,
                                  const Irradiance& from, const CoarseGrid& grid, Irradiance& to) {
    to.values.assign(fine.pixels(), glm::vec3(0));
    to.covered.assign(fine.pixels(), 0);
    const std::vector<Guide> guides = guides_of(coarse);
    std::vector<std::uint8_t> missing(fine.pixels(), 0);
    parallel_for(fine.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t pixel = begin; pixel < end; ++pixel) {
            if (fine.flags[pixel] & view::kReceiver)
                missing[pixel] = find_mean(fine, coarse, guides, from, grid, pixel, to) ? 0 : 1;
        }
    });
    std::vector<std::size_t> pixels;
    for (std::size_t pixel = 0; pixel < missing.size(); ++pixel)
        if (missing[pixel]) pixels.push_back(pixel);
    return pixels;
}

std::vector<std::size_t> take_nearest(const view::ReceiverLayer& fine, const view::ReceiverLayer& coarse,
                                      const Irradiance& from, const CoarseGrid& grid,
                                      std::span<const std::size_t> pixels, Irradiance& to) {
    std::vector<std::size_t> left;
    for (const std::size_t pixel : pixels) {
        const glm::dvec2 place = coarse_place(fine, pixel, grid);
        const glm::ivec2 middle(glm::round(place));
        const Guide own = guide_of(fine, pixel);
        double nearest = std::numeric_limits<double>::infinity();
        visit_square(coarse, middle - kNearestReach, middle + kNearestReach,
                     [&](std::size_t other, int x, int y) {
                         if (!from.covered[other]) return;
                         const Guide guide = guide_of(coarse, other);
                         if (guide.surface != own.surface || !(glm::dot(guide.normal, own.normal) > 0))
                             return;
                         const glm::dvec2 apart = glm::dvec2(x, y) - place;
                         if (!(glm::dot(apart, apart) < nearest)) return;
                         nearest = glm::dot(apart, apart);
                         to.values[pixel] = from.values[other];
                         to.covered[pixel] = 1;
                     });
        if (!to.covered[pixel]) left.push_back(pixel);
    }
    return left;
}

}  // namespace dapple::denoise
