#include "methods/sliced_beams/ray_columns.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Optical depths between rays above which linear interpolation between them will not do: where a ray has met
/// nothing yet, a face may part them, on which it is off by up to a quarter of that; where all are inside,
/// hardly ever.
constexpr float kParted = 0.1f, kUnlike = 0.5f;
/// Light beyond so many optical depths needs no exact one.
constexpr float kOpaque = 60;
/// m; a bounded medium that matters is nearer to the water than that.
constexpr double kReach = 1e4;

Lanes<float> gathered(const float* from, const Mask<float>& index) {
    return reinterpret_cast<Lanes<float>>(
        _mm256_i32gather_ps(from, reinterpret_cast<__m256i>(index), sizeof(float)));
}

}  // namespace

template <class Real>
RayColumns<Real>::RayColumns(std::shared_ptr<const media::Media> bodies, const light::BeamSheet<Real>& sheet,
                             std::span<const glm::uvec3> beams)
    : bodies_(std::move(bodies)), sheet_(&sheet), beams_(beams) {
    const media::Media& media = *bodies_;
    const bool in_water = sheet.in_water();
    if (!media.bounded(in_water)) return;
    const std::vector<media::Component>& components = media.components();
    media_ = components.size() - 1;
    for (std::size_t c = 1; c <= media_; ++c) {
        const glm::vec3& e = extinction_.emplace_back(components[c].extinction);
        least_.push_back(std::min({e.x, e.y, e.z}));
        most_.push_back(std::max({e.x, e.y, e.z}));
    }
    const std::size_t size = 2 + kPoints * media_;
    const auto ray_of = [&](std::size_t i) {
        const auto& ray = sheet.rays[i];
        const glm::dvec3 slope(ray.slope_a, ray.slope_b, 1);
        return MeanRay{glm::dvec3(ray.a, ray.b, 0) + static_cast<double>(sheet.start[i]) * slope, slope};
    };
    std::vector<std::uint32_t> entry(sheet.rays.size(), kNone);
    parallel_for(entry.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!sheet.valid[i]) continue;
            const MeanRay ray = ray_of(i);
            if (media.may_meet(sheet.world_from_mesh * ray.origin,
                               sheet.world_from_mesh * glm::normalize(ray.slope), kReach, in_water))
                entry[i] = 0;
        }
    });
    std::size_t entries = 0;
    for (std::uint32_t& e : entry)
        if (e != kNone) e = static_cast<std::uint32_t>(size * entries++);
    if (entries == 0) return;
    first_ = std::move(entry);
    columns_.assign(size * entries, 0.0f);
    parallel_for(first_.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (first_[i] != kNone) fill(columns_.data() + first_[i], ray_of(i));
    });
    find_middles();
}

template <class Real>
void RayColumns<Real>::fill(float* entry, const MeanRay& ray) const {
    const double stretch = glm::length(ray.slope);
    const media::DensityProfile profile =
        bodies_->profile(sheet_->world_from_mesh * ray.origin,
                         sheet_->world_from_mesh * (ray.slope / stretch), kReach, sheet_->in_water());
    const std::size_t all = media_ + 1, places = profile.place.size();
    const auto column = [&](std::size_t place, std::size_t c) { return profile.column[place * all + c]; };
    const auto same = [&](std::size_t p, std::size_t q) {
        for (std::size_t c = 1; c < all; ++c)
            if (column(p, c) != column(q, c)) return false;
        return true;
    };
    std::size_t low = 0, high = places - 1;
    while (low < high && same(0, low + 1)) ++low;
    while (high > low && same(places - 1, high - 1)) --high;
    const double step = std::max(1e-6, (profile.place[high] - profile.place[low]) / (kPoints - 1));
    entry[0] = static_cast<float>(profile.place[low] / stretch);
    entry[1] = static_cast<float>(step / stretch);
    std::size_t at = low;
    for (std::size_t k = 0; k < kPoints; ++k) {
        const double place = profile.place[low] + step * static_cast<double>(k);
        while (at + 1 < high && profile.place[at + 1] <= place) ++at;
        const double height = profile.place[at + 1 < places ? at + 1 : at] - profile.place[at];
        const double t = height > 0 ? std::clamp((place - profile.place[at]) / height, 0.0, 1.0) : 0;
        for (std::size_t c = 1; c < all; ++c)
            entry[2 + k * media_ + c - 1] = static_cast<float>(
                height > 0 ? glm::mix(column(at, c), column(at + 1, c), t) : column(at, c));
    }
}

