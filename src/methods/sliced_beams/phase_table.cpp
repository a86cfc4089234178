#include "methods/sliced_beams/phase_table.h"

#include <algorithm>
#include <cmath>

#include "methods/sliced_beams/landing.h"
#include "optics/optics.h"

namespace dapple::methods::sliced_beams {
namespace {

constexpr int kCells = 4096;

}  // namespace

template <class Real>
PhaseTable<Real>::PhaseTable(const media::Media& media, std::size_t component) {
    const scene::PhaseFunction& phase = *media.components()[component].phase;
    const auto add_lobe = [&](double g, double share) {
        const double size = std::abs(g), sides = optics::f64::isotropic_phase() * share * (1 - g) * (1 + g);
        lobes_[lobe_count_++] = {static_cast<Real>(sides),
                                 static_cast<Real>(g < 0 ? (1 + size) * (1 + size) : (1 - size) * (1 - size)),
                                 static_cast<Real>(4 * g)};
    };
    even_ = static_cast<Real>(media.phase(component, 0));
    switch (phase.type) {
        case scene::PhaseType::isotropic:
            return;
        case scene::PhaseType::henyey_greenstein:
            add_lobe(phase.anisotropy, 1);
            return;
        case scene::PhaseType::two_lobe:
            add_lobe(phase.anisotropy, phase.forward_share);
            add_lobe(phase.back_anisotropy, 1 - phase.forward_share);
            return;
        case scene::PhaseType::fournier_forand:
        case scene::PhaseType::table:
            break;
    }
    values_.resize(kCells + 2);
    for (int i = 0; i <= kCells; ++i) {
        const double place = static_cast<double>(i) / kCells;
        const double sine = place * place;  // of half the angle
        values_[static_cast<std::size_t>(i)] = static_cast<Real>(media.phase(component, 1 - 2 * sine * sine));
    }
    values_.back() = values_[kCells];
}

template <class Real>
Lanes<Real> PhaseTable<Real>::tabulated(Lanes<Real> squared_sine) const {
    const Lanes<Real> held = lesser(greater(squared_sine, Lanes<Real>{}), splat(Real(1)));
    const Lanes<Real> place = Real(kCells) * square_root<Real>(square_root<Real>(held));
    if constexpr (sizeof(Real) == 4) {
        const __m256i cell = _mm256_cvttps_epi32(reinterpret_cast<__m256>(place));
        const auto low = reinterpret_cast<Lanes<Real>>(_mm256_i32gather_ps(values_.data(), cell, 4));
        const auto high = reinterpret_cast<Lanes<Real>>(_mm256_i32gather_ps(values_.data() + 1, cell, 4));
        const auto whole = reinterpret_cast<Lanes<Real>>(_mm256_cvtepi32_ps(cell));
        return low + (place - whole) * (high - low);
    }
    Lanes<Real> result;
    for (int lane = 0; lane < kLanes<Real>; ++lane) result[lane] = between(place[lane]);
    return result;
}

template <class Real>
Real PhaseTable<Real>::at(Real squared_sine) const {
    if (values_.empty()) return (*this)(splat(squared_sine))[0];
    return between(Real(kCells) * std::sqrt(std::sqrt(std::min(squared_sine, Real(1)))));
}

template <class Real>
Real PhaseTable<Real>::between(Real place) const {
    const auto cell = static_cast<std::size_t>(place);
    return values_[cell] + (place - static_cast<Real>(cell)) * (values_[cell + 1] - values_[cell]);
}

template class PhaseTable<float>;
template class PhaseTable<double>;

}  // namespace dapple::methods::sliced_beams
