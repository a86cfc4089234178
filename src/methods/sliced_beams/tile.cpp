#include "methods/sliced_beams/tile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dapple::methods::sliced_beams {
namespace {

template <class Real>
Bounds bounds_of(const Box<Real>& box, Real low, Real high) {
    return {glm::dvec3(box.low_a, box.low_b, low), glm::dvec3(box.high_a, box.high_b, high)};
}

}  // namespace

template <class Real>
Tile<Real>::Tile(const SheetCoverage<Real>& sheet, std::span<const Receiver<Real>> receivers,
                 std::uint32_t object, std::span<Vec3<Real>> irradiance, QueryCounts& counts,
                 std::span<std::uint8_t> hidden)
    : sheet_(sheet),
      pyramid_(*sheet.pyramid_),
      irradiance_(irradiance),
      counts_(counts),
      hidden_(hidden),
      object_(object) {
    place_receivers(receivers);
}

template <class Real>
void Tile<Real>::place_receivers(std::span<const Receiver<Real>> receivers) {
    constexpr Real infinity = std::numeric_limits<Real>::infinity();
    bounds_ = {infinity, -infinity, infinity, -infinity};
    low_ = infinity;
    high_ = -infinity;
    least_a_ = least_b_ = infinity;
    locals_.reserve(receivers.size());
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        Local local{sheet_.in_sheet(receivers[i]), 0, 0, 0, 0, i, 1};
        const Receiver<Real>& r = local.receiver;
        const Real area = glm::length(glm::cross(r.u, r.v));
        if (!(area > 0) || !std::isfinite(area)) continue;
        local.inverse_area = 1 / area;
        local.narrow =
            static_cast<double>(glm::length(glm::cross(receivers[i].u, receivers[i].v)) * local.inverse_area);
        const Vec3<Real> half = Real(0.5) * (glm::abs(r.u) + glm::abs(r.v));
        local.half_a = half.x;
        local.half_b = half.y;
        local.half_depth = half.z;
        if (r.position.z + half.z < pyramid_.nearest()) continue;  // before the water
        bounds_.low_a = std::min(bounds_.low_a, r.position.x - half.x);
        bounds_.high_a = std::max(bounds_.high_a, r.position.x + half.x);
        bounds_.low_b = std::min(bounds_.low_b, r.position.y - half.y);
        bounds_.high_b = std::max(bounds_.high_b, r.position.y + half.y);
        low_ = std::min(low_, r.position.z - half.z);
        high_ = std::max(high_, r.position.z + half.z);
        least_a_ = std::min(least_a_, 2 * half.x);
        least_b_ = std::min(least_b_, 2 * half.y);
        lean_ = std::max(lean_, sheet_.lean(r.normal));
        locals_.push_back(local);
    }
    planar_ = !locals_.empty() && share_a_plane();
}

template <class Real>
typename Tile<Real>::Meets Tile<Real>::meets(NodeId node, const Receiver<Real>& receiver, Real high) const {
    const Meets meets = pyramid_.meets(node, receiver.position, receiver.normal);
    // No receiver lies beyond the farthest depth, but the rim of its footprint may.
    return meets == Meets::none && high > pyramid_.farthest() ? Meets::some : meets;
}

template <class Real>
Box<Real> Tile<Real>::box(NodeId node, const Receiver<Real>& receiver, Real low, Real high) const {
    constexpr Real infinity = std::numeric_limits<Real>::infinity();
    const Meets meets = this->meets(node, receiver, high);
    if (meets == Meets::none) return {infinity, -infinity, infinity, -infinity};
    return pyramid_.box(node, low, high, meets == Meets::all ? Real(0) : lean_);
}

template <class Real>
bool Tile<Real>::find() {
    if (locals_.empty()) return false;
    // Every ray meets the front of every receiver's plane.
    const bool facing = std::all_of(locals_.begin(), locals_.end(), [&](const Local& local) {
        const Vec3<Real>& n = local.receiver.normal;
        return std::abs(n.x) * sheet_.steepest_a_ + std::abs(n.y) * sheet_.steepest_b_ < Real(-0.99) * n.z;
    });
    // Bounded media dim beams each by its own way.
    whole_allowed_ = facing && sheet_.columns().empty();
    find_nodes(false);
    if (clusters_.empty() && nodes_.empty()) return false;
    if (!test_free()) {
        ++counts_.occluded_tiles;
        find_nodes(true);
    }
    counts_.clusters += clusters_.size();
    count_parted();
    return true;
}

