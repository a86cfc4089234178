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
            Lanes<Real> sum = of_lobe(lobes_[0], squared_sine);
            if (lobe_count_ > 1) sum += of_lobe(lobes_[1], squared_sine);
            return sum;
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
    static Lanes<Real> of_lobe(const Lobe& lobe, Lanes<Real> squared_sine) {
        const Lanes<Real> root =
            inverse_root(multiply_add(splat(lobe.grows), squared_sine, splat(lobe.least)));
        return lobe.share * root * (root * root);
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
