#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "methods/sliced_beams/beam_slices.h"
#include "methods/sliced_beams/scatter_sheet.h"

namespace dapple::methods::sliced_beams {

/// One query of a ScatterSheet: finds the intervals of a group of segments in its beams (scatter_query.cpp)
/// and adds up the light of each (scatter_piece.cpp).
template <class Real>
class ScatterQuery {
public:
    using L = Lanes<Real>;
    using Ways = BeamWays<Real>;

    ScatterQuery(const ScatterSheet<Real>& sheet, const SegmentLanes<Real>& segments,
                 const LightDirection<Real>& direction, const EvenMedium<Real>& medium,
                 const UnevenGroup<Real>* uneven, L (&radiance)[3], ScatterCounts& counts)
        : sheet_(sheet),
          segments_(segments),
          direction_(direction),
          medium_(medium),
          uneven_(uneven),
          radiance_(radiance),
          target_(&radiance),
          counts_(counts),
          color_(sheet.coverage_.sheet().color),
          whole_(uneven ? uneven->phases.size() : 0),
          scattered_(whole_.size()) {}

    void run();

private:
    void take_part(const L& from, const L& to, const Mask<Real>& met);

    void add_cluster(const BeamCluster<Real>& cluster, const Mask<Real>& met);

    /// Whether all of the part is below the surface, and before objects that stop a cluster's beams.
    bool lies_free(const BeamCluster<Real>& cluster, const Mask<Real>& met) const;
    /// The same of a piece in the beam.
    bool lies_free(const L& enter, const L& leave, const Mask<Real>& mask) const;

    /// Takes what lies beyond the surface and before the stop, both linear over the beam's slices: a point
    /// is, where a cubic, the edges' areas times the corners' distances, has the sign of the area.
    void cut_piece(const L& enter, const L& leave, const Mask<Real>& mask);

    void take_piece(const L& enter, const L& leave, const Mask<Real>& mask);

    void add_lit(const L& enter, const L& leave, const Mask<Real>& mask) {
        if (by_moments_)
            add_moments(enter, leave, mask);
        else
            add_piece(enter, leave, mask);
    }

    /// Where an object may stand among a beam's rays.
    void add_shadowed(const L& enter, const L& leave, const Mask<Real>& mask);

    /// A part of it across which the beam is about evenly wide.
    void add_shadowed_part(const L& enter, const L& leave, const Mask<Real>& mask);

    /// Quarter by quarter, tested by rays: among all kinds of objects.
    void add_traced(const L& enter, const L& leave, const Mask<Real>& mask);

    void settle_pairs();

    /// Drops the pairs that an object hides after the water, or before it.
    void trace(bool after);

    /// The ray through a point of the beam.
    struct BeamRay {
        L slope_a, slope_b, start;
        L share[3];  ///< of the beam's rays in it
    };
    BeamRay ray(const L& t) const;
    /// The same where the beam is about evenly wide, by one over twice its area there.
    BeamRay ray(const L& t, const L& inverse_area) const;
    BeamRay mixed(const L& second, const L& third) const;
    /// It, and what it loses and scatters.
    struct Node {
        L path;          ///< m from the water to the point, and back to the segment's near end
        L stretch;       ///< m of way a m of depth
        L squared_sine;  ///< of half the angle between the ways before and after
    };
    Node node(const L& t) const { return node(t, ray(t)); }
    Node node(const L& t, const BeamRay& ray) const;

    /// Whether light is dimmed so alike on all ways over a cluster that a few moments of them tell it:
    /// prepares them, together with those of clusters before where these are near.
    bool begin_moments(const BeamCluster<Real>& cluster, const Mask<Real>& met);
    void add_moments(const L& enter, const L& leave, const Mask<Real>& mask);
    void settle_moments();

    void add_piece(const L& enter, const L& leave, Mask<Real> mask);

    /// Cut where nothing is left of the light, and into parts.
    void add_thick(L enter, L leave, const L& from, const L& to, const Mask<Real>& mask);

    /// Weights of the nodes for the integral over the interval's [-1, 1].
    void weigh(const L& middle, const L& half, const Mask<Real>& mask, L (&weight)[3]);

    void add_thin(const L& enter, const L& leave, const Mask<Real>& mask);

    /// Most intervals are so short that hardly anything changes along them: there two nodes do. False: on
    /// this one they do not.
    bool add_even(const L& enter, const L& leave, const Mask<Real>& mask);

    /// Nodes of Gauss & Legendre's rule, of two, and weights of them; false: see add_even.
    bool weigh_even(const L& middle, const L& half, const Mask<Real>& mask, Node (&nodes)[2], L (&weight)[2]);

    template <int kCount>
    void gather(const Node (&nodes)[kCount], const L (&weight)[kCount], const L& half,
                const Mask<Real>& mask);

    template <int kCount>
    void sum_up(const Node (&nodes)[kCount], L (&weight)[kCount], const L& half, const Mask<Real>& mask);

    /// Segments through bounded media, or beams that they dim.
    void add_uneven(const L& enter, const L& leave, Mask<Real> mask);

    /// Most intervals are so short that what is scattered on all of them, the mean of one over the area, and
    /// the rest at the centroid are enough. Returns the lanes of which it is so.
    Mask<Real> add_whole(const L& enter, const L& leave, const Mask<Real>& mask);

    /// Piece by piece of what a segment scatters, each with the exact integral of one over the area and the
    /// rest at its centroid.
    void add_pieces(const L& enter, const L& leave, int lane);

    void add_part(const SegmentScatter& scatter, std::size_t piece, double from, double to, int lane,
                  double (&light)[3]);

    const ScatterSheet<Real>& sheet_;
    const SegmentLanes<Real>& segments_;
    const LightDirection<Real>& direction_;
    const EvenMedium<Real>& medium_;
    const UnevenGroup<Real>* uneven_;
    L (&radiance_)[3];
    L (*target_)[3];  ///< of add_piece: radiance_, or what is to be tested first
    ScatterCounts& counts_;
    Vec3<Real> color_;  ///< of the beam, tinted

    SegmentParts<Real> part_{};
    L middle_{}, half_{};                                 ///< of the part, m along the segments
    BeamCorner<Real> corners_[BeamCluster<Real>::kMost];  ///< of a cluster
    ClusterSlices<Real> cluster_;
    BeamCorner<Real> corner_[3];        ///< of a beam
    const Quadratic<Real>* edge_[3]{};  ///< of the beam, but for signs: those that face its corners
    Quadratic<Real> area_;              ///< m^2, twice the beam's
    std::uint32_t beam_ = 0;
    std::uint8_t shade_ = 0;  ///< of the beam
    Real flux_ = 0;           ///< of the beam, doubled as its area is
    static constexpr int kMoments = 5;
    bool by_moments_ = false;
    Mask<Real> has_moments_{};  ///< lanes
    L mean_path_{};             ///< m, about which moments are taken
    L moments_[kMoments]{};     ///< of some clusters' light, undimmed, per path^i

    /// Light of a part of an interval, if nothing stands in its way.
    struct Pair {
        int lane;
        Vec3<Real> light;
        glm::vec3 point, water;  ///< m, world axes relative to the frame's origin
        bool after, before;
    };
    std::vector<Pair> pairs_;
    struct ChannelLanes {
        L channel[3];
    };
    std::vector<ChannelLanes> whole_;    ///< a component: scattered on intervals
    std::vector<glm::dvec3> scattered_;  ///< a component, of one part
    std::size_t piece_[kLanes<Real>]{};  ///< of a segment, that was asked for last
};

}  // namespace dapple::methods::sliced_beams
