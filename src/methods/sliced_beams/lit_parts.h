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
    std::array<Part, kMostShadows + 1> part_;
    std::size_t count_ = 1;
};

template <class Real>
void LitParts<Real>::darken(const L& first, const L& last) {
    const std::size_t count = count_;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
        Part part = part_[i];
        const Mask<Real> shadowed = part.lanes & (first < last) & (first < part.to) & (last > part.from);
        if (any(shadowed)) {
            const Mask<Real> before = shadowed & (first > part.from), after = shadowed & (last < part.to);
            if (any(before & after)) part_[count_++] = {last, part.to, before & after};
            part.to = before ? first : part.to;
            part.from = (after & ~before) ? last : part.from;
            part.lanes &= ~shadowed | before | after;
        }
        if (any(part.lanes)) part_[kept++] = part;
    }
    // Parts that were added follow those that were kept.
    for (std::size_t i = count; i < count_; ++i) part_[kept++] = part_[i];
    count_ = kept;
}

}  // namespace dapple::methods::sliced_beams