template <class Real>
void RayColumns<Real>::find_middles() {
    std::vector<std::uint32_t> entry(beams_.size(), kNone);
    parallel_for(beams_.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::uvec3& rays = beams_[i];
            const bool valid = sheet_->valid[rays.x] && sheet_->valid[rays.y] && sheet_->valid[rays.z];
            if (!valid || !dims(i)) continue;
            // At the places of the entries.
            for (int k = 0; k < 3 && entry[i] == kNone; ++k) {
                if (first_[rays[k]] == kNone) continue;
                const float* at = columns_.data() + first_[rays[k]];
                for (int place = 0; place < static_cast<int>(kPoints); place += kLanes<float>) {
                    Lanes<float> depth, sum[3] = {};
                    for (int lane = 0; lane < kLanes<float>; ++lane)
                        depth[lane] = at[0] + at[1] * static_cast<float>(place + lane);
                    Spread spread;
                    for (int j = 0; j < 3; ++j)
                        add_entry(first_[rays[j]], depth, Lanes<float>{}, ~Mask<float>{}, spread, sum);
                    if (any(spread.parted())) entry[i] = 0;
                }
            }
        }
    });
    const std::size_t size = 2 + kPoints * media_;
    std::size_t end = columns_.size();
    for (std::uint32_t& e : entry) {
        if (e == kNone) continue;
        e = static_cast<std::uint32_t>(end);
        end += size;
    }
    middle_ = std::move(entry);
    columns_.resize(end, 0.0f);
    parallel_for(beams_.size(), 256, [&](std::size_t begin, std::size_t last) {
        for (std::size_t i = begin; i < last; ++i)
            if (middle_[i] != kNone) fill(columns_.data() + middle_[i], mean_ray(i, glm::dvec3(1.0 / 3)));
    });
}

template <class Real>
void RayColumns<Real>::Spread::take(const Lanes<float>& densest_here, const Lanes<float>& clearest_here,
                                    const Mask<float>& counts) {
    first = counts ? lesser(first, densest_here) : first;
    last = counts ? greater(last, densest_here) : last;
    clearest = counts ? lesser(clearest, clearest_here) : clearest;
}

template <class Real>
Mask<float> RayColumns<Real>::Spread::parted() const {
    const Lanes<float> most = first > 0 ? splat(kUnlike) : splat(kParted);
    return (last - first > most) & (clearest < kOpaque);
}

template <class Real>
void RayColumns<Real>::add_entry(std::uint32_t first, const Lanes<float>& depth, const Lanes<float>& weight,
                                 const Mask<float>& counts, Spread& spread, Lanes<float> (&sum)[3]) const {
    using L = Lanes<float>;
    if (first == kNone) return spread.take(L{}, L{}, counts);
    const float* entry = columns_.data() + first;
    const L place =
        lesser(greater((depth - entry[0]) * (1 / entry[1]), L{}), splat(static_cast<float>(kPoints - 1)));
    const Mask<float> cell =
        __builtin_convertvector(lesser(place, splat(static_cast<float>(kPoints - 2))), Mask<float>);
    const L t = place - __builtin_convertvector(cell, L);
    L densest{}, clearest{};
    for (std::size_t m = 0; m < media_; ++m) {
        const Mask<float> index = cell * static_cast<int>(media_);
        const float* at = entry + 2 + m;
        const L low = gathered(at, index), high = gathered(at + media_, index);
        const L column = multiply_add(t, high - low, low), share = weight * column;
        for (int c = 0; c < 3; ++c) sum[c] = multiply_add(share, splat(extinction_[m][c]), sum[c]);
        densest = multiply_add(column, splat(most_[m]), densest);
        clearest = multiply_add(column, splat(least_[m]), clearest);
    }
    spread.take(densest, clearest, counts);
}

