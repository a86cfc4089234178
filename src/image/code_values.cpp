#include "image/code_values.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace dapple::image {
namespace {

constexpr std::size_t kTilePixels = 1 << 14;

template <typename Code>
std::vector<Code> to_codes(const Image& graded) {
    const Channel* channels[3] = {graded.find("R"), graded.find("G"), graded.find("B")};
    assert(channels[0] != nullptr && channels[1] != nullptr && channels[2] != nullptr);
    constexpr float largest = std::numeric_limits<Code>::max();
    std::vector<Code> codes(3 * graded.pixels());
    parallel_for(graded.pixels(), kTilePixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = 0; c < 3; ++c) {
            const float* values = channels[c]->values.data();
            for (std::size_t i = begin; i < end; ++i) {
                // NaN fails both comparisons of this order and comes out as 0.
                const float held = values[i] > 0 ? (values[i] < 1 ? values[i] : 1.0f) : 0.0f;
                codes[3 * i + c] = static_cast<Code>(std::floor(held * largest + 0.5f));
            }
        }
    });
    return codes;
}

}  // namespace

std::vector<std::uint8_t> to_rgb8(const Image& graded) {
    return to_codes<std::uint8_t>(graded);
}
std::vector<std::uint16_t> to_rgb16(const Image& graded) {
    return to_codes<std::uint16_t>(graded);
}

}  // namespace dapple::image
