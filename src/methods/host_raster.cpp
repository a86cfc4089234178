#include "methods/host_raster.h"

namespace dapple::methods {
namespace {

constexpr std::size_t kTileRows = 16;

}  // namespace

HostLayer::HostLayer(const view::ReceiverLayer& layer, bool (*answers)(std::uint32_t flags),
                     const std::function<glm::vec3(std::size_t pixel)>& place)
    : width_(layer.width),
      height_(layer.height),
      // Eight from any pixel on are in the row's memory.
      stride_((static_cast<std::size_t>(width_) / lanes::kLanes<float> + 2) * lanes::kLanes<float>),
      numbers_(kArrays * stride_ * static_cast<std::size_t>(height_), 0.0f) {
    parallel_for(static_cast<std::size_t>(height_), kTileRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            float* to = row(static_cast<int>(y));
            std::fill_n(to + kMedium * stride_, stride_, -1.0f);
            for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
                const std::size_t i = y * static_cast<std::size_t>(width_) + x;
                if (!answers(layer.flags[i])) continue;
                const glm::vec3 at = place(i), normal = layer.shading_normal[i];
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto axis = static_cast<glm::length_t>(k);
                    to[(kPosition + k) * stride_ + x] = at[axis];
                    to[(kNormal + k) * stride_ + x] = normal[axis];
                }
                to[kMedium * stride_ + x] = (layer.flags[i] & view::kInWater) != 0 ? 1.0f : 0.0f;
            }
        }
    });
}

void HostLayer::read(const view::ReceiverLayer& layer, LayerResult& result) const {
    result.irradiance.resize(layer.pixels());
    result.covered.resize(layer.pixels());
    parallel_for(static_cast<std::size_t>(height_), kTileRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            const float* from = row(static_cast<int>(y));
            const float* sum = from + kSum * stride_;
            for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
                const std::size_t i = y * static_cast<std::size_t>(width_) + x;
                result.covered[i] = from[kMedium * stride_ + x] < 0 ? 0 : 1;
                result.irradiance[i] = {sum[x], sum[stride_ + x], sum[2 * stride_ + x]};
            }
        }
    });
}

}  // namespace dapple::methods
