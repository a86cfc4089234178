#pragma once
#include <vector>

#include "media/media.h"
#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// The phase function of one component, for many at once. Values are tabulated evenly over sqrt(sin(theta /
/// 2)), theta the angle of scattering, so that forward peaks are as finely resolved as they are narrow:
/// interpolated linearly, within 3e-5 for Henyey & Greenstein's function up to g = 0.95.
template <class Real>
class PhaseTable {
public:
    PhaseTable(const media::Media& media, std::size_t component);

    bool even() const { return even_; }
    /// p, /sr; `sine`: sin(theta / 2), [0, 1].
    Lanes<Real> operator()(Lanes<Real> sine) const;
    Real at(Real sine) const;

private:
    Real between(Real place) const;

    std::vector<Real> values_;
    bool even_ = true;  ///< all values are the same
};

extern template class PhaseTable<float>;
extern template class PhaseTable<double>;

}  // namespace dapple::methods::sliced_beams
