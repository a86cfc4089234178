#include "methods/sliced_beams/scatter_layer.h"

#include <cmath>
#include <numbers>

namespace dapple::methods::sliced_beams {

LayerSegments::LayerSegments(const view::SegmentLayer& layer)
    : layer_(layer),
      across_((static_cast<std::size_t>(layer.width) + kWide - 1) / kWide),
      down_((static_cast<std::size_t>(layer.height) + kHigh - 1) / kHigh) {}

std::vector<LayerGroup> LayerSegments::groups(std::size_t block) const {
    const auto width = static_cast<std::size_t>(layer_.width),
               height = static_cast<std::size_t>(layer_.height);
    const std::size_t left = block % across_ * kWide, top = block / across_ * kHigh;
    std::vector<LayerGroup> all;
    for (const bool in_water : {false, true}) {
        const std::size_t first_group = all.size();
        for (std::size_t lane = 0; lane < kWide * kHigh; ++lane) {
            const std::size_t x = left + lane % kWide, y = top + lane / kWide;
            if (x >= width || y >= height) continue;
            std::size_t group = first_group;
            for (std::uint32_t i = layer_.first[y * width + x]; i < layer_.first[y * width + x + 1]; ++i) {
                if ((layer_.in_water[i] != 0) != in_water) continue;
                if (group == all.size()) {
                    LayerGroup& added = all.emplace_back();
                    added.in_water = in_water;
                    added.segments.length = splat(-1.0f);
                }
                LayerGroup& to = all[group++];
                to.segment[lane] = i;
                for (int k = 0; k < 3; ++k) {
                    to.segments.origin[k][lane] = layer_.origin[i][k];
                    to.segments.direction[k][lane] = layer_.direction[i][k];
                }
                to.segments.length[lane] = layer_.length[i];
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
