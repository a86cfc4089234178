#pragma once
#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include "media/media.h"
#include "methods/sliced_beams/beam_cluster.h"
#include "methods/sliced_beams/beam_ways.h"
#include "methods/sliced_beams/phase_table.h"
#include "methods/sliced_beams/scatter_bounds.h"
#include "methods/sliced_beams/sheet_coverage.h"
#include "methods/sliced_beams/uneven_media.h"

namespace dapple::methods::sliced_beams {

/// What finding scattered light cost.
struct ScatterCounts {
    std::size_t clusters = 0;      ///< times segments, of those that may hold them
    std::size_t beams = 0;         ///< times segments, tested
    std::size_t intervals = 0;     ///< of a segment within a beam
    std::size_t peaks = 0;         ///< of them: where the beam narrows so much that exact moments are needed
    std::size_t cut = 0;           ///< of them: by the water's surface or where an object stops the beam
    std::size_t shadow_tests = 0;  ///< of a place's way to the light, against planes, boxes and spheres
    std::size_t shadow_rays = 0;   ///< of those that meshes may stand in, too
    std::size_t foci = 0;          ///< of them: whose area is lost in rounding within, by mere point values
    std::size_t dropped = 0;       ///< channels of them that are not finite: left out

    void add(const ScatterCounts& other);
    void report(FrameStats& stats) const;
};

/// The water itself, or any medium of even density.
template <class Real>
struct EvenMedium {
    EvenMedium() = default;
    EvenMedium(const glm::dvec3& extinction_, const glm::dvec3& scattering_, const PhaseTable<Real>& phase_)
        : phase(&phase_) {
        for (int c = 0; c < 3; ++c) {
            extinction[c] = static_cast<Real>(extinction_[c]);
            scattering[c] = static_cast<Real>(scattering_[c]);
        }
        most = std::max({extinction[0], extinction[1], extinction[2]});
        least = std::min({extinction[0], extinction[1], extinction[2]});
    }

    Real extinction[3], scattering[3];  ///< /m, a channel
    Real most, least;                   ///< of the extinctions
    const PhaseTable<Real>* phase;
};

/// Segments near each other, a lane each, in world axes relative to FrameScene::origin, m.
template <class Real>
struct SegmentGroup {
    Lanes<Real> origin[3], direction[3];
    Lanes<Real> length;  ///< < 0: no segment
};

/// One direction of the light of a sheet: of the sun's disc, or of a lamp the only one.
template <class Real>
struct LightDirection {
    glm::vec<2, Real> shift{0, 0};  ///< m a m of way along the axis below the surface
    glm::vec3 to_sun{0, 0, 0};      ///< unit; 0: a lamp
};

/// What segments that may meet bounded media scatter, a lane each.
template <class Real>
struct UnevenGroup {
    SegmentScatter scatter[kLanes<Real>];
    Mask<Real> uneven{};  ///< lanes of which it is to be taken; others', where a beam is dimmed
    std::span<const PhaseTable<Real>> phases;  ///< of all components
};

/// One beam sheet, ready to be asked for the light that a medium scatters out of its beams: along each
/// segment the intervals within beams from quadratics, and on these product quadrature with the exact moments
/// of one over the beam's area (the flux's density). No sampling, no tolerance.
template <class Real>
class ScatterSheet {
public:
    /// All references outlive this.
    explicit ScatterSheet(const SheetCoverage<Real>& sheet);

    /// Adds what reaches the segments' near ends, W/m^2/sr, of light of one direction, which stands for all
    /// of the sheet's. Thread-safe.
    /// `medium`: on the sheet's side of the water; `uneven` null where there are no bounded media on it.
    void add(const SegmentGroup<Real>& segments, const LightDirection<Real>& direction,
             const EvenMedium<Real>& medium, const UnevenGroup<Real>* uneven, Lanes<Real> (&radiance)[3],
             ScatterCounts& counts) const;

    /// Leaves out all beams but those among whose rays an object may stand: the others' light is found
    /// elsewhere. False where none is left.
    bool keep_mixed();

    /// That of a point of the unit disc.
    LightDirection<Real> direction(glm::dvec2 disc) const;
    /// W a channel of beams that are flat at all depths: no segment meets them.
    glm::dvec3 collapsed() const;
    /// In the sheet's axes.
    SegmentLanes<Real> in_sheet(const SegmentGroup<Real>& group) const;
    const SheetCoverage<Real>& coverage() const { return coverage_; }
    const BeamWays<Real>& ways() const { return ways_; }
    const ScatterBounds<Real>& bounds() const { return bounds_; }
    const std::vector<BeamCluster<Real>>& clusters() const { return clusters_; }

private:
    template <class>
    friend class ScatterQuery;

    const SheetCoverage<Real>& coverage_;
    BeamWays<Real> ways_;
    ScatterBounds<Real> bounds_;
    std::vector<BeamCluster<Real>> clusters_;
    ShadowShapes<Real> shapes_;
};

extern template class ScatterSheet<float>;
extern template class ScatterSheet<double>;

}  // namespace dapple::methods::sliced_beams
