#include "render/sun_depths.h"

#include <algorithm>
#include <limits>

#include "base/parallel.h"

namespace dapple::render {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kMostPoints = 1 << 22;  ///< 16 MiB
constexpr double kVoxelShare = 0.5;

/// Integral of a piece's density from where it begins to `t`, by its values at the ends and in the middle.
double column_to(const media::Piece& piece, double t) {
    const double x = (t - piece.begin) / (piece.end - piece.begin);
    const double slope = 4 * piece.middle - 3 * piece.first - piece.last;
    const double bend = 2 * (piece.first + piece.last - 2 * piece.middle);
    return (t - piece.begin) * (piece.first + x * (0.5 * slope + x * bend / 3));
}

}  // namespace

SunDepths::SunDepths(const media::Media& media, const glm::dvec3& travel) : media_(media), to_sun_(-travel) {
    const glm::dvec3 other = std::abs(travel.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(other, travel));
    axes_ = glm::transpose(glm::dmat3(u, glm::cross(travel, u), to_sun_));
    for (const media::Part& part : media.parts()) {
        if (!part.in_air) continue;
        if (!part.body.is_grid()) {
            boxes_.push_back(&part);
            continue;
        }
        const media::Body::Place& place = part.body.place();
        const glm::dmat3 world_from_index = glm::inverse(place.turn);
        Lattice& lattice = lattices_.emplace_back();
        lattice.extinction = media.components()[part.component].extinction;
        lattice.spacing =
            kVoxelShare * std::min({glm::length(world_from_index[0]), glm::length(world_from_index[1]),
                                    glm::length(world_from_index[2])});
        glm::dvec3 low(kFar), high(-kFar);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 index =
                glm::mix(place.low, place.high, glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2));
            const glm::dvec3 at = axes_ * (world_from_index * (index - place.shift));
            low = glm::min(low, at);
            high = glm::max(high, at);
        }
        const glm::dvec3 size = glm::ceil((high - low) / lattice.spacing) + 1.0;
        if (!(size.x * size.y * size.z <= kMostPoints)) {
            fits_ = false;
            return;
        }
        lattice.first = low;
        lattice.size = glm::ivec3(size);
        fill(part.body, lattice);
    }
}

void SunDepths::fill(const media::Body& body, Lattice& lattice) const {
    const auto rays = static_cast<std::size_t>(lattice.size.x) * static_cast<std::size_t>(lattice.size.y);
    const auto points = static_cast<std::size_t>(lattice.size.z);
    lattice.column.assign(rays * points, 0.0f);
    const glm::dmat3 world_from_axes = glm::transpose(axes_);
    constexpr std::size_t kTile = 64;
    parallel_for(rays, kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<media::Piece> pieces;
        for (std::size_t ray = begin; ray < end; ++ray) {
            const auto across = static_cast<std::size_t>(lattice.size.x);
            const glm::dvec2 place(ray % across, ray / across);
            const glm::dvec3 from =
                world_from_axes * (lattice.first + lattice.spacing * glm::dvec3(place, 0));
            const double length = lattice.spacing * static_cast<double>(points);
            const media::Interval overlap = body.overlap(from, to_sun_, length);
            if (overlap.empty()) continue;
            pieces.clear();
            body.append_pieces(from, to_sun_, overlap, pieces);
            // Back from the sun.
            double beyond = 0;  // of the pieces after the current one
            auto piece = pieces.rbegin();
            for (std::size_t k = points; k-- > 0;) {
                const double at = lattice.spacing * static_cast<double>(k);
                for (; piece != pieces.rend() && piece->begin >= at; ++piece) beyond += piece->column();
                const bool inside = piece != pieces.rend() && piece->end > at;
                const double part = inside ? piece->column() - column_to(*piece, at) : 0;
                lattice.column[ray * points + k] = static_cast<float>(beyond + part);
            }
        }
    });
}

glm::dvec3 SunDepths::depth(const glm::dvec3& at) const {
    glm::dvec3 sum(0);
    for (const Lattice& lattice : lattices_) sum += column(lattice, at) * lattice.extinction;
    for (const media::Part* part : boxes_) {
        const media::Interval overlap = part->body.overlap(at, to_sun_, kFar);
        if (!overlap.empty())
            sum += part->body.column(at, to_sun_, overlap) * media_.components()[part->component].extinction;
    }
    return sum;
}

double SunDepths::column(const Lattice& lattice, const glm::dvec3& at) const {
    glm::dvec3 place = (axes_ * at - lattice.first) / lattice.spacing;
    const glm::dvec3 last(lattice.size - 1);
    if (place.x < 0 || place.y < 0 || place.x > last.x || place.y > last.y || place.z > last.z) return 0;
    place.z = std::max(place.z, 0.0);  // farther from the sun than all of it
    const glm::ivec3 cell = glm::min(glm::ivec3(place), lattice.size - 2);
    const glm::dvec3 t = place - glm::dvec3(cell);
    const auto points = static_cast<std::size_t>(lattice.size.z);
    const std::size_t ray = static_cast<std::size_t>(cell.y) * static_cast<std::size_t>(lattice.size.x) +
                            static_cast<std::size_t>(cell.x);
    const float* near = lattice.column.data() + ray * points + static_cast<std::size_t>(cell.z);
    const float* far = near + static_cast<std::size_t>(lattice.size.x) * points;
    const auto along = [&](const float* from) {
        return glm::mix(static_cast<double>(from[0]), static_cast<double>(from[1]), t.z);
    };
    return glm::mix(glm::mix(along(near), along(near + points), t.x),
                    glm::mix(along(far), along(far + points), t.x), t.y);
}

}  // namespace dapple::render
