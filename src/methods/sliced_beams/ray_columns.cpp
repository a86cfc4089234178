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
    columns_.assign(2, 0.0f);
    add_entries(entry, ray_of);
    if (spans_.empty()) return;
    for (std::uint32_t& e : entry) {
        if (e == kNone) continue;
        const auto of_ray = std::span(spans_).subspan(e * media_, media_);
        if (std::all_of(of_ray.begin(), of_ray.end(), [](const auto& s) { return s.empty(); })) e = kNone;
    }
    first_ = std::move(entry);
    find_middles();
}

template <class Real>
media::DensityProfile RayColumns<Real>::profile(const MeanRay& ray) const {
    return bodies_->profile(sheet_->world_from_mesh * ray.origin,
                            sheet_->world_from_mesh * glm::normalize(ray.slope), kReach, sheet_->in_water());
}

template <class Real>
template <class RayOf>
void RayColumns<Real>::add_entries(std::vector<std::uint32_t>& entries, RayOf&& ray_of) {
    const std::size_t known = spans_.size();
    std::size_t added = 0;
    for (std::uint32_t& e : entries)
        if (e != kNone) e = static_cast<std::uint32_t>(known / media_ + added++);
    spans_.resize(known + added * media_);
    // `use(profile, medium, span, stretch)`
    const auto visit = [&](auto&& use) {
        parallel_for(entries.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (entries[i] == kNone) continue;
                const MeanRay ray = ray_of(i);
                const media::DensityProfile along = profile(ray);
                for (std::size_t m = 0; m < media_; ++m)
                    use(along, m, spans_[entries[i] * media_ + m], glm::length(ray.slope));
            }
        });
    };
    visit([&](const media::DensityProfile& along, std::size_t m, ColumnSpan& span, double stretch) {
        span =
            column_span(along, m + 1, static_cast<double>(most_[m]), static_cast<double>(least_[m]), stretch);
    });
    // Where all do not fit, those of the most points are told by the fewest.
    const std::span<ColumnSpan> spans = std::span(spans_).subspan(known);
    const auto points_of = [&](const ColumnSpan& span, int highest) {
        if (span.empty()) return std::uint32_t{0};
        return ColumnSpan::points(span.level <= highest ? span.level : 0);
    };
    const auto all_points = [&](int highest) {
        std::size_t sum = 0;
        for (const ColumnSpan& span : spans) sum += points_of(span, highest);
        return sum;
    };
    int highest = ColumnSpan::kLevels - 1;
    while (highest > 0 && all_points(highest) > std::max(kMostPoints * spans.size(), kPlenty)) --highest;
    std::size_t end = columns_.size();
    columns_.resize(end + all_points(highest));
    for (ColumnSpan& span : spans) {
        const std::uint32_t points = points_of(span, highest);
        if (points == 0) continue;  // it has the first two, which are 0
        span.coarse |= span.level > highest;
        span.inverse_step *= static_cast<float>(points - 1) / static_cast<float>(span.last);
        span.last = points - 1;
        span.first = static_cast<std::uint32_t>(end);
        end += points;
    }
    for (std::size_t i = 0; i < added; ++i) {
        const auto of_ray = spans.subspan(i * media_, media_);
        coarse_rays_ += std::any_of(of_ray.begin(), of_ray.end(), [](const auto& s) { return s.coarse; });
    }
    visit([&](const media::DensityProfile& along, std::size_t m, const ColumnSpan& span, double stretch) {
        if (span.empty()) return;
        fill_columns(along, m + 1, stretch, span, std::span(columns_).subspan(span.first, span.last + 1));
    });
}

template <class Real>
void RayColumns<Real>::find_middles() {
    std::vector<std::uint32_t> entry(beams_.size(), kNone);
    const auto parted = [&](const glm::uvec3& rays, const ColumnSpan& at) {
        for (std::uint32_t point = 0; point <= at.last; point += kLanes<float>) {
            Lanes<float> depth, sum[3] = {};
            for (int lane = 0; lane < kLanes<float>; ++lane)
                depth[lane] =
                    at.begin + static_cast<float>(point + static_cast<std::uint32_t>(lane)) / at.inverse_step;
            Spread spread;
            for (int j = 0; j < 3; ++j)
                add_entry(first_[rays[j]], depth, Lanes<float>{}, ~Mask<float>{}, spread, sum);
            if (any(spread.unlike())) return true;
        }
        return false;
    };
    parallel_for(beams_.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::uvec3& rays = beams_[i];
            const bool valid = sheet_->valid[rays.x] && sheet_->valid[rays.y] && sheet_->valid[rays.z];
            if (!valid || !dims(i)) continue;
            for (int k = 0; k < 3; ++k) {
                if (first_[rays[k]] == kNone) continue;
                for (std::size_t m = 0; m < media_ && entry[i] == kNone; ++m) {
                    const ColumnSpan& at = spans_[first_[rays[k]] * media_ + m];
                    if (!at.empty() && parted(rays, at)) entry[i] = 0;
                }
            }
        }
    });
    add_entries(entry, [&](std::size_t i) { return mean_ray(i, glm::dvec3(1.0 / 3)); });
    middle_ = std::move(entry);
}

template <class Real>
void RayColumns<Real>::Spread::take(const Lanes<float>& densest_here, const Lanes<float>& clearest_here,
                                    const Mask<float>& counts) {
    first = counts ? lesser(first, densest_here) : first;
    last = counts ? greater(last, densest_here) : last;
    clearest = counts ? lesser(clearest, clearest_here) : clearest;
}

template <class Real>
Mask<float> RayColumns<Real>::Spread::unlike() const {
    const Lanes<float> most = first > static_cast<float>(kColumnTolerance) ? splat(kUnlike) : splat(kParted);
    return (last - first > most) & (clearest < static_cast<float>(media::kOpaque));
}

template <class Real>
void RayColumns<Real>::add_entry(std::uint32_t first, const Lanes<float>& depth, const Lanes<float>& weight,
                                 const Mask<float>& counts, Spread& spread, Lanes<float> (&sum)[3]) const {
    using L = Lanes<float>;
    if (first == kNone) return spread.take(L{}, L{}, counts);
    const ColumnSpan* span = spans_.data() + first * media_;
    L densest{}, clearest{};
    for (std::size_t m = 0; m < media_; ++m, ++span) {
        const L last = splat(static_cast<float>(span->last));
        const L place = lesser(greater((depth - span->begin) * span->inverse_step, L{}), last);
        const Mask<float> cell = __builtin_convertvector(lesser(place, last - 1.0f), Mask<float>);
        const L t = place - __builtin_convertvector(cell, L);
        const float* at = columns_.data() + span->first;
        const L low = gathered(at, cell), high = gathered(at + 1, cell);
        const L column = multiply_add(t, high - low, low), share = weight * column;
        for (int c = 0; c < 3; ++c) sum[c] = multiply_add(share, splat(extinction_[m][c]), sum[c]);
        densest = multiply_add(column, splat(most_[m]), densest);
        clearest = multiply_add(column, splat(least_[m]), clearest);
        if (span->coarse) spread.coarse |= counts & (place > 0) & (place < last);
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
    const Mask<float> parted =
        mask & (spread.unlike() | (spread.coarse & (spread.clearest < static_cast<float>(media::kOpaque))));
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
