#pragma once
#include <array>
#include <cstddef>

#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// What is lit of an interval [-1, 1] a lane: parts between shadows, in no order.
template <class Real>
class LitParts {
public:
    using L = Lanes<Real>;

    explicit LitParts(const Mask<Real>& wanted) { part_[0] = {splat(Real(-1)), splat(Real(1)), wanted}; }

    /// Shadows that fit: of 63 objects before the water and after it.
    static constexpr std::size_t kMostShadows = 126;

    bool any_lit() const { return count_ > 0; }
    /// Lanes of which something is lit.
    Mask<Real> lanes() const {
        Mask<Real> lit{};
        for (std::size_t i = 0; i < count_; ++i) lit |= part_[i].lanes;
        return lit;
    }
    /// Takes [first, last] away; first >= last: nothing.
    void darken(const L& first, const L& last);
    /// Calls `visit(from, to, lanes)` part by part.
    template <class Visit>
    void visit(Visit&& visit) const {
        for (std::size_t i = 0; i < count_; ++i) visit(part_[i].from, part_[i].to, part_[i].lanes);
    }

private:
    struct Part {
        L from, to;
        Mask<Real> lanes;
    };
    std::array<Part, kMostShadows + 1> part_;  ///< a shadow adds one at most
    std::size_t count_ = 1;
};

template <class Real>
void LitParts<Real>::darken(const L& first, const L& last) {
    std::size_t kept = 0;
    // A shadow parts one of a lane's parts at most: what lies behind it, of all lanes.
    Part behind{last, last, Mask<Real>{}};
    for (std::size_t i = 0; i < count_; ++i) {
        Part part = part_[i];
        const Mask<Real> shadowed = part.lanes & (first < last) & (first < part.to) & (last > part.from);
        if (any(shadowed)) {
            const Mask<Real> before = shadowed & (first > part.from), after = shadowed & (last < part.to);
            const Mask<Real> parted = before & after;
            behind.to = parted ? part.to : behind.to;
            behind.lanes |= parted;
            part.to = before ? first : part.to;
            part.from = (after & ~before) ? last : part.from;
            part.lanes &= ~shadowed | before | after;
        }
        if (any(part.lanes)) part_[kept++] = part;
    }
    // Into lanes that are free, so that there are never more than a lane's parts.
    for (std::size_t i = 0; i < kept && any(behind.lanes); ++i) {
        const Mask<Real> fit = behind.lanes & ~part_[i].lanes;
        part_[i].from = fit ? behind.from : part_[i].from;
        part_[i].to = fit ? behind.to : part_[i].to;
        part_[i].lanes |= fit;
        behind.lanes &= ~fit;
    }
    if (any(behind.lanes)) part_[kept++] = behind;
    count_ = kept;
}

}  // namespace dapple::methods::sliced_beams
