#include "media/phase.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "optics/optics.h"

namespace dapple::media {
namespace {

constexpr double kPi = std::numbers::pi;

/// Integral over the sphere of a table, 2 pi int p sin(angle) d(angle), p linear in the angle.
double over_sphere(const std::vector<scene::PhaseSample>& samples) {
    double sum = samples.front().value * (1 - std::cos(samples.front().angle)) +
                 samples.back().value * (1 + std::cos(samples.back().angle));
    for (std::size_t i = 1; i < samples.size(); ++i) {
        const auto [a, from] = samples[i - 1];
        const auto [b, to] = samples[i];
        sum += from * std::cos(a) - to * std::cos(b) + (to - from) / (b - a) * (std::sin(b) - std::sin(a));
    }
    return 2 * kPi * sum;
}

double interpolated(const std::vector<scene::PhaseSample>& samples, double angle) {
    const auto after = std::upper_bound(samples.begin(), samples.end(), angle,
                                        [](double a, const scene::PhaseSample& s) { return a < s.angle; });
    if (after == samples.begin()) return after->value;
    const scene::PhaseSample& before = *(after - 1);
    if (after == samples.end()) return before.value;
    return before.value +
           (angle - before.angle) / (after->angle - before.angle) * (after->value - before.value);
}

}  // namespace

Phase::Phase(const scene::PhaseFunction& function) : function_(function) {
    if (function_.type != scene::PhaseType::table) return;
    assert(!function_.samples.empty());
    const double total = over_sphere(function_.samples);
    for (scene::PhaseSample& sample : function_.samples) sample.value /= total;
}

double Phase::at(double cosine) const {
    switch (function_.type) {
        case scene::PhaseType::isotropic:
            return optics::f64::isotropic_phase();
        case scene::PhaseType::henyey_greenstein:
            return optics::f64::henyey_greenstein_phase(cosine, function_.anisotropy);
        case scene::PhaseType::two_lobe:
            return optics::f64::two_lobe_phase(cosine, function_.anisotropy, function_.back_anisotropy,
                                               function_.forward_share);
        case scene::PhaseType::fournier_forand:
            return optics::f64::fournier_forand_phase(cosine, function_.particle_index, function_.size_slope);
        case scene::PhaseType::table:
            return interpolated(function_.samples, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
    return 0;
}

}  // namespace dapple::media
