#include "methods/reference/camera_beams.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace dapple::reference {
namespace {

/// Events at most on a way across all beams.
constexpr double kMostSteps = 32;
constexpr std::uint32_t kNoBeam = 0xffffffffu;
/// Beams up to so many times as wide as half of them are together, and so on.
constexpr std::array<double, 2> kWidthClasses = {8, 512};

/// Half the width and half the height at s, m, together.
double half_width(const CameraBeam& beam, const glm::dvec2& half, double s) {
    return half.x * length(glm::dvec3(beam.u_origin) + s * glm::dvec3(beam.u_direction)) +
           half.y * length(glm::dvec3(beam.v_origin) + s * glm::dvec3(beam.v_direction));
}

/// Where the middle path ends at a slope, a path beside it may go on for longer.
double reach(const CameraBeam& beam, const glm::dvec2& half) {
    return beam.length + 4 * half_width(beam, half, beam.length);
}

double middle_width(const CameraBeam& beam, const glm::dvec2& half) {
    return half_width(beam, half, 0.5 * reach(beam, half));
}

}  // namespace

std::vector<CameraBeams> CameraBeams::by_width(std::vector<CameraBeam> beams, glm::dvec2 half) {
    std::vector<CameraBeams> result;
    if (beams.empty()) return result;
    std::vector<double> widths;
    for (const CameraBeam& beam : beams) widths.push_back(middle_width(beam, half));
    std::nth_element(widths.begin(), widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2),
                     widths.end());
    const double median = widths[widths.size() / 2];
    std::array<std::vector<CameraBeam>, kWidthClasses.size() + 1> classes;
    for (CameraBeam& beam : beams) {
        std::size_t k = 0;
        while (k < kWidthClasses.size() && middle_width(beam, half) > kWidthClasses[k] * median) ++k;
        classes[k].push_back(beam);
    }
    const double all = static_cast<double>(beams.size());
    for (std::vector<CameraBeam>& some : classes) {
        if (some.empty()) continue;
        const double share = static_cast<double>(some.size()) / all;
        result.push_back(CameraBeams(std::move(some), half, share));
    }
    return result;
}

CameraBeams::CameraBeams(std::vector<CameraBeam> beams, glm::dvec2 half, double share)
    : beams_(std::move(beams)), half_(half) {
    choose_voxels(share);
    const std::size_t voxels = static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y) *
                               static_cast<std::size_t>(count_.z);
    // A beam visits a voxel in steps that follow one another: the last visitor tells repetitions.
    first_.assign(voxels + 1, 0);
    std::vector<std::uint32_t> last(voxels, kNoBeam);
    const auto each = [&](const auto& add) {
        std::fill(last.begin(), last.end(), kNoBeam);
        for (std::uint32_t b = 0; b < beams_.size(); ++b) {
            visit_voxels(beams_[b], [&](std::size_t v) {
                if (last[v] == b) return;
                last[v] = b;
                add(v, b);
            });
        }
    };
    each([&](std::size_t v, std::uint32_t) { ++first_[v + 1]; });
    for (std::size_t v = 0; v < voxels; ++v) first_[v + 1] += first_[v];
    found_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    each([&](std::size_t v, std::uint32_t b) { found_[next[v]++] = b; });
}

namespace {

double square(const glm::dvec3& v) {
    return dot(v, v);
}

/// Twice the area of the parallelogram by the sum of the squares of its sides, across the beam: about the
/// ratio of its axes, signed.
double slenderness(const CameraBeam& beam, double s) {
    const glm::dvec3 d(beam.direction);
    const glm::dvec3 by_u = glm::dvec3(beam.u_origin) + s * glm::dvec3(beam.u_direction);
    const glm::dvec3 by_v = glm::dvec3(beam.v_origin) + s * glm::dvec3(beam.v_direction);
    const double u = dot(by_u, d), v = dot(by_v, d);
    const double sum = square(by_u) - u * u + square(by_v) - v * v;
    return sum > 0 ? 2 * dot(cross(by_u, by_v), d) / sum : 0;
}

double widening(double ratio) {
    constexpr double kLeast = CameraBeams::kThin / (CameraBeams::kWidest * CameraBeams::kWidest);
    const double size = std::max(std::abs(ratio), kLeast);
    return size < CameraBeams::kThin ? std::sqrt(CameraBeams::kThin / size) : 1;
}

/// The four edges of a beam are straight, but where it is widened.
struct Edges {
    std::array<glm::dvec3, 4> origin, direction;

