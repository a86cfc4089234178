#pragma once
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace dapple::image {

/// Turns interleaved code values of a display-encoded picture into scene-linear RGB, in place
/// (`color::Grader`).
using ToLinear = std::function<void(std::span<float> rgb)>;

/// A picture that covers the plane by repetition, with a pyramid of box-filtered levels in linear light
/// (Williams 1983). (u, v) = (0, 0) is its lower left corner and (1, 1) its upper right, so v runs against
/// the rows.
class Texture {
public:
    /// An EXR file (channels R, G, B, or Y for grey; taken as scene-linear) or a PNG (through `to_linear`),
    /// told apart by content. Throws Error(input_unreadable) that begins with `path`; non-finite pixels are
    /// such an error.
    static Texture load(const std::string& path, const ToLinear& to_linear);

    /// Linear RGB of 3 * width * height floats, row-major from the top left.
    Texture(int width, int height, std::vector<float> rgb);

    int width() const { return levels_.front().width; }
    int height() const { return levels_.front().height; }
    int level_count() const { return static_cast<int>(levels_.size()); }

    /// Trilinear value at `uv`. `uv_width` is the width of the footprint in units of uv: at one texel of the
    /// longer side or less it is the bilinear value of the full picture, which is exact at texel centres; at
    /// 1 the mean.
    glm::vec3 sample(glm::vec2 uv, float uv_width) const;
    /// The same of the picture once, its outermost texels going on for ever.
    glm::vec3 sample_once(glm::vec2 uv, float uv_width) const;

    /// The full picture, as the constructor takes it.
    std::span<const float> rgb() const { return levels_.front().rgb; }

private:
    struct Level {
        int width = 0;
        int height = 0;
        std::vector<float> rgb;
    };
    static Level halved(const Level& finer);
    static glm::vec3 bilinear(const Level& level, glm::vec2 uv);
    template <class Lookup>
    glm::vec3 trilinear(float uv_width, const Lookup& lookup) const;

    std::vector<Level> levels_;  ///< the full picture first, one pixel last
};

}  // namespace dapple::image
