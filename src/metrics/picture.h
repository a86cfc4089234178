#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

/// Metrics on pictures: they know nothing but images, and so judge anyone's sequences.
namespace dapple::metrics {

/// One frame as the metrics see it, row-major from the top left. Pixels with a NaN or infinite channel are
/// *excluded*: all their planes hold 0, and means leave them out of what they divide by. Where two pictures
/// are compared both exclude the same pixels (exclude_together), so that these differ nowhere.
struct Picture {
    int width = 0;
    int height = 0;
    std::array<std::vector<float>, 3> rgb;
    std::vector<float> luminance;         ///< relative luminance Y, of the picture's own primaries
    std::vector<std::uint32_t> excluded;  ///< pixel indices, ascending

    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    /// What means divide by.
    std::size_t counted() const { return pixels() - excluded.size(); }
};

/// The three channels of a layer: "" is R, G, B; "caustics" is caustics.R, .G, .B; a layer of one channel
/// ("Z", "Y") is taken for all three. Luminance by the image's primaries (image::Image::chromaticities), by
/// those of Rec.709 where it names none. Throws Error(input_unreadable) naming `name` and the layers there
/// are.
Picture picture_of(const image::Image& image, const std::string& layer, const std::string& name);

/// ITU-R BT.709: what an EXR without chromaticities has.
inline constexpr image::Chromaticities kRec709{
    {0.64f, 0.33f}, {0.30f, 0.60f}, {0.15f, 0.06f}, {0.3127f, 0.3290f}};

/// Both exclude what either does. The sizes must agree.
void exclude_together(Picture& a, Picture& b);

/// R, G, B of a picture of `image`'s primaries turned into linear Rec.709 (white adapted by Bradford's
/// matrix), which FLIP wants. Values may become negative; luminance stays.
void to_rec709(Picture& picture, const image::Image& image);
/// The same between any primaries.
void change_primaries(Picture& picture, const image::Chromaticities& from, const image::Chromaticities& to);

}  // namespace dapple::metrics
