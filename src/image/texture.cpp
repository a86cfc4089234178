#include "image/texture.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/checked_file.h"
#include "base/error.h"
#include "base/parallel.h"
#include "image/exr.h"
#include "image/png.h"

namespace dapple::image {
namespace {

constexpr std::size_t kTileRows = 16;

bool starts_with(std::span<const std::byte> bytes, std::initializer_list<unsigned char> magic) {
    return bytes.size() >= magic.size() &&
           std::ranges::equal(magic, bytes.first(magic.size()), {}, {},
                              [](std::byte b) { return std::to_integer<unsigned char>(b); });
}

Texture from_exr(const Image& picture, const std::string& path) {
    const Channel* grey = picture.find("Y");
    const Channel* sources[3] = {picture.find("R"), picture.find("G"), picture.find("B")};
    if (sources[0] == nullptr && sources[1] == nullptr && sources[2] == nullptr)
        std::ranges::fill(sources, grey);
    for (const Channel* source : sources) {
        if (source == nullptr) {
            throw Error(ExitCode::input_unreadable,
                        path + ": an EXR texture needs channels R, G and B, or Y");
        }
        if (!std::ranges::all_of(source->values, [](float value) { return std::isfinite(value); })) {
            throw Error(ExitCode::input_unreadable,
                        path + ": channel " + source->name + " of the texture holds NaN or infinity");
        }
    }
    std::vector<float> rgb(3 * picture.pixels());
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = sources[i % 3]->values[i / 3];
    return {picture.width, picture.height, std::move(rgb)};
}

/// Which texels of the finer row lie under coarse texel `index`, and the shares of their length that do.
struct Cover {
    int first = 0;
    int count = 0;
    float weights[3] = {};
};

/// `finer` texels become `coarser` = max(1, finer / 2), so each covers 1, 2 or up to 3 of them.
Cover cover_of(int index, int finer, int coarser) {
    const double ratio = static_cast<double>(finer) / coarser;
    const double begin = index * ratio;
    const double end = (index + 1) * ratio;
    Cover cover;
    cover.first = static_cast<int>(begin);
    for (int texel = cover.first; texel < finer && cover.count < 3; ++texel) {
        const double share = std::min(end, texel + 1.0) - std::max(begin, static_cast<double>(texel));
        if (share <= 0) break;
        cover.weights[cover.count++] = static_cast<float>(share / ratio);
    }
    return cover;
}

int wrapped(int index, int size) {
    const int rest = index % size;
    return rest < 0 ? rest + size : rest;
}

}  // namespace

Texture Texture::load(const std::string& path, const ToLinear& to_linear) {
    const std::vector<std::byte> bytes = read_whole_file(path);
    if (starts_with(bytes, {0x76, 0x2f, 0x31, 0x01})) return from_exr(decode_exr(bytes, path), path);
    if (starts_with(bytes, {0x89, 'P', 'N', 'G'})) {
        CodeValues picture = decode_png(bytes, path);
        to_linear(picture.rgb);
        return {picture.width, picture.height, std::move(picture.rgb)};
    }
    throw Error(ExitCode::input_unreadable, path + ": a texture is an EXR or a PNG file, which this is not");
}

Texture::Texture(int width, int height, std::vector<float> rgb) {
    assert(width > 0 && height > 0);
    assert(rgb.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    levels_.push_back({width, height, std::move(rgb)});
    while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(halved(levels_.back()));
}

Texture::Level Texture::halved(const Level& finer) {
    Level level{std::max(1, finer.width / 2), std::max(1, finer.height / 2), {}};
    const auto width = static_cast<std::size_t>(level.width);
    level.rgb.resize(3 * width * static_cast<std::size_t>(level.height));
    std::vector<Cover> columns(width);
    for (int x = 0; x < level.width; ++x) {
        columns[static_cast<std::size_t>(x)] = cover_of(x, finer.width, level.width);
    }

    parallel_for(static_cast<std::size_t>(level.height), kTileRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            const Cover rows = cover_of(static_cast<int>(y), finer.height, level.height);
            for (std::size_t x = 0; x < width; ++x) {
                const Cover& column = columns[x];
                glm::vec3 sum(0);
                for (int j = 0; j < rows.count; ++j) {
                    for (int i = 0; i < column.count; ++i) {
                        const int texel = (rows.first + j) * finer.width + column.first + i;
                        const float* from = finer.rgb.data() + 3 * static_cast<std::size_t>(texel);
                        sum += rows.weights[j] * column.weights[i] * glm::vec3(from[0], from[1], from[2]);
                    }
                }
                for (int c = 0; c < 3; ++c)
                    level.rgb[3 * (y * width + x) + static_cast<std::size_t>(c)] = sum[c];
            }
        }
    });
    return level;
}

glm::vec3 Texture::bilinear(const Level& level, glm::vec2 uv) {
    // The whole repeats are taken off first: what is left keeps its digits far from the origin too.
    const float x = (uv.x - std::floor(uv.x)) * static_cast<float>(level.width) - 0.5f;
    const float y = (1 - (uv.y - std::floor(uv.y))) * static_cast<float>(level.height) - 0.5f;
    const int left = static_cast<int>(std::floor(x));
    const int top = static_cast<int>(std::floor(y));
    const float right_share = x - static_cast<float>(left);
    const float bottom_share = y - static_cast<float>(top);
    const auto texel = [&](int column, int row) {
        const int index = wrapped(row, level.height) * level.width + wrapped(column, level.width);
        const float* from = level.rgb.data() + 3 * static_cast<std::size_t>(index);
        return glm::vec3(from[0], from[1], from[2]);
    };
    return glm::mix(glm::mix(texel(left, top), texel(left + 1, top), right_share),
                    glm::mix(texel(left, top + 1), texel(left + 1, top + 1), right_share), bottom_share);
}

/// Between the two levels whose texels are about as wide as the footprint; `lookup` is bilinear.
template <class Lookup>
glm::vec3 Texture::trilinear(float uv_width, const Lookup& lookup) const {
    const float texels = uv_width * static_cast<float>(std::max(width(), height()));
    const float coarsest = static_cast<float>(levels_.size() - 1);
    // Not (texels <= 1), so that a footprint of NaN takes the sharp picture instead of a level that does not
    // exist.
    const float level = texels > 1 ? std::min(std::log2(texels), coarsest) : 0.0f;
    const auto finer = static_cast<std::size_t>(level);
    const float share = level - static_cast<float>(finer);
    const glm::vec3 value = lookup(levels_[finer]);
    return share > 0 ? glm::mix(value, lookup(levels_[finer + 1]), share) : value;
}

glm::vec3 Texture::sample(glm::vec2 uv, float uv_width) const {
    return trilinear(uv_width, [&](const Level& level) { return bilinear(level, uv); });
}

glm::vec3 Texture::sample_once(glm::vec2 uv, float uv_width) const {
    return trilinear(uv_width, [&](const Level& level) {
        // Between the middles of the outermost texels nothing is repeated.
        const glm::vec2 half = 0.5f / glm::vec2(level.width, level.height);
        return bilinear(level, glm::clamp(uv, half, 1.0f - half));
    });
}

}  // namespace dapple::image
