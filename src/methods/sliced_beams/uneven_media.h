#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "media/media.h"

namespace dapple::methods::sliced_beams {

/// What a camera segment through bounded media scatters towards its near end of a unit of fluence and phase:
/// W(s), the integral of scattering times transmittance from the near end to s, a component and channel.
class SegmentScatter {
public:
    SegmentScatter() = default;
    SegmentScatter(const media::Media& media, const glm::dvec3& origin, const glm::dvec3& direction,
                   double length, bool in_water);

    /// m along the segment, between which something scatters; first() >= last(): nothing does.
    double first() const { return place_.empty() ? 0 : place_.front(); }
    double last() const { return place_.empty() ? 0 : place_.back(); }
    /// Places between which W is smooth, first() to last().
    std::span<const double> places() const { return place_; }
    /// W of the component at s in [places()[piece], places()[piece + 1]].
    glm::dvec3 scattered(std::size_t component, std::size_t piece, double s) const;

private:
    struct Curve {
        glm::dvec3 value;          ///< W where the piece begins
        glm::vec3 rises, arrives;  ///< its slope there, and where the piece ends
    };
    std::size_t components_ = 0;
    std::vector<double> place_;
    std::vector<Curve> curve_;  ///< [piece * components + component]; of the last place only the value
};

}  // namespace dapple::methods::sliced_beams
