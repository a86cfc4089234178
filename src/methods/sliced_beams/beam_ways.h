#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/stats.h"
#include "methods/sliced_beams/sheet_coverage.h"

namespace dapple::methods::sliced_beams {

/// What objects do to the beams of a sheet, before the water and after it, from a ray a vertex and sure tests
/// of what may stand between these.
template <class Real>
class BeamWays {
public:
    enum Shade : std::uint8_t {
        kDark = 1,         ///< one convex object keeps the light from all three vertices: no light at all
        kCut = 2,          ///< one convex object stops all three rays, nothing else is near: at stop()
        kMixedAfter = 4,   ///< an object may stand among the rays: points beyond free_depth() are tested
        kMixedBefore = 8,  ///< or among those from the light
    };

    static constexpr double kBytesAVertex = sizeof(Real) + 2 * sizeof(std::uint32_t);
    static constexpr double kBytesABeam = 1 + 2 * sizeof(Real) + 2 * sizeof(ObjectSet);

    /// References need not outlive this.
    explicit BeamWays(const SheetCoverage<Real>& sheet);

    bool empty() const { return shade_.empty(); }  ///< there is nothing in the way of any beam
    std::uint8_t shade(std::uint32_t beam) const { return empty() ? std::uint8_t{0} : shade_[beam]; }
    /// m along the axis, where an object stops a vertex's ray; infinite: none.
    Real stop(std::uint32_t vertex) const { return stop_[vertex]; }
    Real free_depth(std::uint32_t beam) const { return free_depth_[beam]; }
    /// Of a mixed beam.
    struct Blockers {
        ObjectSet after = 0, before = 0;  ///< that may stand among the rays after the water, and before it
    };
    const Blockers& blockers(std::uint32_t beam) const { return blockers_[beam]; }
    /// Depth beyond which a beam has no light, a beam; empty: none has one.
    std::span<const Real> last_depths() const { return last_depth_; }
    void report(FrameStats& stats) const;

private:
    BeamWays() = default;
    void trace_before(const SheetCoverage<Real>& sheet);
    void trace_after(const SheetCoverage<Real>& sheet);
    void judge(const SheetCoverage<Real>& sheet);

    std::vector<Real> stop_;
    std::vector<std::uint32_t> stopped_by_, hidden_by_;  ///< a vertex: object or kNoObject
    std::vector<std::uint8_t> shade_;
    std::vector<Real> free_depth_, last_depth_;
    std::vector<Blockers> blockers_;
};

extern template class BeamWays<float>;
extern template class BeamWays<double>;

}  // namespace dapple::methods::sliced_beams
