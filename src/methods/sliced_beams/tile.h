#pragma once
#include <array>
#include <vector>

#include "methods/sliced_beams/polygon.h"
#include "methods/sliced_beams/sheet_coverage.h"

namespace dapple::methods::sliced_beams {

/// Where objects may stand in the light of a receiver's beams.
struct Shade {
    bool after = false;   ///< between the water and the receiver
    bool before = false;  ///< between the light and the water

    bool any() const { return after || before; }
};

/// Eight landed beams and what they bring, a lane each.
template <class Real>
struct LitCluster {
    LandedChunk<Real> landed[kChunks<Real>];
    Lanes<Real> red[kChunks<Real>], green[kChunks<Real>],
        blue[kChunks<Real>];  ///< W, after the water's extinction
    std::array<std::uint32_t, kClusterBeams> beam;
    Shade shade;  ///< where an object may stand in the beams' light: each is tested
    bool dimmed =
        false;  ///< bounded media may lie on some of the beams' ways: by where each meets a receiver
    bool cut_by_surface =
        false;  ///< a beam leaves the water beyond the receivers' plane with some of its rays
};

/// One query of a SheetCoverage: receivers near each other on one object. Finds the nodes of the pyramid that
/// can matter to any of them once, then goes through these for each receiver.
template <class Real>
class Tile {
public:
    Tile(const SheetCoverage<Real>& sheet, std::span<const Receiver<Real>> receivers, std::uint32_t object,
         std::span<Vec3<Real>> irradiance, QueryCounts& counts, std::span<std::uint8_t> hidden = {});
    void run() {
        if (find()) cover();
    }
    /// Finds what can matter to the receivers; false: nothing.
    bool find();
    /// Adds the light of what has been found.
    void cover();
    /// Whether what has been found is clusters only, without anything in the way of their light.
    bool plain() const {
        return sheet_.columns().empty() && nodes_.empty() && below_surface_ && free_after_ && free_before_;
    }

private:
    friend class CoverageWorkBuilder;

    using NodeId = typename BeamPyramid<Real>::NodeId;
    using Meets = typename BeamPyramid<Real>::Meets;
    struct Local {
        Receiver<Real> receiver;  ///< in the sheet's axes
        Real half_a, half_b, half_depth;
        Real inverse_area;  ///< 1/m^2
        std::size_t index;
        double narrow;  ///< area of the footprint as given, over that with the blur of the sun's disc
    };
    /// A beam's share of a receiver's light, if nothing stands in its way.
    struct Pair {
        std::size_t index;
        Vec3<Real> irradiance;
        glm::vec3 receiver_point, water_point;  ///< m, world axes relative to the frame's origin
        Shade shade;
    };
    /// Clusters landed on a plane, and their bounds there.
    struct LandedTile {
        std::vector<LitCluster<Real>> clusters;
        std::vector<Real> low_x, high_x, low_y,
            high_y;  ///< padded to whole registers by boxes that meet nothing
    };

    void place_receivers(std::span<const Receiver<Real>> receivers);
    void find_nodes(bool occluders);
    void widen_by_surface(NodeId node, Bounds (&surface)[2]) const;
    bool free_after(const Bounds (&surface)[2]) const;
    bool test_free();
    bool planar() const { return planar_; }
    bool share_a_plane() const;
    void count_parted();
    /// As BeamPyramid::meets, for a receiver whose footprint reaches down to `high`; none: none covers any of
    /// it.
    Meets meets(NodeId node, const Receiver<Real>& receiver, Real high) const;
    /// Where the node's beams can be, as landed on a receiver's plane, between two depths; empty where they
    /// cannot.
    Box<Real> box(NodeId node, const Receiver<Real>& receiver, Real low, Real high) const;
    /// The same for all receivers.
    Box<Real> box(NodeId node) const {
        return planar_ ? box(node, locals_.front().receiver, low_, high_)
                       : pyramid_.box(node, low_, high_, lean_);
    }
    void land_cluster(NodeId node, const LandingFrame<Real>& frame, LitCluster<Real>& lit);
    LandedTile land_all(std::size_t first, std::size_t count, const LandingFrame<Real>& frame);
    void add_planar();
    void add_landed(const LandedTile& tile, const LandingFrame<Real>& frame);
    void add_curved();
    void add_nodes(const Local& local);
    Vec3<Real> whole(const Local& local, NodeId node);
    /// Adds the cluster's light on a footprint, or the pairs to be tested. `at` moves landed beams to the
    /// receiver's footprint coordinates.
    template <class At>
    void add_cluster(const Local& local, const LitCluster<Real>& lit, Lanes<Real> (&power)[3], At&& at);
    void add_pair(const Local& local, const LitCluster<Real>& lit, int chunk, int lane,
                  const LandedBeams<Real>& beams, Real share, bool clipped);
    void settle_pairs();
    void trace(bool after);

    const SheetCoverage<Real>& sheet_;
    const BeamPyramid<Real>& pyramid_;
    std::span<Vec3<Real>> irradiance_;
    QueryCounts& counts_;
    std::span<std::uint8_t> hidden_;  ///< empty: nobody asks
    std::uint32_t object_;
    std::vector<Local> locals_;
    Box<Real> bounds_{};
    Real low_ = 0, high_ = 0;  ///< depths of the receivers
    Real lean_ = 0;            ///< largest change of depth a m across the axis on the receivers' planes
    Real least_a_ = 0, least_b_ = 0;  ///< extents of the smallest footprint
    bool below_surface_ = true;       ///< all receivers lie deeper than the starts of all beams found
    bool whole_allowed_ = false;
    bool planar_ = false;  ///< all receivers share a plane
    bool free_after_ = true, free_before_ = true;
    bool may_hide_itself_ = true;  ///< the receivers' object
    Bounds receivers_[2];          ///< in the sheet's axes and in the world's
    std::vector<NodeId> clusters_;
    std::vector<Shade> shade_;   ///< beside clusters_
    std::vector<NodeId> nodes_;  ///< above the finest level: smaller than the footprints
    std::vector<Pair> pairs_;
};

}  // namespace dapple::methods::sliced_beams
