#include "methods/sliced_beams/scatter_layer.h"

#include <cmath>
#include <numbers>

namespace dapple::methods::sliced_beams {

LayerSegments::LayerSegments(const view::SegmentLayer& layer)
    : layer_(layer),
      across_((static_cast<std::size_t>(layer.width) + kWide * kSide - 1) / (kWide * kSide)),
      down_((static_cast<std::size_t>(layer.height) + kHigh * kSide - 1) / (kHigh * kSide)) {}

std::vector<LayerGroup> LayerSegments::groups(std::size_t patch) const {
    const auto width = static_cast<std::size_t>(layer_.width),
               height = static_cast<std::size_t>(layer_.height);
    const std::size_t left = patch % across_ * kWide * kSide, top = patch / across_ * kHigh * kSide;
    std::vector<LayerGroup> all;
    for (const bool in_water : {false, true}) {
        struct Open {
            std::size_t group, lane;
        };
        std::vector<Open> open;  // of the first segments of pixels, the second ones, ...
        for (std::size_t i = 0; i < kSide * kSide * kWide * kHigh; ++i) {
            const std::size_t block = i / (kWide * kHigh), pixel = i % (kWide * kHigh);
            const std::size_t column = (block & 1) | (block >> 1 & 2),
                              row = (block >> 1 & 1) | (block >> 2 & 2);
            const std::size_t x = left + column * kWide + pixel % kWide,
                              y = top + row * kHigh + pixel / kWide;
            if (x >= width || y >= height) continue;
            std::size_t nth = 0;
            for (std::uint32_t s = layer_.first[y * width + x]; s < layer_.first[y * width + x + 1]; ++s) {
                if ((layer_.in_water[s] != 0) != in_water) continue;
                if (nth == open.size()) open.push_back({0, kLanes<float>});
                Open& to = open[nth++];
                if (to.lane == kLanes<float>) {
                    to = {all.size(), 0};
                    LayerGroup& added = all.emplace_back();
                    added.in_water = in_water;
                    added.segments.length = splat(-1.0f);
                }
                LayerGroup& group = all[to.group];
                const std::size_t lane = to.lane++;
                group.segment[lane] = s;
                for (int k = 0; k < 3; ++k) {
                    group.segments.origin[k][lane] = layer_.origin[s][k];
                    group.segments.direction[k][lane] = layer_.direction[s][k];
                }
                group.segments.length[lane] = layer_.length[s];
            }
        }
    }
    return all;
}

std::vector<glm::dvec2> disc_directions(int count, int sample, int samples) {
    if (count * samples <= 1) return {{0, 0}};
    constexpr double golden = 0.6180339887498949;   // 1 / golden ratio
    constexpr double plastic = 0.7548776662466927;  // 1 / plastic number
    const double shift = (sample + 0.5) / std::max(1, samples);
    std::vector<glm::dvec2> directions;
    for (int k = 0; k < count; ++k) {
        const double radius = std::sqrt((k + shift) / count);
        const double turn = 2 * std::numbers::pi * (k * golden + sample * plastic);
        directions.emplace_back(radius * std::cos(turn), radius * std::sin(turn));
    }
    return directions;
}

}  // namespace dapple::methods::sliced_beams
