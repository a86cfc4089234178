// What a tile's receivers get of the nodes that were found for them (tile.cpp).
#include <algorithm>
#include <cmath>
#include <limits>

#include "methods/sliced_beams/tile.h"

namespace dapple::methods::sliced_beams {
namespace {

constexpr std::size_t kPairsAtOnce = 4096;
/// Landed at one go: some 2 MB. A tile that looks along the water may find millions.
constexpr std::size_t kClustersAtOnce = 4096;
/// A curved tile that finds more than this looks along its receivers' planes.
constexpr std::size_t kManyClusters = 128;

}  // namespace

template <class Real>
void Tile<Real>::cover() {
    if (planar())
        add_planar();
    else
        add_curved();
    settle_pairs();
}

template <class Real>
void Tile<Real>::land_cluster(NodeId node, const LandingFrame<Real>& frame, LitCluster<Real>& lit) {
    ClusterRays<Real> rays;
    load(sheet_.sheet_, sheet_.triangles(), pyramid_.beams(node), rays);
    lit.beam = rays.beam;
    lit.dimmed = std::any_of(rays.beam.begin(), rays.beam.end(), [&](std::uint32_t beam) {
        return beam != kNoBeam && sheet_.columns().dims(beam);
    });
    lit.cut_by_surface = false;
    const auto tinted = [&](int chunk, int channel, Lanes<Real> flux) {
        if (sheet_.sheet_.tint.empty()) return flux;
        for (int lane = 0; lane < kLanes<Real>; ++lane) {
            const std::uint32_t beam =
                rays.beam[static_cast<std::size_t>(chunk) * kLanes<Real> + static_cast<std::size_t>(lane)];
            if (beam != kNoBeam) flux[lane] *= sheet_.sheet_.tint[beam][channel];
        }
        return flux;
    };
    for (int c = 0; c < kChunks<Real>; ++c) {
        LandedChunk<Real>& landed = lit.landed[c];
        land(rays, c, frame, landed);
        Lanes<Real> flux = landed.lands ? rays.flux[c] : Lanes<Real>{};
        if (!below_surface_) {
            const auto wet =
                (landed.past_start[0] >= 0) | (landed.past_start[1] >= 0) | (landed.past_start[2] >= 0);
            const auto whole =
                (landed.past_start[0] >= 0) & (landed.past_start[1] >= 0) & (landed.past_start[2] >= 0);
            flux = wet ? flux : Lanes<Real>{};
            lit.cut_by_surface |= any(wet & ~whole & landed.lands);
        }
        const Lanes<Real> way = greater(landed.way, Lanes<Real>{});
        const glm::vec<3, Real> color(sheet_.sheet_.color), extinction(sheet_.extinction_);
        const auto colored = [&](int channel) {
            const Lanes<Real> lossless = color[channel] * tinted(c, channel, flux);
            return extinction[channel] > 0 ? lossless * decay(extinction[channel] * way) : lossless;
        };
        lit.red[c] = colored(0);
        lit.green[c] = colored(1);
        lit.blue[c] = colored(2);
    }
}

template <class Real>
typename Tile<Real>::LandedTile Tile<Real>::land_all(std::size_t first, std::size_t count,
                                                     const LandingFrame<Real>& frame) {
    constexpr Real infinity = std::numeric_limits<Real>::infinity();
    LandedTile tile;
    tile.clusters.resize(count);
    const std::size_t padded =
        (count + kClusterBeams - 1) / kClusterBeams * static_cast<std::size_t>(kClusterBeams);
    tile.low_x.assign(padded, infinity);
    tile.low_y.assign(padded, infinity);
    tile.high_x.assign(padded, -infinity);
    tile.high_y.assign(padded, -infinity);
    for (std::size_t i = 0; i < count; ++i) {
        LitCluster<Real>& lit = tile.clusters[i];
        land_cluster(clusters_[first + i], frame, lit);
        lit.shade = shade_[first + i];
        for (int c = 0; c < kChunks<Real>; ++c) {
            for (int lane = 0; lane < kLanes<Real>; ++lane) {
                if (!lit.landed[c].lands[lane]) continue;
                for (int k = 0; k < 3; ++k) {
                    const Real x = lit.landed[c].beams.x[k][lane], y = lit.landed[c].beams.y[k][lane];
                    tile.low_x[i] = std::min(tile.low_x[i], x);
                    tile.high_x[i] = std::max(tile.high_x[i], x);
                    tile.low_y[i] = std::min(tile.low_y[i], y);
                    tile.high_y[i] = std::max(tile.high_y[i], y);
                }
            }
        }
    }
    return tile;
}

template <class Real>
void Tile<Real>::add_planar() {
    const LandingFrame<Real> frame(locals_.front().receiver);
    for (std::size_t part = 0; part < clusters_.size(); part += kClustersAtOnce)
        add_landed(land_all(part, std::min(kClustersAtOnce, clusters_.size() - part), frame), frame);
    if (nodes_.empty()) return;
    for (const Local& local : locals_) add_nodes(local);
}

/// Light of clusters that are landed on the receivers' common plane.
template <class Real>
void Tile<Real>::add_landed(const LandedTile& tile, const LandingFrame<Real>& frame) {
    for (const Local& local : locals_) {
        const PlaneMove<Real> move(frame, local.receiver);
        const Real low_x = move.centre.x - move.half_x, high_x = move.centre.x + move.half_x;
        const Real low_y = move.centre.y - move.half_y, high_y = move.centre.y + move.half_y;
        Lanes<Real> power[3] = {};
        for (std::size_t i = 0; i < tile.low_x.size(); i += static_cast<std::size_t>(kLanes<Real>)) {
            const auto load_lanes = [i](const std::vector<Real>& values) {
                Lanes<Real> lanes;
                std::copy_n(values.data() + i, kLanes<Real>, reinterpret_cast<Real*>(&lanes));
                return lanes;
            };
            unsigned met = bits((load_lanes(tile.low_x) <= high_x) & (load_lanes(tile.high_x) >= low_x) &
                                (load_lanes(tile.low_y) <= high_y) & (load_lanes(tile.high_y) >= low_y));
            for (; met != 0; met &= met - 1)
                add_cluster(local, tile.clusters[i + static_cast<std::size_t>(__builtin_ctz(met))], power,
                            move);
        }
        irradiance_[local.index] +=
            local.inverse_area * Vec3<Real>(sum(power[0]), sum(power[1]), sum(power[2]));
    }
}

template <class Real>
void Tile<Real>::add_curved() {
    std::vector<Box<Real>> boxes(clusters_.size());
    for (std::size_t i = 0; i < clusters_.size(); ++i) boxes[i] = box(clusters_[i]);
    // On planes that lean much: there it pays to ask for the receiver's own depths and plane.
    const bool many = clusters_.size() > kManyClusters;
    for (const Local& local : locals_) {
        const Receiver<Real>& r = local.receiver;
        const LandingFrame<Real> frame(r);
        const Box<Real> own{r.position.x - local.half_a, r.position.x + local.half_a,
                            r.position.y - local.half_b, r.position.y + local.half_b};
        const auto box_at = [&](NodeId node) {
            return box(node, r, r.position.z - local.half_depth, r.position.z + local.half_depth);
        };
        Lanes<Real> power[3] = {};
        for (std::size_t i = 0; i < clusters_.size(); ++i) {
            if (!overlap(boxes[i], own) || (many && !overlap(box_at(clusters_[i]), own))) continue;
            LitCluster<Real> lit;
            land_cluster(clusters_[i], frame, lit);
            lit.shade = shade_[i];
            add_cluster(local, lit, power, [](const LandedBeams<Real>& landed) { return landed; });
        }
        irradiance_[local.index] +=
            local.inverse_area * Vec3<Real>(sum(power[0]), sum(power[1]), sum(power[2]));
        if (!nodes_.empty()) add_nodes(local);
    }
}

template <class Real>
template <class At>
void Tile<Real>::add_cluster(const Local& local, const LitCluster<Real>& lit, Lanes<Real> (&power)[3],
                             At&& at) {
    for (int c = 0; c < kChunks<Real>; ++c) {
        const LandedBeams<Real> beams = at(lit.landed[c].beams);
        const Mask<Real> met = may_meet_square(beams) & lit.landed[c].lands;
        if (!any(met)) continue;
        Lanes<Real> share = covered_share(beams);
        share = met ? share : Lanes<Real>{};
        if (lit.cut_by_surface || lit.shade.any() || lit.dimmed) {
            unsigned lanes = bits(share > 0);
            for (; lanes != 0; lanes &= lanes - 1) {
                const int lane = __builtin_ctz(lanes);
                add_pair(local, lit, c, lane, beams, share[lane], lit.cut_by_surface);
            }
            continue;
        }
        power[0] += share * lit.red[c];
        power[1] += share * lit.green[c];
        power[2] += share * lit.blue[c];
    }
}

template <class Real>
void Tile<Real>::add_pair(const Local& local, const LitCluster<Real>& lit, int chunk, int lane,
                          const LandedBeams<Real>& beams, Real share, bool clipped) {
    Real x[3], y[3], past[3];
    for (int k = 0; k < 3; ++k) {
        x[k] = beams.x[k][lane];
        y[k] = beams.y[k][lane];
        past[k] = clipped ? lit.landed[chunk].past_start[k][lane] : Real(1);
    }
    const ClippedBeam<Real> part = clip_beam(x, y, past);
    // Without a surface in its way the share by edges is the better one.
    const bool whole = past[0] >= 0 && past[1] >= 0 && past[2] >= 0;
    const Real scale = local.inverse_area * (whole ? share : std::min(share, part.share));
    Vec3<Real> irradiance =
        scale * Vec3<Real>(lit.red[chunk][lane], lit.green[chunk][lane], lit.blue[chunk][lane]);
    if (!(irradiance.x + irradiance.y + irradiance.z > 0)) return;
    const Receiver<Real>& r = local.receiver;
    Vec3<Real> water(0), landed = r.position;
    const std::uint32_t beam =
        lit.beam[static_cast<std::size_t>(chunk) * kLanes<Real> + static_cast<std::size_t>(lane)];
    // A beam landed on a line: its middle.
    const bool empty = part.weights[0] + part.weights[1] + part.weights[2] == 0;
    if (lit.dimmed && sheet_.columns().dims(beam)) {
        const glm::dvec3 weights =
            empty ? glm::dvec3(1.0 / 3) : glm::dvec3(part.weights[0], part.weights[1], part.weights[2]);
        double below = 0;  // m along the axis
        for (int k = 0; k < 3; ++k)
            below += weights[k] * static_cast<double>(lit.landed[chunk].past_start[k][lane]);
        irradiance *= Vec3<Real>(glm::exp(-sheet_.columns().optical_depth(beam, weights, below)));
    }
    if (!lit.shade.any()) {
        irradiance_[local.index] += irradiance;
        return;
    }
    const glm::uvec3& triangle = sheet_.triangles()[beam];
    Real px = 0, py = 0;
    for (int k = 0; k < 3; ++k) {
        const Real weight = empty ? Real(1) / 3 : part.weights[k];
        const auto& ray = sheet_.sheet_.rays[triangle[k]];
        const Real start = sheet_.sheet_.start[triangle[k]];
        water += weight * Vec3<Real>(ray.a + start * ray.slope_a, ray.b + start * ray.slope_b, start);
        px += weight * x[k];
        py += weight * y[k];
    }
    // Where a surface curves, its tangent plane may lie inside it.
    if (!may_hide_itself_ && !empty) landed += px * r.u + py * r.v;
    const glm::mat<3, 3, Real> world_from_sheet(sheet_.sheet_.world_from_mesh);
    pairs_.push_back({local.index, irradiance, glm::vec3(world_from_sheet * landed),
                      glm::vec3(world_from_sheet * water), lit.shade});
    const glm::vec3 normal(world_from_sheet * r.normal);
    glm::vec3& point = pairs_.back().receiver_point;
    point += std::max(1e-6f, 4e-7f * glm::length(point)) * normal;
    if (pairs_.size() >= kPairsAtOnce) settle_pairs();
}

template <class Real>
void Tile<Real>::settle_pairs() {
    trace(true);
    trace(false);
    for (const Pair& pair : pairs_) irradiance_[pair.index] += pair.irradiance;
    pairs_.clear();
}

/// Drops the pairs that an object hides after the water, or before it.
template <class Real>
void Tile<Real>::trace(bool after) {
    const light::BeamSheet<Real>& sheet = sheet_.sheet_;
    const bool sun = sheet.light_direction != glm::dvec3(0);
    const glm::vec3 to_sun(-sheet.light_direction);
    const glm::vec3 lamp(sheet_.scene_.state.lights[static_cast<std::size_t>(sheet.light)].position -
                         sheet_.scene_.origin);
    std::vector<rays::Ray> shadow_rays;
    for (const Pair& pair : pairs_) {
        const glm::vec3 from = after ? pair.receiver_point : pair.water_point;
        if (after && pair.shade.after)
            shadow_rays.push_back({from, 0, pair.water_point - from, 1});
        else if (!after && pair.shade.before)
            shadow_rays.push_back(
                {from, 0, sun ? to_sun : lamp - from, sun ? std::numeric_limits<float>::infinity() : 1.0f});
    }
    if (shadow_rays.empty()) return;
    std::vector<std::uint8_t> blocked(shadow_rays.size(), 0);
    sheet_.rays_.occluded_by_objects(shadow_rays, blocked);
    counts_.shadow_rays += shadow_rays.size();
    std::size_t ray = 0, kept = 0;
    for (const Pair& pair : pairs_) {
        const bool traced = after ? pair.shade.after : pair.shade.before;
        if (!traced || !blocked[ray++])
            pairs_[kept++] = pair;
        else if (!hidden_.empty())
            hidden_[pair.index] = 1;
    }
    pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(kept), pairs_.end());
}

