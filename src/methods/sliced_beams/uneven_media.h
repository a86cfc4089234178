#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "media/media.h"
#include "methods/sliced_beams/sheet_coverage.h"

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

/// Columns of the bounded media along the rays of a sheet after the water, made once a frame for the rays
/// that may meet one: so many points a ray, interpolated linearly.
template <class Real>
class RayColumns {
public:
    RayColumns(const media::Media& media, const SheetCoverage<Real>& sheet);

    bool empty() const { return first_.empty(); }
    /// Whether a beam's rays are dimmed by more than the water.
    bool dims(const glm::uvec3& vertices) const {
        return !empty() &&
               (first_[vertices.x] != kNone || first_[vertices.y] != kNone || first_[vertices.z] != kNone);
    }
    /// Optical depth of the bounded media, a channel, along a mean of three rays, down to a depth along the
    /// axis from where each leaves the water.
    glm::dvec3 optical_depth(const glm::uvec3& vertices, const glm::dvec3& weights, double depth) const;
    std::size_t bytes() const {
        return first_.size() * sizeof(std::uint32_t) + columns_.size() * sizeof(float);
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::size_t kPoints = 48;

    std::size_t media_ = 0;               ///< bounded ones
    std::vector<glm::dvec3> extinction_;  ///< /m, of each where its density is 1
    std::vector<std::uint32_t> first_;    ///< a vertex: where its entry begins, or kNone
    std::vector<float> columns_;  ///< an entry: first depth from there, step, kPoints columns of each medium
};

extern template class RayColumns<float>;
extern template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