template <class Real>
void RayColumns<Real>::add_optical_depth(std::size_t beam, const Lanes<float> (&weights)[3],
                                         const Lanes<float>& depth, glm::dvec2 shift, const Mask<float>& mask,
                                         Lanes<float> (&sum)[3]) const {
    using L = Lanes<float>;
    const glm::uvec3& rays = beams_[beam];
    const std::uint32_t middle = middle_[beam];
    Spread spread;
    L found[3] = {};
    // With a ray in the middle, in that of the three triangles about it which holds the point.
    const L least = middle == kNone ? L{} : lesser(weights[0], lesser(weights[1], weights[2]));
    for (int k = 0; k < 3; ++k) {
        const L weight = weights[k] - least;
        const Mask<float> counts = middle == kNone ? ~Mask<float>{} : Mask<float>(weight > 0);
        add_entry(first_[rays[k]], depth, weight, counts, spread, found);
    }
    if (middle != kNone) add_entry(middle, depth, 3.0f * least, least > 0, spread, found);
    const Mask<float> parted = mask & spread.parted();
    for (unsigned lanes = bits(parted); lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const glm::dvec3 share(weights[0][lane], weights[1][lane], weights[2][lane]);
        const glm::dvec3 exact = exact_depth(beam, share, static_cast<double>(depth[lane]), shift);
        for (int c = 0; c < 3; ++c) found[c][lane] = static_cast<float>(exact[c]);
    }
    for (int c = 0; c < 3; ++c) sum[c] += found[c];
}

template <class Real>
glm::dvec3 RayColumns<Real>::optical_depth(std::size_t beam, const glm::dvec3& weights, double depth,
                                           glm::dvec2 shift) const {
    Lanes<float> shares[3], sum[3] = {};
    for (int k = 0; k < 3; ++k) shares[k] = splat(static_cast<float>(weights[k]));
    Mask<float> mask{};
    mask[0] = -1;
    add_optical_depth(beam, shares, splat(static_cast<float>(depth)), shift, mask, sum);
    return {sum[0][0], sum[1][0], sum[2][0]};
}

template <class Real>
typename RayColumns<Real>::MeanRay RayColumns<Real>::mean_ray(std::size_t beam,
                                                              const glm::dvec3& weights) const {
    glm::dvec3 origin(0), slope(0, 0, 1);
    double start = 0;
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t i = beams_[beam][k];
        const auto& ray = sheet_->rays[i];
        origin += weights[k] * glm::dvec3(ray.a, ray.b, 0);
        slope += weights[k] * glm::dvec3(ray.slope_a, ray.slope_b, 0);
        start += weights[k] * static_cast<double>(sheet_->start[i]);
    }
    return {origin + start * slope, slope};
}

template <class Real>
glm::dvec3 RayColumns<Real>::exact_depth(std::size_t beam, const glm::dvec3& weights, double depth,
                                         glm::dvec2 shift) const {
    if (!(depth > 0)) return glm::dvec3(0);
    MeanRay ray = mean_ray(beam, weights);
    ray.slope += glm::dvec3(shift, 0);
    const double stretch = glm::length(ray.slope);
    const bool in_water = sheet_->in_water();
    const glm::dvec3 all =
        bodies_->optical_depth(sheet_->world_from_mesh * ray.origin,
                               sheet_->world_from_mesh * (ray.slope / stretch), depth * stretch, in_water);
    return in_water ? all - depth * stretch * bodies_->components()[0].extinction : all;
}

template class RayColumns<float>;
template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