/// Whole nodes, opened where they cross the footprint's border.
template <class Real>
void Tile<Real>::add_nodes(const Local& local) {
    const Receiver<Real>& r = local.receiver;
    using Vec2 = glm::vec<2, Real>;
    const Vec2 u(r.u), v(r.v), centre(r.position);
    const Real determinant = u.x * v.y - u.y * v.x;
    // Rows of the inverse of (u v): footprint coordinates seen along the axis.
    const Vec2 to_x = Vec2(v.y, -v.x) / determinant, to_y = Vec2(-u.y, u.x) / determinant;
    const Real low = r.position.z - local.half_depth, high = r.position.z + local.half_depth;
    const LandingFrame<Real> frame(r);
    Lanes<Real> power[3] = {};
    Vec3<Real> sums(0);
    std::vector<NodeId> open(nodes_.rbegin(), nodes_.rend());
    while (!open.empty()) {
        const NodeId node = open.back();
        open.pop_back();
        if (pyramid_.dark(node)) continue;
        // A ray that is within the footprint's prism along the axis at both depths is so between them, where
        // it lands: all rays of the node are, if its box is.
        const Box<Real> box = this->box(node, r, low, high);
        const Vec2 middle = Real(0.5) * Vec2(box.low_a + box.high_a, box.low_b + box.high_b) - centre;
        const Vec2 half = Real(0.5) * Vec2(box.high_a - box.low_a, box.high_b - box.low_b);
        const Real x = std::abs(glm::dot(to_x, middle)), reach_x = glm::dot(glm::abs(to_x), half);
        const Real y = std::abs(glm::dot(to_y, middle)), reach_y = glm::dot(glm::abs(to_y), half);
        if (x - reach_x > Real(0.5) || y - reach_y > Real(0.5)) continue;
        if (x + reach_x <= Real(0.5) && y + reach_y <= Real(0.5)) {
            ++counts_.whole_nodes;
            sums += whole(local, node);
        } else if (node.level > 0) {
            pyramid_.visit_children(node, [&](NodeId child) { open.push_back(child); });
        } else {
            LitCluster<Real> lit;
            land_cluster(node, frame, lit);
            add_cluster(local, lit, power, [](const LandedBeams<Real>& landed) { return landed; });
        }
    }
    irradiance_[local.index] +=
        local.inverse_area * (sums + Vec3<Real>(sum(power[0]), sum(power[1]), sum(power[2])));
}

/// Power of all beams of a node, W, absorbed over the way of their mean ray.
template <class Real>
Vec3<Real> Tile<Real>::whole(const Local& local, NodeId node) {
    const auto& sums = pyramid_.sums(node);
    const Real inverse = 1 / sums.flux;
    const Receiver<Real>& r = local.receiver;
    const Vec3<Real> passes(inverse * sums.flux_a, inverse * sums.flux_b, 0);
    const Vec3<Real> slope(inverse * sums.flux_slope_a, inverse * sums.flux_slope_b, 1);
    const Real lands = glm::dot(r.normal, r.position - passes) / glm::dot(r.normal, slope);
    const Real way = (lands - inverse * sums.flux_start) * (inverse * sums.flux_stretch);
    const Vec3<Real> color(sheet_.sheet_.color), extinction(sheet_.extinction_);
    return sums.tinted * color * glm::exp(-std::max(Real(0), way) * extinction);
}

template void Tile<float>::cover();
template void Tile<double>::cover();

}  // namespace dapple::methods::sliced_beams
