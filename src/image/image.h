#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace dapple::image {

enum class PixelType { half_float, float32 };

/// One named channel of width * height floats, row-major from the top left.
struct Channel {
    std::string name;                     ///< EXR name: "R", "caustics.R", "E.G", "Z"
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
    /// The channel of that name, or null.
    Channel* find(const std::string& name);
    const Channel* find(const std::string& name) const;
    /// Appends a channel of zeros. The reference holds until the next one is added. The name must be new.
    Channel& add(const std::string& name, PixelType type = PixelType::float32);
};

}  // namespace dapple::image
