#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "scene/denoise.h"
#include "view/receiver_layer.h"

namespace dapple::denoise {

/// Power that falls on the parts of surfaces that pixels see, the mean over channels, W.
struct FilteredPower {
    double before = 0;
    double after = 0;
};

/// Filters E of a layer in place (W/m^2, an entry a pixel) among receivers that are covered; others stay as
/// they are. Each pass is one along the rows, then one along the columns (Kougianos and Moustakas 2021,
/// section 3.3). `weakest_light`: luminance of the weakest light, W/m^2. The same bits on any number of
/// threads.
///
/// By default exchange() of line_filter.h, which keeps the power, with radii found once a pass: found anew
/// for the columns, as the paper does, they leave streaks along the rows. With `paper_faithful` gather(). On
/// the CPU on all devices: E is shaded there, and where the device is the CPU too, a pass over 1920 x 1080
/// pixels takes no less there (0.5 CPU-s of radius 5, up to 1.3 of adaptive ones).
FilteredPower filter_irradiance(const view::ReceiverLayer& layer, std::span<const std::uint8_t> covered,
                                const scene::Denoise& settings, float weakest_light,
                                std::span<glm::vec3> irradiance);

}  // namespace dapple::denoise