/// With `occluders` every node is asked whether something can stand in the light of its own beams, until it
/// is not: only what is left is opened and tested beam by beam.
template <class Real>
void Tile<Real>::find_nodes(bool occluders) {
    struct Open {
        NodeId node;
        Shade shade;
        bool lands;  ///< all its beams land on the receivers' plane, as far as is known
    };
    clusters_.clear();
    shade_.clear();
    nodes_.clear();
    below_surface_ = true;
    std::vector<Open> open{{pyramid_.root(), {occluders && !free_after_, occluders && !free_before_}, false}};
    while (!open.empty()) {
        const NodeId node = open.back().node;
        Shade shade = open.back().shade;
        bool lands = open.back().lands;
        open.pop_back();
        if (pyramid_.dark(node) || pyramid_.sums(node).first_start > high_) continue;
        if (planar_ && !lands) {
            const Meets meets = this->meets(node, locals_.front().receiver, high_);
            if (meets == Meets::none) continue;
            lands = meets == Meets::all;
        }
        const Box<Real> box = pyramid_.box(node, low_, high_, lands ? Real(0) : lean_);
        if (!overlap(box, bounds_)) continue;
        const bool below = pyramid_.sums(node).last_start < low_;
        below_surface_ = below_surface_ && (below || node.level > 0);
        if (shade.any()) {
            Bounds surface[2];
            widen_by_surface(node, surface);
            shade.after = shade.after && !free_after(surface);
            shade.before = shade.before && !sheet_.occluders_.free_before_water(surface[1]);
        }
        if (node.level == 0) {
            clusters_.push_back(node);
            shade_.push_back(shade);
        } else if (whole_allowed_ && !shade.any() && below && 2 * (box.high_a - box.low_a) < least_a_ &&
                   2 * (box.high_b - box.low_b) < least_b_) {
            nodes_.push_back(node);
        } else {
            pyramid_.visit_children(node, [&](NodeId child) { open.push_back({child, shade, lands}); });
        }
    }
}

/// Where the node's beams leave the water, in the sheet's axes and in the world's.
template <class Real>
void Tile<Real>::widen_by_surface(NodeId node, Bounds (&surface)[2]) const {
    const auto& sums = pyramid_.sums(node);
    const Box<Real> box = pyramid_.box(node, sums.first_start, sums.last_start);
    const Bounds part = bounds_of(box, sums.first_start, sums.last_start);
    for (int i = 0; i < 8; ++i) {
        surface[0].widen(part.corner(i));
        surface[1].widen(sheet_.sheet_.world_from_mesh * part.corner(i));
    }
}

template <class Real>
bool Tile<Real>::free_after(const Bounds (&surface)[2]) const {
    return sheet_.occluders_.free_after_water(surface, receivers_, may_hide_itself_ ? kNoObject : object_);
}

/// Whether the light volume between the water and the receivers, and that before the water, are free of
/// objects.
template <class Real>
bool Tile<Real>::test_free() {
    Bounds surface[2];
    for (const std::vector<NodeId>* nodes : {&clusters_, &nodes_})
        for (const NodeId node : *nodes) widen_by_surface(node, surface);
    for (const Local& local : locals_) {
        const Receiver<Real>& r = local.receiver;
        for (const Real i : {Real(-0.5), Real(0.5)}) {
            for (const Real j : {Real(-0.5), Real(0.5)}) {
                const glm::dvec3 corner(r.position + i * r.u + j * r.v);
                receivers_[0].widen(corner);
                receivers_[1].widen(sheet_.sheet_.world_from_mesh * corner);
            }
        }
    }
    may_hide_itself_ = std::any_of(locals_.begin(), locals_.end(), [&](const Local& local) {
        return sheet_.occluders_.may_hide_itself(
            object_, sheet_.sheet_.world_from_mesh * glm::dvec3(local.receiver.position),
            sheet_.sheet_.world_from_mesh * glm::dvec3(local.receiver.normal));
    });
    free_after_ = free_after(surface);
    free_before_ = sheet_.occluders_.free_before_water(surface[1]);
    return free_after_ && free_before_;
}

/// Whether the receivers share one plane, to within the rounding of their positions.
template <class Real>
bool Tile<Real>::share_a_plane() const {
    const Receiver<Real>& first = locals_.front().receiver;
    constexpr Real rounding = Real(16) * std::numeric_limits<Real>::epsilon();
    const auto out_of_plane = [&](const Vec3<Real>& v) { return std::abs(glm::dot(v, first.normal)); };
    return std::all_of(locals_.begin(), locals_.end(), [&](const Local& local) {
        const Receiver<Real>& r = local.receiver;
        const Real size = std::max({std::abs(r.position.x), std::abs(r.position.y), std::abs(r.position.z)});
        return glm::dot(r.normal, first.normal) > 0 &&
               out_of_plane(r.position - first.position) <= rounding * size &&
               out_of_plane(r.u) <= Real(1e-5) * glm::length(r.u) &&
               out_of_plane(r.v) <= Real(1e-5) * glm::length(r.v);
    });
}

template class Tile<float>;
template class Tile<double>;

}  // namespace dapple::methods::sliced_beams
