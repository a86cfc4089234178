#include "media/body.h"

#include <algorithm>
#include <limits>

namespace dapple::media {
namespace {

/// The file's z axis, which points up, becomes y.
glm::dmat4 upright() {
    return {{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}};
}

}  // namespace

bool Body::is_empty(const scene::FrameScene& scene, std::size_t medium) {
    const scene::Medium& m = scene.state.media[medium];
    if (!(m.density > 0) || m.extinction == glm::dvec3(0)) return true;
    if (m.side == scene::MediumSide::water && !scene.state.water) return true;
    if (m.type == scene::MediumType::box) return false;
    const auto grid = medium < scene.medium_grids.size() ? scene.medium_grids[medium] : nullptr;
    return !grid || grid->empty() || !(grid->maximum() > 0);
}

Body::Body(const scene::FrameScene& scene, std::size_t medium) {
    const scene::Medium& m = scene.state.media[medium];
    place_.density = m.density;
    glm::dmat4 world_from_local = scene::relative_from_object(m.transform, scene.origin);
    if (m.type == scene::MediumType::box) {
        world_from_local = glm::scale(world_from_local, 0.5 * m.size);
        place_.low = glm::dvec3(-1);
        place_.high = glm::dvec3(1);
    } else {
        grid_.emplace(scene.medium_grids[medium]);
        if (m.z_up) world_from_local *= upright();
        world_from_local *= scene.medium_grids[medium]->file_from_index();
        place_.low = grid_->low();
        place_.high = grid_->high();
    }
    place_.turn = glm::inverse(glm::dmat3(world_from_local));
    place_.shift = -(place_.turn * glm::dvec3(world_from_local[3]));
    least_y_ = std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at =
            glm::mix(place_.low, place_.high, glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2));
        least_y_ = std::min(least_y_, (world_from_local * glm::dvec4(at, 1)).y);
    }
}

Line Body::local(const glm::dvec3& origin, const glm::dvec3& direction) const {
    return {place_.turn * origin + place_.shift, place_.turn * direction};
}

Interval Body::overlap(const glm::dvec3& origin, const glm::dvec3& direction, double length) const {
    return inside_box(local(origin, direction), place_.low, place_.high, {0, length});
}

double Body::column(const glm::dvec3& origin, const glm::dvec3& direction, Interval overlap) const {
    const double in_unit_density =
        grid_ ? grid_->column(local(origin, direction), overlap) : overlap.end - overlap.begin;
    return place_.density * in_unit_density;
}

void Body::append_pieces(const glm::dvec3& origin, const glm::dvec3& direction, Interval overlap,
                         std::vector<Piece>& pieces) const {
    if (!grid_) {
        pieces.push_back({overlap.begin, overlap.end, place_.density, place_.density, place_.density});
        return;
    }
    const std::size_t first = pieces.size();
    grid_->append_pieces(local(origin, direction), overlap, pieces);
    for (std::size_t i = first; i < pieces.size(); ++i) {
        pieces[i].first *= place_.density;
        pieces[i].middle *= place_.density;
        pieces[i].last *= place_.density;
    }
}

double Body::density(const glm::dvec3& position) const {
    const glm::dvec3 at = place_.turn * position + place_.shift;
    if (!(glm::all(glm::greaterThanEqual(at, place_.low)) && glm::all(glm::lessThanEqual(at, place_.high))))
        return 0;
    return place_.density * (grid_ ? grid_->density(at) : 1);
}

}  // namespace dapple::media
