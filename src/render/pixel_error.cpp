#include "render/pixel_error.h"

#include <algorithm>
#include <cmath>

#include "render/buffer_scale.h"
#include "render/error_estimate.h"

namespace dapple::render {
namespace {

/// The same view in pixels half as wide.
scene::FrameState in_quarters(scene::FrameState state) {
    state.clip.width *= 2;
    state.clip.height *= 2;
    return state;
}

/// Means of the quarters of pixels, `width` of them in a row, from a picture twice as wide and high; covered
/// where all look at the same face as the pixel does: elsewhere means are of other places.
PixelIrradiance mean_of_quarters(const PixelIrradiance& quarters, const std::vector<PixelSurface>& faces,
                                 int width, const std::vector<PixelSurface>& pixel_faces) {
    const std::size_t columns = static_cast<std::size_t>(width), pixels = pixel_faces.size();
    PixelIrradiance mean{std::vector<glm::vec3>(pixels, glm::vec3(0)), std::vector<std::uint8_t>(pixels, 1)};
    for (std::size_t i = 0; i < pixels; ++i) {
        const std::size_t first = 4 * columns * (i / columns) + 2 * (i % columns);
        for (const std::size_t quarter : {first, first + 1, first + 2 * columns, first + 2 * columns + 1}) {
            mean.values[i] += 0.25f * quarters.values[quarter];
            if (quarters.covered[quarter] == 0 || !pixel_faces[i].same_face(faces[quarter]))
                mean.covered[i] = 0;
        }
    }
    return mean;
}

}  // namespace

double pixel_error(const scene::FrameState& state, int samples, const PixelPicture& by_one,
                   const std::function<PixelPicture(const scene::FrameState&)>& look) {
    if (samples == 1) {
        const PixelPicture quarters = look(in_quarters(state));
        return relative_difference(by_one.irradiance, mean_of_quarters(quarters.irradiance, quarters.surfaces,
                                                                       state.clip.width, by_one.surfaces));
    }
    // Pictures of odd sides cannot be taken two by two: all three are of the same view.
    const scene::FrameState doubled = at_scale(state, 2);
    const int width = doubled.clip.width;
    const PixelPicture wide = look(doubled), pixels = look(in_quarters(doubled)),
                       quarters = look(in_quarters(in_quarters(doubled)));
    const auto in_wide = [&](const PixelIrradiance& e) {
        return mean_of_quarters(e, pixels.surfaces, width, wide.surfaces);
    };
    const PixelIrradiance of_quarters =
        mean_of_quarters(quarters.irradiance, quarters.surfaces, 2 * width, pixels.surfaces);
    const PixelIrradiance four = in_wide(pixels.irradiance), sixteen = in_wide(of_quarters);
    const double one_blurs = relative_difference(wide.irradiance, four),
                 four_blur = relative_difference(four, sixteen);
    const double fall = one_blurs > 0 ? std::min(1.0, four_blur / one_blurs) : 0;
    return relative_difference(pixels.irradiance, of_quarters) *
           std::pow(fall, 0.5 * std::log2(static_cast<double>(samples)));
}

}  // namespace dapple::render