    Edges(const CameraBeam& beam, const glm::dvec2& half) {
        for (std::size_t i = 0; i < 4; ++i) {
            const double u = (i & 1) != 0 ? half.x : -half.x, v = (i & 2) != 0 ? half.y : -half.y;
            origin[i] =
                glm::dvec3(beam.origin) + u * glm::dvec3(beam.u_origin) + v * glm::dvec3(beam.v_origin);
            direction[i] = glm::dvec3(beam.direction) + u * glm::dvec3(beam.u_direction) +
                           v * glm::dvec3(beam.v_direction);
        }
    }
    void bounds(double s, glm::dvec3& low, glm::dvec3& high) const {
        for (std::size_t i = 0; i < 4; ++i) {
            low = glm::min(low, origin[i] + s * direction[i]);
            high = glm::max(high, origin[i] + s * direction[i]);
        }
    }
};

}  // namespace

void CameraBeams::choose_voxels(double share) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    low_ = glm::dvec3(kInfinity);
    high_ = glm::dvec3(-kInfinity);
    double way = 0, width = 0;
    for (const CameraBeam& beam : beams_) {
        const Edges edges(beam, half_);
        const double end = reach(beam, half_);
        edges.bounds(0, low_, high_);
        edges.bounds(end, low_, high_);
        way += end;
        width += middle_width(beam, half_);
    }
    width /= static_cast<double>(beams_.size());
    const glm::dvec3 size = high_ - low_;
    voxel_ = std::max(width, 1e-6 * (1 + length(size)));
    const auto too_many = [&] {
        const double around = 1 + width / voxel_;
        const glm::dvec3 counts = glm::floor(size / voxel_) + 1.0;
        return counts.x * counts.y * counts.z > share * kMostVoxels ||
               3 * way / voxel_ * around * around > share * kMostEntries;
    };
    while (too_many()) voxel_ *= 1.25;
    count_ = glm::ivec3(glm::floor(size / voxel_)) + 1;
    spacing_ = std::max(4 * width, length(size) / kMostSteps);
}

template <class Visit>
void CameraBeams::visit_voxels(const CameraBeam& beam, const Visit& visit) const {
    const Edges edges(beam, half_);
    const double end = reach(beam, half_);
    const double steps = std::ceil(end / voxel_);
    double before = slenderness(beam, 0);
    for (double step = 0; step < steps; ++step) {
        const double near = end * step / steps, far = end * (step + 1) / steps;
        const double after = slenderness(beam, far);
        const double wide =
            before * after <= 0 ? kWidest : widening(std::min(std::abs(before), std::abs(after)));
        before = after;
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
        const Edges around = wide > 1 ? Edges(beam, wide * half_) : edges;
        around.bounds(near, low, high);
        around.bounds(far, low, high);
        const glm::ivec3 from =
            glm::clamp(glm::ivec3((low - low_) / voxel_ - 1e-9), glm::ivec3(0), count_ - 1);
        const glm::ivec3 to =
            glm::clamp(glm::ivec3((high - low_) / voxel_ + 1e-9), glm::ivec3(0), count_ - 1);
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x)
                    visit((static_cast<std::size_t>(z) * static_cast<std::size_t>(count_.y) +
                           static_cast<std::size_t>(y)) *
                              static_cast<std::size_t>(count_.x) +
                          static_cast<std::size_t>(x));
    }
}

bool CameraBeams::voxel(const glm::dvec3& position, std::size_t& index) const {
    const glm::dvec3 place = (position - low_) / voxel_;
    for (int axis = 0; axis < 3; ++axis)
        if (!(place[axis] >= 0 && place[axis] < count_[axis])) return false;
    const glm::ivec3 at(place);
    index = (static_cast<std::size_t>(at.z) * static_cast<std::size_t>(count_.y) +
             static_cast<std::size_t>(at.y)) *
                static_cast<std::size_t>(count_.x) +
            static_cast<std::size_t>(at.x);
    return true;
}

