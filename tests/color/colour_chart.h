#pragma once
#include <cmath>
#include <glm/glm.hpp>

#include "base/hash.h"
#include "image/image.h"

namespace dapple::test {

/// Scene-linear colours over 16 stops, a ramp of greys, and some channels that are 0 or a little below.
inline image::Image colour_chart(int width = 96, int height = 64) {
    image::Image chart;
    chart.width = width;
    chart.height = height;
    for (std::uint32_t c = 0; c < 3; ++c) {
        auto& values = chart.add(std::string(1, "RGB"[c])).values;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const auto column = static_cast<double>(i % static_cast<std::size_t>(width)) / width;
            const bool is_grey = i < static_cast<std::size_t>(width);
            const double stops = 16 * (is_grey ? column : hash_uniform(7, 0, i, c)) - 10;
            values[i] = static_cast<float>(std::exp2(stops));
            if (!is_grey && hash_uniform(7, 1, i, c) < 0.02) values[i] = 0;
            if (!is_grey && hash_uniform(7, 2, i, c) < 0.02) values[i] = -0.01f;
        }
    }
    return chart;
}

/// A picture of one colour a pixel.
inline image::Image row_of(const std::vector<glm::vec3>& colours) {
    image::Image row;
    row.width = static_cast<int>(colours.size());
    row.height = 1;
    for (int c = 0; c < 3; ++c) {
        auto& values = row.add(std::string(1, "RGB"[c])).values;
        for (std::size_t i = 0; i < colours.size(); ++i) values[i] = colours[i][c];
    }
    return row;
}

}  // namespace dapple::test
