#include "methods/reference/oracle_surface.h"

#include <cassert>
#include <numbers>

#include "ocean/dispersion.h"

namespace dapple::oracle {
namespace {

/// Widens bounds that were themselves summed in rounded arithmetic, over at most some thousand terms.
constexpr double kSafety = 1 + 1e-12;

}  // namespace

Surface::Surface(const scene::Water& water, double time) {
    assert(water.surface.type == scene::WaterSurfaceType::waves);
    const scene::Waves& waves = water.surface.waves;
    for (const scene::Wave& wave : waves.waves) {
        if (wave.amplitude == 0) continue;
        const double k = 2 * std::numbers::pi / wave.length;
        const double omega = ocean::angular_frequency(k, waves.depth);
        const double k_x = k * std::cos(wave.heading), k_z = k * std::sin(wave.heading);
        const double x = std::abs(k_x), z = std::abs(k_z), a = std::abs(wave.amplitude);
        waves_.push_back({k_x, k_z, x, z, wave.amplitude, a,
                          static_cast<long double>(wave.phase) - static_cast<long double>(omega) * time});
        sum_.height += a;
        sum_.x += a * x;
        sum_.z += a * z;
        sum_.xx += a * x * x;
        sum_.xz += a * x * z;
        sum_.zz += a * z * z;
        largest_k_ = std::max(largest_k_, x + z);
    }
    for (double* sum : {&sum_.height, &sum_.x, &sum_.z, &sum_.xx, &sum_.xz, &sum_.zz}) *sum *= kSafety;
}

Surface::Local::Local(const Surface& surface, glm::dvec2 anchor) : surface_(&surface) {
    constexpr long double turn = 2 * std::numbers::pi_v<long double>;
    phases_.reserve(surface.waves_.size());
    for (const Wave& wave : surface.waves_) {
        const long double along_x = static_cast<long double>(wave.k_x) * anchor.x;
        const long double along_z = static_cast<long double>(wave.k_z) * anchor.y;
        phases_.push_back(static_cast<double>(std::remainder(along_x + along_z + wave.phase, turn)));
        // Five roundings to 64 bits, and the turn's own in each turn.
        const long double size = std::abs(along_x) + std::abs(along_z) + std::abs(wave.phase);
        phase_error_ = std::max(phase_error_, static_cast<double>(size * 0x1p-61L) + 0x1p-51);
    }
}

Jet<double> Surface::Local::at(double x, double z) const {
    Jet<double> jet;
    for (std::size_t w = 0; w < phases_.size(); ++w) {
        const Wave& wave = surface_->waves_[w];
        const double phase = wave.k_x * x + wave.k_z * z + phases_[w];
        const double c = wave.amplitude * std::cos(phase), s = wave.amplitude * std::sin(phase);
        jet.height += c;
        jet.x -= s * wave.k_x;
        jet.z -= s * wave.k_z;
        jet.xx -= c * wave.k_x * wave.k_x;
        jet.xz -= c * wave.k_x * wave.k_z;
        jet.zz -= c * wave.k_z * wave.k_z;
    }
    return jet;
}

bool Surface::Local::bounds(double x, double z, double radius_x, double radius_z, Jet<Interval>& at_center,
                            Jet<Interval>& over) const {
    Jet<double> jet;
    Jet<double> rest;  // of Taylor's formula, or of waves that the box is too large for
    double xxx = 0, xxz = 0, xzz = 0, zzz = 0;
    bool fine = true;
    for (std::size_t w = 0; w < phases_.size(); ++w) {
        const Wave& wave = surface_->waves_[w];
        const double rho = wave.abs_x * radius_x + wave.abs_z * radius_z;
        double remainder = wave.magnitude;
        if (rho <= 1) {
            const double phase = wave.k_x * x + wave.k_z * z + phases_[w];
            const double c = wave.amplitude * std::cos(phase), s = wave.amplitude * std::sin(phase);
            const double s_x = s * wave.k_x, s_z = s * wave.k_z;
            jet.height += c;
            jet.x -= s_x;
            jet.z -= s_z;
            jet.xx -= c * wave.k_x * wave.k_x;
            jet.xz -= c * wave.k_x * wave.k_z;
            jet.zz -= c * wave.k_z * wave.k_z;
            xxx += s_x * wave.k_x * wave.k_x;
            xxz += s_x * wave.k_x * wave.k_z;
            xzz += s_x * wave.k_z * wave.k_z;
            zzz += s_z * wave.k_z * wave.k_z;
            remainder *= 0.5 * rho * rho;
        } else {
            fine = false;
        }
        rest.height += remainder;
        rest.x += remainder * wave.abs_x;
        rest.z += remainder * wave.abs_z;
        rest.xx += remainder * wave.abs_x * wave.abs_x;
        rest.xz += remainder * wave.abs_x * wave.abs_z;
        rest.zz += remainder * wave.abs_z * wave.abs_z;
    }
    // What the doubles at the centre may be off, for a wave of amplitude 1: its phase's rounding, cos and sin
    // (taken to be right to 2 units in the last place), products and the sum.
    const double reach = std::max(std::abs(x), std::abs(z)) * surface_->largest_k_;
    const double error = phase_error_ + 0x1p-52 * (2 * reach + static_cast<double>(phases_.size()) + 16);
    const Jet<double>& sum = surface_->sum_;
    const auto center_of = [&](double value, double bound) { return around(value, error * bound * kSafety); };
    const auto over_of = [&](double value, double bound, double along_x, double along_z, double remainder) {
        // The derivatives' own errors are `error` times at most largest_k times the bound.
        const double off = error * (1 + surface_->largest_k_ * (radius_x + radius_z)) * bound;
        return around(
            value, (std::abs(along_x) * radius_x + std::abs(along_z) * radius_z + remainder + off) * kSafety);
    };
    over = {over_of(jet.height, sum.height, jet.x, jet.z, rest.height),
            over_of(jet.x, sum.x, jet.xx, jet.xz, rest.x),
            over_of(jet.z, sum.z, jet.xz, jet.zz, rest.z),
            over_of(jet.xx, sum.xx, xxx, xxz, rest.xx),
            over_of(jet.xz, sum.xz, xxz, xzz, rest.xz),
            over_of(jet.zz, sum.zz, xzz, zzz, rest.zz)};
    if (fine) {
        at_center = {center_of(jet.height, sum.height), center_of(jet.x, sum.x),   center_of(jet.z, sum.z),
                     center_of(jet.xx, sum.xx),         center_of(jet.xz, sum.xz), center_of(jet.zz, sum.zz)};
    }
    return fine;
}

Sight Surface::Local::sight(glm::dvec3 start, glm::dvec3 direction, double length, bool above) const {
    // The clearance along the ray, f(t) = side (y - h), is 0 at t = 0: there its derivative has to be
    // positive.
    const double side = above ? 1 : -1;
    struct Bounds {
        Interval value, derivative;
    };
    const auto bounds_of = [&](double from, double to) {
        const double middle_t = 0.5 * (from + to), radius = 0.5 * (to - from);
        const glm::dvec3 point = start + middle_t * direction;
        double height = 0, slope = 0, curvature = 0, scale = 0, steepness = 0;
        for (std::size_t w = 0; w < phases_.size(); ++w) {
            const Wave& wave = surface_->waves_[w];
            const double along = wave.k_x * direction.x + wave.k_z * direction.z;
            const double phase = wave.k_x * point.x + wave.k_z * point.z + phases_[w];
            height += wave.amplitude * std::cos(phase);
            slope -= wave.amplitude * along * std::sin(phase);
            curvature += wave.magnitude * along * along;
            scale += wave.magnitude;
            steepness += wave.magnitude * std::abs(along);
        }
        const double reach = std::max(std::abs(point.x), std::abs(point.z)) * surface_->largest_k_;
        const double error = phase_error_ + 0x1p-52 * (4 * reach + static_cast<double>(phases_.size()) + 16);
        const double rate = side * (direction.y - slope);
        const double rate_off = error * steepness + 0x1p-50;
        return Bounds{around(side * (point.y - height),
                             ((std::abs(rate) + rate_off) * radius + 0.5 * curvature * radius * radius +
                              error * scale + 0x1p-50 * (std::abs(point.y) + scale)) *
                                 kSafety),
                      around(rate, (curvature * radius + rate_off) * kSafety)};
    };
    struct Stretch {
        double from, to;
    };
    std::vector<Stretch> stack = {{0, length}};
    constexpr double kSmallest = 1e-9;  // m
    Sight sight = Sight::clear;
    while (!stack.empty()) {
        const Stretch stretch = stack.back();
        stack.pop_back();
        const Bounds bounds = bounds_of(stretch.from, stretch.to);
        if (bounds.value.lo > 0 || (stretch.from == 0 && bounds.derivative.lo > 0)) continue;
        if (bounds.value.hi < 0) return Sight::blocked;
        if (stretch.to - stretch.from < kSmallest) {
            sight = Sight::undecided;
            continue;
        }
        const double split = 0.5 * (stretch.from + stretch.to);
        stack.push_back({split, stretch.to});
        stack.push_back({stretch.from, split});
    }
    return sight;
}

}  // namespace dapple::oracle
