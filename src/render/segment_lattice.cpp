#include "render/segment_lattice.h"

#include <array>
#include <cstddef>

#include "base/parallel.h"

namespace dapple::render {
namespace {

constexpr std::size_t kTile = 4096;  ///< pixels

/// The pixels of even x and y about a pixel.
struct Neighbors {
    std::array<std::size_t, 4> pixels{};
    std::size_t count = 0;  ///< 0: the picture ends here
};

Neighbors neighbors_of(const view::SegmentLayer& layer, std::size_t pixel) {
    const auto width = static_cast<std::size_t>(layer.width), height = static_cast<std::size_t>(layer.height);
    const std::size_t x = pixel % width, y = pixel / width;
    Neighbors found;
    if (x + x % 2 >= width || y + y % 2 >= height) return found;
    for (std::size_t row = y - y % 2; row <= y + y % 2; row += 2) {
        for (std::size_t column = x - x % 2; column <= x + x % 2; column += 2)
            found.pixels[found.count++] = row * width + column;
    }
    return found;
}

std::size_t pieces(const view::SegmentLayer& layer, std::size_t pixel) {
    return layer.first[pixel + 1] - layer.first[pixel];
}

bool lies_between(const view::SegmentLayer& layer, std::size_t pixel, const Neighbors& neighbors) {
    if (neighbors.count == 0) return false;
    for (std::size_t n = 0; n < neighbors.count; ++n) {
        if (pieces(layer, neighbors.pixels[n]) != pieces(layer, pixel)) return false;
    }
    const auto far_end = [&](std::size_t i) {
        return layer.origin[i] + layer.length[i] * layer.direction[i];
    };
    for (std::size_t piece = 0; piece < pieces(layer, pixel); ++piece) {
        const std::size_t own = layer.first[pixel] + piece;
        glm::vec3 near_ends(0), far_ends(0);
        for (std::size_t n = 0; n < neighbors.count; ++n) {
            const std::size_t other = layer.first[neighbors.pixels[n]] + piece;
            if (layer.in_water[other] != layer.in_water[own]) return false;
            near_ends += layer.origin[other];
            far_ends += far_end(other);
        }
        const float scale = 1.0f / static_cast<float>(neighbors.count);
        const float most = kBetween * layer.length[own];
        if (!(glm::length(scale * near_ends - layer.origin[own]) <= most) ||
            !(glm::length(scale * far_ends - far_end(own)) <= most))
            return false;
    }
    return true;
}

bool on_lattice(const view::SegmentLayer& layer, std::size_t pixel) {
    const auto width = static_cast<std::size_t>(layer.width);
    return pixel % width % 2 == 0 && pixel / width % 2 == 0;
}

std::size_t pixels(const view::SegmentLayer& layer) {
    return layer.first.size() - 1;
}

}  // namespace

std::vector<std::uint8_t> half_resolution_pixels(const view::SegmentLayer& layer) {
    std::vector<std::uint8_t> asked(pixels(layer));
    parallel_for(asked.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t pixel = begin; pixel < end; ++pixel) {
            asked[pixel] =
                on_lattice(layer, pixel) || !lies_between(layer, pixel, neighbors_of(layer, pixel)) ? 1 : 0;
        }
    });
    return asked;
}

view::SegmentLayer segments_of(const view::SegmentLayer& layer, const std::vector<std::uint8_t>& kept) {
    view::SegmentLayer part;
    part.width = layer.width;
    part.height = layer.height;
    part.sample = layer.sample;
    part.branch = layer.branch;
    part.first.push_back(0);
    for (std::size_t pixel = 0; pixel < pixels(layer); ++pixel) {
        const std::size_t count = kept[pixel] ? pieces(layer, pixel) : 0;
        part.first.push_back(part.first.back() + static_cast<std::uint32_t>(count));
    }
    const auto copy = [&](const auto& from, auto& to) {
        to.resize(part.first.back());
        parallel_for(pixels(layer), kTile, [&](std::size_t begin, std::size_t end) {
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                for (std::size_t i = part.first[pixel]; i < part.first[pixel + 1]; ++i)
                    to[i] = from[layer.first[pixel] + (i - part.first[pixel])];
            }
        });
    };
    copy(layer.origin, part.origin);
    copy(layer.direction, part.direction);
    copy(layer.length, part.length);
    copy(layer.in_water, part.in_water);
    copy(layer.primary, part.primary);
    copy(layer.throughput, part.throughput);
    copy(layer.spread_u_origin, part.spread_u_origin);
    copy(layer.spread_u_direction, part.spread_u_direction);
    copy(layer.spread_v_origin, part.spread_v_origin);
    copy(layer.spread_v_direction, part.spread_v_direction);
    return part;
}

SegmentRadiance at_half_resolution(const view::SegmentLayer& layer, const AskSegments& ask) {
    const std::vector<std::uint8_t> asked = half_resolution_pixels(layer);
    const view::SegmentLayer part = segments_of(layer, asked);
    const SegmentRadiance found = ask(part);
    SegmentRadiance all;
    const auto spread = [&](const std::vector<glm::vec3>& from, std::vector<glm::vec3>& to) {
        to.assign(layer.segments(), glm::vec3(0));
        parallel_for(pixels(layer), kTile, [&](std::size_t begin, std::size_t end) {
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                Neighbors sources{{pixel}, 1};
                if (!asked[pixel]) sources = neighbors_of(layer, pixel);
                for (std::size_t piece = 0; piece < pieces(layer, pixel); ++piece) {
                    glm::vec3 sum(0);
                    for (std::size_t n = 0; n < sources.count; ++n)
                        sum += from[part.first[sources.pixels[n]] + piece];
                    to[layer.first[pixel] + piece] = sum / static_cast<float>(sources.count);
                }
            }
        });
    };
    spread(found.direct, all.direct);
    spread(found.caustics, all.caustics);
    return all;
}

}  // namespace dapple::render
