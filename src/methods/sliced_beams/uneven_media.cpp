#include "methods/sliced_beams/uneven_media.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Of a piece on which W is a cubic, at most: optical depth, and length, m.
constexpr double kThin = 0.1, kShort = 0.25;
constexpr double kMostPieces = 4096;  ///< of one piece of the profile
/// Light from beyond so many optical depths is left out.
constexpr double kOpaque = 60;

/// Density on a piece of unit length by its values at the ends and in the middle.
struct Parabola {
    double begin, middle, end;
    double at(double t) const {
        return begin + t * (4 * middle - 3 * begin - end + t * 2 * (begin + end - 2 * middle));
    }
    /// Integral from 0.
    double column(double t) const {
        return t * (begin +
                    t * (0.5 * (4 * middle - 3 * begin - end) + t * 2.0 / 3 * (begin + end - 2 * middle)));
    }
};

}  // namespace

SegmentScatter::SegmentScatter(const media::Media& media, const glm::dvec3& origin,
                               const glm::dvec3& direction, double length, bool in_water) {
    const media::DensityProfile profile = media.profile(origin, direction, length, in_water);
    const std::vector<media::Component>& components = media.components();
    components_ = components.size();
    std::vector<Parabola> density(components_);
    std::vector<glm::dvec3> scattered(components_, glm::dvec3(0));
    glm::dvec3 depth(0);  // optical
    const auto is_lit = [&](std::size_t c) {
        const Parabola& d = density[c];
        return components[c].scattering != glm::dvec3(0) && (d.begin > 0 || d.middle > 0 || d.end > 0);
    };
    std::size_t lit_pieces = 0;  // up to the last that scatters
    double end = 0;              // where that ends
    for (std::size_t i = 0; i + 1 < profile.place.size(); ++i) {
        const double begin = profile.place[i], height = profile.place[i + 1] - begin;
        if (!(height > 0)) continue;
        glm::dvec3 whole(0);
        bool lit = false;
        for (std::size_t c = 0; c < components_; ++c) {
            const std::size_t entry = i * components_ + c;
            const double column = profile.column[entry + components_] - profile.column[entry];
            Parabola& d = density[c];
            d.begin = static_cast<double>(profile.density[entry]);
            d.middle = static_cast<double>(profile.middle[entry]);
            d.end = std::max(0.0, 6 * column / height - d.begin - 4 * d.middle);  // Simpson's rule is exact
            whole += column * components[c].extinction;
            lit |= is_lit(c);
        }
        const double most = std::max({whole.x, whole.y, whole.z});
        if (std::min({depth.x, depth.y, depth.z}) > kOpaque) break;
        if (!lit && place_.empty()) {  // nothing yet
            depth += whole;
            continue;
        }
        const double parts =
            lit ? std::clamp(std::ceil(std::max(most / kThin, height / kShort)), 1.0, kMostPieces) : 1;
        for (int part = 0; part < static_cast<int>(parts); ++part) {
            const double t0 = part / parts, t1 = (part + 1) / parts, step = height / parts;
            const auto depth_at = [&](double t) {
                glm::dvec3 sum = depth;
                for (std::size_t c = 0; c < components_; ++c)
                    sum += height * density[c].column(t) * components[c].extinction;
                return sum;
            };
            const glm::dvec3 seen[3] = {glm::exp(-depth_at(t0)), glm::exp(-depth_at(0.5 * (t0 + t1))),
                                        glm::exp(-depth_at(t1))};
            place_.push_back(begin + t0 * height);
            for (std::size_t c = 0; c < components_; ++c) {
                const glm::dvec3& scattering = components[c].scattering;
                const glm::dvec3 first = density[c].at(t0) * scattering * seen[0];
                const glm::dvec3 middle = density[c].at(0.5 * (t0 + t1)) * scattering * seen[1];
                const glm::dvec3 last = density[c].at(t1) * scattering * seen[2];
                curve_.push_back({scattered[c], glm::vec3(first), glm::vec3(last)});
                scattered[c] += step / 6 * (first + 4.0 * middle + last);
            }
        }
        depth += whole;
        if (!lit) continue;
        lit_pieces = place_.size();
        end = begin + height;
    }
    if (place_.empty()) return;
    place_.resize(lit_pieces);
    place_.push_back(end);
    curve_.resize(lit_pieces * components_);
    for (std::size_t c = 0; c < components_; ++c) curve_.push_back({scattered[c], {}, {}});
}

glm::dvec3 SegmentScatter::scattered(std::size_t component, std::size_t piece, double s) const {
    const Curve& from = curve_[piece * components_ + component];
    const Curve& to = curve_[(piece + 1) * components_ + component];
    const double height = place_[piece + 1] - place_[piece], t = (s - place_[piece]) / height;
    const glm::dvec3 change = to.value - from.value;
    const glm::dvec3 rises = height * glm::dvec3(from.rises), arrives = height * glm::dvec3(from.arrives);
    // Hermite's cubic.
    return from.value +
           t * (rises + t * (3.0 * change - 2.0 * rises - arrives + t * (rises + arrives - 2.0 * change)));
}

template <class Real>
RayColumns<Real>::RayColumns(const media::Media& media, const SheetCoverage<Real>& coverage) {
    const light::BeamSheet<Real>& sheet = coverage.sheet();
    const bool in_water = sheet.in_water();
    if (!media.bounded(in_water) || coverage.pyramid().empty()) return;
    const std::vector<media::Component>& components = media.components();
    media_ = components.size() - 1;
    for (std::size_t c = 1; c <= media_; ++c) extinction_.push_back(components[c].extinction);
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
                                           double depth) const {
    glm::dvec3 sum(0);
    for (int k = 0; k < 3; ++k) {
        if (first_[vertices[k]] == kNone) continue;
        const float* entry = columns_.data() + first_[vertices[k]];
        const double place =
            std::clamp((depth - static_cast<double>(entry[0])) / static_cast<double>(entry[1]), 0.0,
                       static_cast<double>(kPoints - 1));
        const std::size_t cell = std::min(static_cast<std::size_t>(place), kPoints - 2);
        const double t = place - static_cast<double>(cell);
        const float* at = entry + 2 + cell * media_;
        for (std::size_t m = 0; m < media_; ++m)
            sum += weights[k] * glm::mix(static_cast<double>(at[m]), static_cast<double>(at[m + media_]), t) *
                   extinction_[m];
    }
    return sum;
}

template class RayColumns<float>;
template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
