#include "methods/sliced_beams/ray_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Optical depths between the three rays above which the mean ray is asked itself: where a ray has met
/// nothing yet, a face may part them, on which linear interpolation is off by up to a quarter of that; where
/// all are inside, hardly ever.
constexpr double kParted = 0.1, kUnlike = 0.5;
/// Light beyond so many optical depths needs no exact one.
constexpr double kOpaque = 60;

}  // namespace

template <class Real>
RayColumns<Real>::RayColumns(std::shared_ptr<const media::Media> bodies, const light::BeamSheet<Real>& sheet)
    : bodies_(std::move(bodies)), sheet_(&sheet) {
    const media::Media& media = *bodies_;
    const bool in_water = sheet.in_water();
    if (!media.bounded(in_water)) return;
    const std::vector<media::Component>& components = media.components();
    media_ = components.size() - 1;
    for (std::size_t c = 1; c <= media_; ++c) {
        const glm::dvec3& e = extinction_.emplace_back(components[c].extinction);
        least_.push_back(std::min({e.x, e.y, e.z}));
        most_.push_back(std::max({e.x, e.y, e.z}));
    }
    const std::size_t size = 2 + kPoints * media_;
    // m; a bounded medium that matters is nearer to the water than that.
    constexpr double kReach = 1e4;
    const auto ray_of = [&](std::size_t i, glm::dvec3& origin, glm::dvec3& direction) {
        const auto& ray = sheet.rays[i];
        const glm::dvec3 slope(ray.slope_a, ray.slope_b, 1);
        const double stretch = glm::length(slope);
        origin = sheet.world_from_mesh *
                 (glm::dvec3(ray.a, ray.b, 0) + static_cast<double>(sheet.start[i]) * slope);
        direction = sheet.world_from_mesh * (slope / stretch);
        return stretch;
    };
    std::vector<std::uint32_t> entry(sheet.rays.size(), kNone);
    parallel_for(entry.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            glm::dvec3 origin, direction;
            ray_of(i, origin, direction);
            if (sheet.valid[i] && media.may_meet(origin, direction, kReach, in_water)) entry[i] = 0;
        }
    });
    std::size_t entries = 0;
    for (std::uint32_t& e : entry)
        if (e != kNone) e = static_cast<std::uint32_t>(size * entries++);
    if (entries == 0) return;
    first_ = std::move(entry);
    columns_.assign(size * entries, 0.0f);
    parallel_for(first_.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (first_[i] == kNone) continue;
            glm::dvec3 origin, direction;
            const double stretch = ray_of(i, origin, direction);
            const media::DensityProfile profile = media.profile(origin, direction, kReach, in_water);
            const std::size_t all = components.size(), places = profile.place.size();
            const auto column = [&](std::size_t place, std::size_t c) {
                return profile.column[place * all + c];
            };
            const auto same = [&](std::size_t p, std::size_t q) {
                for (std::size_t c = 1; c < all; ++c)
                    if (column(p, c) != column(q, c)) return false;
                return true;
            };
            std::size_t low = 0, high = places - 1;
            while (low < high && same(0, low + 1)) ++low;
            while (high > low && same(places - 1, high - 1)) --high;
            float* out = columns_.data() + first_[i];
            const double step = std::max(1e-6, (profile.place[high] - profile.place[low]) / (kPoints - 1));
            out[0] = static_cast<float>(profile.place[low] / stretch);
            out[1] = static_cast<float>(step / stretch);
            std::size_t at = low;
            for (std::size_t k = 0; k < kPoints; ++k) {
                const double place = profile.place[low] + step * static_cast<double>(k);
                while (at + 1 < high && profile.place[at + 1] <= place) ++at;
                const double height = profile.place[at + 1 < places ? at + 1 : at] - profile.place[at];
                const double t = height > 0 ? std::clamp((place - profile.place[at]) / height, 0.0, 1.0) : 0;
                for (std::size_t c = 1; c < all; ++c)
                    out[2 + k * media_ + c - 1] = static_cast<float>(
                        height > 0 ? glm::mix(column(at, c), column(at + 1, c), t) : column(at, c));
            }
        }
    });
}

template <class Real>
glm::dvec3 RayColumns<Real>::optical_depth(const glm::uvec3& vertices, const glm::dvec3& weights,
                                           double depth, glm::dvec2 shift) const {
    glm::dvec3 sum(0);
    // Of the three: in the densest channel, and in the clearest.
    double first = std::numeric_limits<double>::infinity(), last = 0, clearest = first;
    for (int k = 0; k < 3; ++k) {
        if (first_[vertices[k]] == kNone) {
            first = clearest = 0;
            continue;
        }
        const float* entry = columns_.data() + first_[vertices[k]];
        const double place =
            std::clamp((depth - static_cast<double>(entry[0])) / static_cast<double>(entry[1]), 0.0,
                       static_cast<double>(kPoints - 1));
        const std::size_t cell = std::min(static_cast<std::size_t>(place), kPoints - 2);
        const double t = place - static_cast<double>(cell);
        const float* at = entry + 2 + cell * media_;
        double densest_here = 0, clearest_here = 0;
        for (std::size_t m = 0; m < media_; ++m) {
            const double column =
                glm::mix(static_cast<double>(at[m]), static_cast<double>(at[m + media_]), t);
            sum += weights[k] * column * extinction_[m];
            densest_here += column * most_[m];
            clearest_here += column * least_[m];
        }
        first = std::min(first, densest_here);
        last = std::max(last, densest_here);
        clearest = std::min(clearest, clearest_here);
    }
    if (last - first > (first > 0 ? kUnlike : kParted) && clearest < kOpaque)
        return exact_depth(vertices, weights, depth, shift);
    return sum;
}

template <class Real>
glm::dvec3 RayColumns<Real>::exact_depth(const glm::uvec3& vertices, const glm::dvec3& weights, double depth,
                                         glm::dvec2 shift) const {
    if (!(depth > 0)) return glm::dvec3(0);
    glm::dvec3 origin(0), slope(0, 0, 1);
    double start = 0;
    for (int k = 0; k < 3; ++k) {
        const auto& ray = sheet_->rays[vertices[k]];
        origin += weights[k] * glm::dvec3(ray.a, ray.b, 0);
        slope += weights[k] * glm::dvec3(ray.slope_a, ray.slope_b, 0);
        start += weights[k] * static_cast<double>(sheet_->start[vertices[k]]);
    }
    origin += start * slope;
    slope += glm::dvec3(shift, 0);
    const double stretch = glm::length(slope);
    const bool in_water = sheet_->in_water();
    const glm::dvec3 all =
        bodies_->optical_depth(sheet_->world_from_mesh * origin, sheet_->world_from_mesh * (slope / stretch),
                               depth * stretch, in_water);
    return in_water ? all - depth * stretch * bodies_->components()[0].extinction : all;
}

template class RayColumns<float>;
template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
