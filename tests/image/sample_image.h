#pragma once
#include <cmath>

#include "base/hash.h"
#include "image/image.h"

namespace dapple::test {

/// A picture with layers of both types: smooth values of many magnitudes, negative ones among them.
inline image::Image sample_image(int width, int height) {
    image::Image picture;
    picture.width = width;
    picture.height = height;
    const auto fill = [&](const char* name, image::PixelType type, float scale) {
        image::Channel& channel = picture.add(name, type);
        for (std::size_t i = 0; i < channel.values.size(); ++i) {
            const std::size_t row = i / static_cast<std::size_t>(width);
            const auto x = static_cast<float>(i % static_cast<std::size_t>(width));
            const auto y = static_cast<float>(row);
            channel.values[i] = scale * (0.2f + std::sin(0.1f * x) * std::cos(0.07f * y));
        }
    };
    // Not in the order of their names, in which OpenEXR sorts them.
    fill("R", image::PixelType::half_float, 1.0f);
    fill("G", image::PixelType::half_float, 0.3f);
    fill("B", image::PixelType::half_float, 40.0f);
    fill("Z", image::PixelType::float32, 1234.5f);
    fill("caustics.R", image::PixelType::float32, 0.01f);
    fill("caustics.G", image::PixelType::float32, 1e-7f);
    fill("caustics.B", image::PixelType::float32, 1e7f);
    fill("E.G", image::PixelType::float32, 3.0f);
    picture.metadata = {{"dapple:frame", "12"}, {"comments", "two\nlines, \"quoted\""}, {"owner", ""}};
    return picture;
}

}  // namespace dapple::test
