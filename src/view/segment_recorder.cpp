#include "view/segment_recorder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace dapple::view {
namespace {

constexpr std::size_t kTilesAtOnce = 4;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// m after which a homogeneous medium lets through kLeastTransmittance of the least extinct of the channels
/// that count.
double sight(const glm::dvec3& extinction, glm::bvec3 counts) {
    double farthest = 0;
    for (int channel = 0; channel < 3; ++channel) {
        if (!counts[channel]) continue;
        const double sigma = extinction[channel];
        if (sigma == 0) return kInfinity;
        farthest = std::max(farthest, -std::log(kLeastTransmittance) / sigma);
    }
    return farthest;
}

/// m along an endless ray after which it meets no box, a thousandth too far at most. Whether what is left of
/// the ray beyond a place meets one can only change from yes to no, so halving finds the change.
double end_of_boxes(const media::Media& media, const PathPiece& piece) {
    const auto meets_beyond = [&](double place) {
        return media.may_meet(piece.origin + place * piece.direction, piece.direction, kInfinity,
                              piece.in_water);
    };
    double low = 0, high = 1;
    while (meets_beyond(high)) {
        low = high;
        high *= 2;
    }
    while (high - low > 1e-3 * high) {
        const double middle = 0.5 * (low + high);
        (meets_beyond(middle) ? low : high) = middle;
    }
    return high;
}

}  // namespace

SegmentRecorder::SegmentRecorder(const media::Media& media, std::size_t tiles)
    : media_(media), pieces_(tiles) {}

double SegmentRecorder::farthest(const PathPiece& piece) const {
    if (!media_.scatters(piece.in_water)) return 0;
    const media::Component& water = media_.components().front();
    const glm::dvec3 extinction = piece.in_water ? water.extinction : glm::dvec3(0);
    double place =
        piece.in_water ? sight(extinction, glm::greaterThan(water.scattering, glm::dvec3(0))) : 0.0;
    if (media_.bounded(piece.in_water) &&
        media_.may_meet(piece.origin, piece.direction, piece.length, piece.in_water)) {
        double boxes = std::min(piece.length, sight(extinction, glm::bvec3(true)));
        if (std::isinf(boxes)) boxes = end_of_boxes(media_, piece);
        place = std::max(place, boxes);
    }
    return place;
}

void SegmentRecorder::record(std::size_t tile, const PathPiece& piece) {
    if (piece.throughput == glm::dvec3(0)) return;
    const double length = std::min(piece.length, farthest(piece));
    if (!(length > 0)) return;
    pieces_[tile].push_back({static_cast<std::uint32_t>(piece.pixel), static_cast<float>(length),
                             static_cast<std::uint8_t>(piece.in_water),
                             static_cast<std::uint8_t>(piece.primary), glm::vec3(piece.origin),
                             glm::vec3(piece.direction), glm::vec3(piece.throughput),
                             glm::vec3(piece.origin_du), glm::vec3(piece.direction_du),
                             glm::vec3(piece.origin_dv), glm::vec3(piece.direction_dv)});
}

void SegmentRecorder::write(int width, int height, SegmentLayer& layer) const {
    layer.width = width;
    layer.height = height;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    layer.first.assign(pixels + 1, 0);
    // Tiles share no pixel.
    const auto visit_pieces = [&](auto&& visit) {
        parallel_for(pieces_.size(), kTilesAtOnce, [&](std::size_t begin, std::size_t end) {
            for (std::size_t tile = begin; tile < end; ++tile)
                for (const Kept& piece : pieces_[tile]) visit(piece);
        });
    };
    visit_pieces([&](const Kept& piece) { ++layer.first[piece.pixel + 1]; });
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) layer.first[pixel + 1] += layer.first[pixel];

    const std::size_t count = layer.first.back();
    for (auto* vectors : {&layer.origin, &layer.direction, &layer.throughput, &layer.spread_u_origin,
                          &layer.spread_u_direction, &layer.spread_v_origin, &layer.spread_v_direction}) {
        vectors->resize(count);
    }
    layer.length.resize(count);
    layer.in_water.resize(count);
    layer.primary.resize(count);
    std::vector<std::uint32_t> next(layer.first.begin(), layer.first.end() - 1);
    visit_pieces([&](const Kept& piece) {
        const std::size_t i = next[piece.pixel]++;
        layer.origin[i] = piece.origin;
        layer.direction[i] = piece.direction;
        layer.length[i] = piece.length;
        layer.in_water[i] = piece.in_water;
        layer.primary[i] = piece.primary;
        layer.throughput[i] = piece.throughput;
        layer.spread_u_origin[i] = piece.spread_u_origin;
        layer.spread_u_direction[i] = piece.spread_u_direction;
        layer.spread_v_origin[i] = piece.spread_v_origin;
        layer.spread_v_direction[i] = piece.spread_v_direction;
    });
}

}  // namespace dapple::view
