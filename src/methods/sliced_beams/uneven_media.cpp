#include "methods/sliced_beams/uneven_media.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods::sliced_beams {
namespace {

/// Of a piece on which W is a cubic, at most: optical depth, and length, m.
constexpr double kThin = 0.1, kShort = 0.25;
constexpr double kMostPieces = 4096;  ///< of one piece of the profile

/// e^-x for x about kThin, up to three times that where density is uneven: Taylor's polynomial, off by
/// x^7 / 7!, 4e-8 there.
glm::dvec3 thin_decay(const glm::dvec3& x) {
    glm::dvec3 sum(1);
    for (int i = 6; i > 0; --i) sum = 1.0 - x / static_cast<double>(i) * sum;
    return sum;
}

}  // namespace

SegmentScatter::SegmentScatter(const media::Media& media, const glm::dvec3& origin,
                               const glm::dvec3& direction, double length, bool in_water) {
    const media::DensityProfile profile = media.profile(origin, direction, length, in_water);
    const std::vector<media::Component>& components = media.components();
    components_ = components.size();
    std::vector<media::DensityProfile::Parabola> density(components_);
    std::vector<glm::dvec3> scattered(components_, glm::dvec3(0));
    glm::dvec3 depth(0);  // optical
    const auto is_lit = [&](std::size_t c) {
        const media::DensityProfile::Parabola& d = density[c];
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
            density[c] = profile.parabola(i, c);
            whole += column * components[c].extinction;
            lit |= is_lit(c);
        }
        if (std::min({depth.x, depth.y, depth.z}) > media::kOpaque) break;
        if (!lit && place_.empty()) {  // nothing yet
            depth += whole;
            continue;
        }
        const auto depth_at = [&](double t) {
            glm::dvec3 sum = depth;
            for (std::size_t c = 0; c < components_; ++c)
                sum += height * density[c].column(t) * components[c].extinction;
            return sum;
        };
        const auto opaque_at = [&](double t) {
            const glm::dvec3 sum = depth_at(t);
            return std::min({sum.x, sum.y, sum.z}) > media::kOpaque;
        };
        double reach = 1;  // share of the piece from which light comes
        if (lit && opaque_at(1)) {
            double clear = 0;
            for (int halving = 0; halving < 40; ++halving) {
                const double t = 0.5 * (clear + reach);
                (opaque_at(t) ? reach : clear) = t;
            }
        }
        const glm::dvec3 met = depth_at(reach) - depth;
        const double most = std::max({met.x, met.y, met.z});
        const double parts =
            lit ? std::clamp(std::ceil(std::max(most / kThin, reach * height / kShort)), 1.0, kMostPieces)
                : 1;
        glm::dvec3 seen[3] = {{}, {}, glm::exp(-depth)}, part_depth = depth;
        const bool thin = lit && most <= kThin * parts;
        const auto decayed = [&](const glm::dvec3& x) { return thin ? thin_decay(x) : glm::exp(-x); };
        for (int part = 0; part < static_cast<int>(parts); ++part) {
            const double t0 = reach * part / parts, t1 = reach * (part + 1) / parts,
                         step = reach * height / parts;
            seen[0] = seen[2];
            const glm::dvec3 end_depth = depth_at(t1);
            seen[1] = seen[0] * decayed(depth_at(0.5 * (t0 + t1)) - part_depth);
            seen[2] = seen[0] * decayed(end_depth - part_depth);
            const glm::dvec3 rate = (end_depth - part_depth) / step;
            part_depth = end_depth;
            const double densest = std::max({rate.x, rate.y, rate.z});
            pieces_.push_back({static_cast<float>(begin + t0 * height), 0, static_cast<float>(densest)});
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
        end = begin + reach * height;
    }
    if (place_.empty()) return;
    place_.resize(lit_pieces);
    place_.push_back(end);
    curve_.resize(lit_pieces * components_);
    for (std::size_t c = 0; c < components_; ++c) curve_.push_back({scattered[c], {}, {}});
    pieces_.resize(lit_pieces);
    for (std::size_t i = 1; i < lit_pieces; ++i)
        pieces_[i].depth =
            pieces_[i - 1].depth + pieces_[i - 1].rate * (pieces_[i].begin - pieces_[i - 1].begin);
    cubics_.reserve(lit_pieces * components_);
    const auto channels = [](const glm::dvec3& v) {
        const glm::vec4 sum(v, v.x + v.y + v.z);
        return Channels{sum.x, sum.y, sum.z, sum.w};
    };
    for (std::size_t i = 0; i < lit_pieces * components_; ++i) {
        const Curve &from = curve_[i], &to = curve_[i + components_];
        const double height = place_[i / components_ + 1] - place_[i / components_];
        const glm::dvec3 change = (to.value - from.value) / height;
        const glm::dvec3 rises(from.rises), arrives(from.arrives);
        // Hermite's cubic.
        cubics_.push_back({channels(rises), channels((3.0 * change - 2.0 * rises - arrives) / height),
                           channels((rises + arrives - 2.0 * change) / (height * height))});
    }
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

}  // namespace dapple::methods::sliced_beams
