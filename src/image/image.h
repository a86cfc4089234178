#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <optional>
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

/// CIE 1931 x, y of the primaries and of white.
struct Chromaticities {
    glm::vec2 red, green, blue, white;
    bool operator==(const Chromaticities&) const = default;
};

/// AP1 with the ACES white point: the primaries of ACEScg (SMPTE ST 2065-1, Academy S-2014-004).
inline constexpr Chromaticities kAcesCgChromaticities{
    {0.713f, 0.293f}, {0.165f, 0.830f}, {0.128f, 0.044f}, {0.32168f, 0.33767f}};

/// Float image of any number of named channels, and metadata in fixed order.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<Channel> channels;
    std::vector<std::pair<std::string, std::string>> metadata;  ///< string attributes of an EXR header
    /// What a file says of its primaries; writers take them from their options.
    std::optional<Chromaticities> chromaticities = {};
    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    /// The channel of that name, or null.
    Channel* find(const std::string& name);
    const Channel* find(const std::string& name) const;
    /// Appends a channel of zeros. The reference holds until the next one is added. The name must be new.
    Channel& add(const std::string& name, PixelType type = PixelType::float32);
};

}  // namespace dapple::image
