#include "methods/reference/own_phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::reference {
namespace {

constexpr double kPi = std::numbers::pi;

/// Henyey & Greenstein, Astrophysical Journal 93 (1941). 1 + g^2 - 2 g cos = (1 - g)^2 + 2 g (1 - cos).
double henyey_greenstein(double g, double cosine) {
    const double square = (1 - g) * (1 - g) + 2 * g * (1 - cosine);
    return (1 - g * g) / (4 * kPi * square * std::sqrt(square));
}

/// Integral of 2 pi sin(a) f(a) from a to b, f linear in the angle with values u and v at the ends.
double integral_of_line(double a, double b, double u, double v) {
    if (!(b > a)) return 0;
    const double slope = (v - u) / (b - a);
    const auto antiderivative = [&](double x) {
        return -(u + slope * (x - a)) * std::cos(x) + slope * std::sin(x);
    };
    return 2 * kPi * (antiderivative(b) - antiderivative(a));
}

}  // namespace

OwnPhase::OwnPhase(const scene::PhaseFunction& phase) : phase_(phase) {
    if (phase.type != scene::PhaseType::table || phase.samples.empty()) return;
    const std::vector<scene::PhaseSample>& samples = phase.samples;
    double sum = integral_of_line(0, samples.front().angle, samples.front().value, samples.front().value) +
                 integral_of_line(samples.back().angle, kPi, samples.back().value, samples.back().value);
    for (std::size_t i = 1; i < samples.size(); ++i) {
        sum +=
            integral_of_line(samples[i - 1].angle, samples[i].angle, samples[i - 1].value, samples[i].value);
    }
    table_norm_ = sum > 0 ? 1 / sum : 0;
}

double OwnPhase::operator()(double cosine) const {
    cosine = std::clamp(cosine, -1.0, 1.0);
    switch (phase_.type) {
        case scene::PhaseType::isotropic:
            break;
        case scene::PhaseType::henyey_greenstein:
            return henyey_greenstein(phase_.anisotropy, cosine);
        case scene::PhaseType::two_lobe:
            return phase_.forward_share * henyey_greenstein(phase_.anisotropy, cosine) +
                   (1 - phase_.forward_share) * henyey_greenstein(phase_.back_anisotropy, cosine);
        case scene::PhaseType::fournier_forand:
            return fournier_forand(cosine);
        case scene::PhaseType::table:
            return table_norm_ * table(std::acos(cosine));
    }
    return 1 / (4 * kPi);
}

double OwnPhase::fournier_forand(double cosine) const {
    const double v = 0.5 * (3 - phase_.size_slope);
    const double index = phase_.particle_index - 1;
    const double backward = 4 / (3 * index * index);  // delta at 180 degrees
    // p has an integrable pole straight on, where no density of light means anything.
    const double sine_square = std::max(0.5 * (1 - cosine), 1e-14);
    const double delta = backward * sine_square;
    const double power = std::pow(delta, v);
    const double e = delta - 1;
    double first, second;  // over (1 - delta)^2
    if (std::abs(e) < 1e-4) {
        const double c2 = 0.5 * v * (v - 1), c3 = c2 * (v - 2) / 3;
        first = c2 + c3 * e;
        second = -(c2 + v) - (c3 + c2) * e;
    } else {
        first = (v * (1 - delta) - (1 - power)) / (e * e);
        second = (delta * (1 - power) - v * (1 - delta)) / (e * e);
    }
    const double power_backward = std::pow(backward, v);
    return (first + second / sine_square) / (4 * kPi * power) +
           (1 - power_backward) / (16 * kPi * (backward - 1) * power_backward) * (3 * cosine * cosine - 1);
}

double OwnPhase::table(double angle) const {
    const std::vector<scene::PhaseSample>& samples = phase_.samples;
    if (samples.empty()) return 1 / (4 * kPi);
    const auto after = std::upper_bound(samples.begin(), samples.end(), angle,
                                        [](double a, const scene::PhaseSample& s) { return a < s.angle; });
    if (after == samples.begin()) return samples.front().value;
    if (after == samples.end()) return samples.back().value;
    const scene::PhaseSample& before = *std::prev(after);
    const double place = (angle - before.angle) / (after->angle - before.angle);
    return before.value + place * (after->value - before.value);
}

}  // namespace dapple::reference
