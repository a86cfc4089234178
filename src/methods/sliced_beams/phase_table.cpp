#include "methods/sliced_beams/phase_table.h"

#include <algorithm>
#include <cmath>

#include "methods/sliced_beams/landing.h"

namespace dapple::methods::sliced_beams {
namespace {

constexpr int kCells = 4096;

}  // namespace

template <class Real>
PhaseTable<Real>::PhaseTable(const media::Media& media, std::size_t component) : values_(kCells + 2) {
    for (int i = 0; i <= kCells; ++i) {
        const double place = static_cast<double>(i) / kCells;
        const double sine = place * place;  // of half the angle
        values_[static_cast<std::size_t>(i)] = static_cast<Real>(media.phase(component, 1 - 2 * sine * sine));
    }
    values_.back() = values_[kCells];
    even_ = std::all_of(values_.begin(), values_.end(), [&](Real value) { return value == values_[0]; });
}

template <class Real>
Lanes<Real> PhaseTable<Real>::operator()(Lanes<Real> sine) const {
    if (even_) return splat(values_[0]);
    const Lanes<Real> place =
        Real(kCells) * square_root<Real>(lesser(greater(sine, Lanes<Real>{}), splat(Real(1))));
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
Real PhaseTable<Real>::at(Real sine) const {
    return between(Real(kCells) * std::sqrt(std::min(sine, Real(1))));
}

template <class Real>
Real PhaseTable<Real>::between(Real place) const {
    const auto cell = static_cast<std::size_t>(place);
    return values_[cell] + (place - static_cast<Real>(cell)) * (values_[cell + 1] - values_[cell]);
}

template class PhaseTable<float>;
template class PhaseTable<double>;

}  // namespace dapple::methods::sliced_beams