bool CameraBeams::find(const CameraBeam& beam, const glm::dvec3& position, Place& place) const {
    const glm::dvec3 o(beam.origin), d(beam.direction), uo(beam.u_origin), ud(beam.u_direction),
        vo(beam.v_origin), vd(beam.v_direction);
    place = {0, 0, dot(position - o, d), 0, 1};
    // Most beams around are far off: half as far again as a corner.
    const double away = square(position - o - place.s * d);
    const double near =
        4.5 * (half_.x * half_.x * square(uo + place.s * ud) + half_.y * half_.y * square(vo + place.s * vd));
    if (away > kWidest * kWidest * near) return false;
    place.widening = widening(slenderness(beam, place.s));
    if (away > place.widening * place.widening * near) return false;
    const glm::dvec2 limit = 2 * place.widening * half_;
    // Newton's method; P is linear in each of u, v and s.
    for (int step = 0; step < 4; ++step) {
        const glm::dvec3 by_u = uo + place.s * ud, by_v = vo + place.s * vd,
                         by_s = d + place.u * ud + place.v * vd;
        const glm::dvec3 rest = position - (o + place.u * uo + place.v * vo + place.s * by_s);
        const glm::dvec3 across = cross(by_u, by_v);
        const double determinant = dot(across, by_s);
        if (determinant == 0) return false;
        const double du = dot(rest, cross(by_v, by_s)) / determinant;
        const double dv = dot(rest, cross(by_s, by_u)) / determinant;
        const double ds = dot(rest, across) / determinant;
        place.u += du;
        place.v += dv;
        place.s += ds;
        place.jacobian = std::abs(determinant);
        if (std::abs(place.u) > limit.x || std::abs(place.v) > limit.y) return false;
        if (std::abs(du) < 1e-6 * half_.x && std::abs(dv) < 1e-6 * half_.y) break;
    }
    place.widening = widening(slenderness(beam, place.s));
    const glm::dvec2 half = place.widening * half_;
    return std::abs(place.u) < half.x && std::abs(place.v) < half.y && place.s > 0 &&
           place.s < reach(beam, half_);
}

bool CameraBeams::add_events(const LightWay& way, MediaProbe& light_probe, MediaProbe& eye_probe,
                             RandomStream& random, std::vector<ScatteringEvent>& events) const {
    const OwnMedia& media = light_probe.media();
    const auto stretch = media.scattering_stretch(way.position, way.direction, way.length, way.in_water);
    if (!stretch) return false;
    double begin = stretch->begin, end = stretch->end;
    for (int axis = 0; axis < 3; ++axis) {
        if (way.direction[axis] == 0) continue;
        const double a = (low_[axis] - way.position[axis]) / way.direction[axis];
        const double b = (high_[axis] - way.position[axis]) / way.direction[axis];
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    if (!(begin < end)) return false;
    const double count = std::ceil((end - begin) / spacing_);
    const double step = (end - begin) / count;
    const bool bounded = media.any_bounded(way.in_water);
    if (bounded) light_probe.start(way.position, way.direction, way.in_water);
    bool extinguished = false;
    for (double i = 0; i < count; ++i) {
        const double along = begin + step * (i + random.next());
        const glm::dvec3 position = way.position + along * way.direction;
        std::size_t at = 0;
        if (!voxel(position, at)) continue;
        for (std::uint32_t k = first_[at]; k < first_[at + 1]; ++k) {
            const CameraBeam& beam = beams_[found_[k]];
            Place place{};
            if ((beam.in_water != 0) != way.in_water || !find(beam, position, place)) continue;
            ScatteringEvent event;
            event.position = position;
            const glm::dvec3 aside =
                place.u * glm::dvec3(beam.u_origin) + place.v * glm::dvec3(beam.v_origin);
            event.near_end = glm::dvec3(beam.origin) + aside;
            // A mirror or glass there may bend towards it.
            event.slack = 0.25 * length(aside);
            const glm::dvec3 back = event.near_end - position;
            const double distance = length(back);
            if (!(distance > 0)) continue;
            const glm::dvec3 view = back / distance;
            const glm::dvec3 scattering =
                light_probe.scattering(position, dot(way.direction, view), way.in_water);
            if (scattering == glm::dvec3(0)) continue;
            glm::dvec3 transmittance;
            if (bounded) {
                transmittance = light_probe.transmittance_to(along, random);
                if (transmittance == glm::dvec3(0)) return true;  // nor farther on
                transmittance *= eye_probe.transmittance(position, view, distance, way.in_water, random);
            } else {
                transmittance = way.in_water ? media.through_water(along + distance) : glm::dvec3(1);
            }
            event.radiance = step / (place.jacobian * place.widening * place.widening) * way.power *
                             scattering * transmittance * glm::dvec3(beam.factor);
            event.segment = beam.segment;
            event.in_water = way.in_water;
            if (event.radiance != glm::dvec3(0))
                events.push_back(event);
            else if (transmittance == glm::dvec3(0))
                extinguished = true;
        }
    }
    return extinguished;
}

}  // namespace dapple::reference
