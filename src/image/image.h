#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace dapple::image {

enum class PixelType { half_float, float32 };

/// One named channel of width * height floats, row-major from the top left.
struct Channel {
    std::string name;  ///< EXR name: "R", "caustics.R", "E.G", "Z"
    PixelType type = PixelType::float32;  ///< as written to files; in memory always float
    std::vector<float> values;
};

/// Float image of any number of named channels, and metadata in fixed order.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<Channel> channels;
    std::vector<std::pair<std::string, std::string>> metadata;  ///< string attributes of an EXR header
    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    Channel* find(const std::string& name);
    const Channel* find(const std::string& name) const;
};

}  // namespace dapple::image
