#include "methods/adaptive_beams/low_pass.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"

namespace dapple::methods::adaptive_beams {
namespace {

/// Sums of values (xyz) and of weights (w) along one axis, a line at a time.
std::vector<glm::vec4> blurred(const std::vector<glm::vec4>& from, int along, int across,
                               std::size_t along_step, std::size_t across_step,
                               const std::vector<float>& weights) {
    std::vector<glm::vec4> to(from.size());
    const int reach = static_cast<int>(weights.size()) - 1;
    parallel_for(static_cast<std::size_t>(across), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line) {
            for (int i = 0; i < along; ++i) {
                glm::vec4 sum(0);
                for (int k = std::max(0, i - reach); k <= std::min(along - 1, i + reach); ++k)
                    sum += weights[static_cast<std::size_t>(std::abs(k - i))] *
                           from[line * across_step + static_cast<std::size_t>(k) * along_step];
                to[line * across_step + static_cast<std::size_t>(i) * along_step] = sum;
            }
        }
    });
    return to;
}

}  // namespace

void low_pass(std::span<glm::vec3> picture, std::span<const std::uint8_t> covered, int width,
              double deviation) {
    if (!(deviation > 0) || picture.empty()) return;
    constexpr double kReach = 4;
    std::vector<float> weights;
    for (int k = 0; k <= kReach * deviation; ++k)
        weights.push_back(static_cast<float>(std::exp(-0.5 * k * k / (deviation * deviation))));
    std::vector<glm::vec4> values(picture.size(), glm::vec4(0));
    for (std::size_t i = 0; i < picture.size(); ++i)
        if (covered[i]) values[i] = glm::vec4(picture[i], 1);
    const auto row = static_cast<std::size_t>(width);
    const int height = static_cast<int>(picture.size() / row);
    values = blurred(values, width, height, 1, row, weights);
    values = blurred(values, height, width, row, 1, weights);
    for (std::size_t i = 0; i < picture.size(); ++i)
        if (covered[i]) picture[i] = glm::vec3(values[i]) / values[i].w;
}

}  // namespace dapple::methods::adaptive_beams
