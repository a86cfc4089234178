#pragma once
#include <span>
#include <vector>

#include "media/media.h"
#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// The phase function of one component, for many at once. Henyey & Greenstein's lobes as they are; other
/// functions are tabulated evenly over sqrt(sin(theta / 2)), theta the angle of scattering, so that forward
/// peaks are as finely resolved as they are narrow, and interpolated linearly.
template <class Real>
class PhaseTable {
public:
    PhaseTable(const media::Media& media, std::size_t component);

    bool even() const { return lobe_count_ == 0 && values_.empty(); }
    /// p, /sr; `squared_sine`: of theta / 2, [0, 1].
    Lanes<Real> operator()(Lanes<Real> squared_sine) const {
        if (lobe_count_ > 0) {
            const Lanes<Real> first = denominator(lobes_[0], squared_sine);
            if (lobe_count_ == 1) return lobes_[0].share / first;
            // Over one denominator: quotients are dear.
            const Lanes<Real> second = denominator(lobes_[1], squared_sine);
            return (lobes_[0].share * second + lobes_[1].share * first) / (first * second);
        }
        return values_.empty() ? splat(even_) : tabulated(squared_sine);
    }
    Real at(Real squared_sine) const;

    /// share / (least + grows sin^2(theta / 2))^(3/2)
    struct Lobe {
        Real share, least, grows;
    };
    /// What the function is: lobes, or values evenly over sqrt(sin(theta / 2)), the last one twice, or a
    /// constant.
    std::span<const Lobe> lobes() const { return {lobes_, static_cast<std::size_t>(lobe_count_)}; }
    std::span<const Real> values() const { return values_; }
    Real constant() const { return even_; }

private:
    static Lanes<Real> denominator(const Lobe& lobe, Lanes<Real> squared_sine) {
        const Lanes<Real> square = multiply_add(splat(lobe.grows), squared_sine, splat(lobe.least));
        return square * square_root<Real>(square);
    }
    Lanes<Real> tabulated(Lanes<Real> squared_sine) const;
    Real between(Real place) const;

    Lobe lobes_[2]{};
    int lobe_count_ = 0;
    std::vector<Real> values_;
    Real even_ = 0;
};

extern template class PhaseTable<float>;
extern template class PhaseTable<double>;

}  // namespace dapple::methods::sliced_beams
