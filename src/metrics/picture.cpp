#include "metrics/picture.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <set>

#include "base/error.h"
#include "base/parallel.h"

namespace dapple::metrics {
namespace {

constexpr std::size_t kTilePixels = 1 << 14;

glm::dvec3 xyz_of(glm::dvec2 xy) {
    return {xy.x / xy.y, 1, (1 - xy.x - xy.y) / xy.y};
}

const image::Chromaticities& primaries_of(const image::Image& image) {
    return image.chromaticities ? *image.chromaticities : kRec709;
}

/// Linear RGB of the primaries to XYZ; the columns are the primaries, scaled so that they sum to white.
glm::dmat3 xyz_matrix(const image::Chromaticities& c) {
    const glm::dmat3 primaries(xyz_of(c.red), xyz_of(c.green), xyz_of(c.blue));
    const glm::dvec3 scale = glm::inverse(primaries) * xyz_of(c.white);
    return {primaries[0] * scale.x, primaries[1] * scale.y, primaries[2] * scale.z};
}

/// Bradford's cone responses (ICC.1:2022, annex E).
const glm::dmat3 kBradford =
    glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));

glm::dmat3 adaptation(glm::dvec3 from_white, glm::dvec3 to_white) {
    const glm::dvec3 gain = (kBradford * to_white) / (kBradford * from_white);
    glm::dmat3 diagonal(0);
    for (int i = 0; i < 3; ++i) diagonal[i][i] = gain[i];
    return glm::inverse(kBradford) * diagonal * kBradford;
}

std::string layers_of(const image::Image& image) {
    std::set<std::string> layers;
    for (const image::Channel& channel : image.channels) {
        const std::size_t dot = channel.name.rfind('.');
        layers.insert(dot == std::string::npos ? channel.name : channel.name.substr(0, dot));
    }
    std::string text;
    for (const std::string& layer : layers) text += (text.empty() ? "" : ", ") + layer;
    return clipped(text);
}

void fill_luminance(Picture& picture, const image::Chromaticities& primaries) {
    const glm::dmat3 matrix = xyz_matrix(primaries);
    const glm::vec3 weight(static_cast<float>(matrix[0].y), static_cast<float>(matrix[1].y),
                           static_cast<float>(matrix[2].y));
    picture.luminance.resize(picture.pixels());
    parallel_for(picture.pixels(), kTilePixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            picture.luminance[i] =
                weight.r * picture.rgb[0][i] + weight.g * picture.rgb[1][i] + weight.b * picture.rgb[2][i];
        }
    });
}

void clear(Picture& picture, std::uint32_t pixel) {
    for (std::vector<float>& plane : picture.rgb) plane[pixel] = 0;
    picture.luminance[pixel] = 0;
}

void find_excluded(Picture& picture) {
    for (std::size_t i = 0; i < picture.pixels(); ++i) {
        // The sum of finite floats may overflow, but a NaN or infinity always shows in it.
        if (std::isfinite(picture.rgb[0][i] + picture.rgb[1][i] + picture.rgb[2][i] + picture.luminance[i])) {
            continue;
        }
        picture.excluded.push_back(static_cast<std::uint32_t>(i));
        clear(picture, static_cast<std::uint32_t>(i));
    }
}

}  // namespace

Picture picture_of(const image::Image& image, const std::string& layer, const std::string& name) {
    const std::string prefix = layer.empty() ? "" : layer + ".";
    const image::Channel* channels[3] = {image.find(prefix + "R"), image.find(prefix + "G"),
                                         image.find(prefix + "B")};
    const bool grey = channels[0] == nullptr || channels[1] == nullptr || channels[2] == nullptr;
    if (grey) {
        const image::Channel* single = image.find(layer.empty() ? "Y" : layer);
        if (single == nullptr) {
            throw Error(ExitCode::input_unreadable, name + ": has no layer '" +
                                                        (layer.empty() ? "R, G, B" : clipped(layer)) +
                                                        "'; there are " + layers_of(image));
        }
        std::fill(std::begin(channels), std::end(channels), single);
    }
    Picture picture;
    picture.width = image.width;
    picture.height = image.height;
    for (std::size_t c = 0; c < 3; ++c) picture.rgb[c] = channels[c]->values;
    if (grey) {
        picture.luminance = channels[0]->values;
    } else {
        fill_luminance(picture, primaries_of(image));
    }
    find_excluded(picture);
    return picture;
}

void exclude_together(Picture& a, Picture& b) {
    assert(a.width == b.width && a.height == b.height);
    if (a.excluded == b.excluded) return;
    std::vector<std::uint32_t> either;
    std::ranges::set_union(a.excluded, b.excluded, std::back_inserter(either));
    for (const std::uint32_t pixel : either) {
        clear(a, pixel);
        clear(b, pixel);
    }
    a.excluded = either;
    b.excluded = std::move(either);
}

void to_rec709(Picture& picture, const image::Image& image) {
    change_primaries(picture, primaries_of(image), kRec709);
}

void change_primaries(Picture& picture, const image::Chromaticities& from, const image::Chromaticities& to) {
    if (from == to) return;
    const glm::dmat3 matrix =
        glm::inverse(xyz_matrix(to)) * adaptation(xyz_of(from.white), xyz_of(to.white)) * xyz_matrix(from);
    const glm::mat3 to_from_rgb(matrix);
    parallel_for(picture.pixels(), kTilePixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::vec3 turned =
                to_from_rgb * glm::vec3(picture.rgb[0][i], picture.rgb[1][i], picture.rgb[2][i]);
            for (int c = 0; c < 3; ++c) picture.rgb[static_cast<std::size_t>(c)][i] = turned[c];
        }
    });
}

}  // namespace dapple::metrics
