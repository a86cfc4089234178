#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "layout/coverage.h"
#include "methods/sliced_beams/tile.h"

namespace dapple::methods::sliced_beams {

/// Receivers that go through one list together.
constexpr std::size_t kBlockReceivers = 4;
/// Tiles whose lists would be longer stay on the CPU.
constexpr std::size_t kMostClusters = 1 << 13;
constexpr std::size_t kNoPixel = std::numeric_limits<std::size_t>::max();

/// What some tiles ask the device for, of one sheet, and either planar or curved: receivers in blocks of four
/// (the last of a tile may have fewer), a list of clusters a block. Indices are relative to this work.
struct CoverageWork {
    std::vector<layout::CoverageCluster> clusters;
    std::vector<layout::CoverageFrame> frames;  ///< planar: one a tile
    std::vector<layout::CoverageBlock> blocks;
    std::vector<std::uint32_t> list;             ///< indices of clusters
    std::vector<layout::PlanarReceiver> planar;  ///< either these
    std::vector<layout::CurvedReceiver> curved;  ///< or these, four a block
    std::vector<std::size_t> pixels;             ///< that they belong to, or kNoPixel; four a block
};

/// A tile's work, added to that of others.
class CoverageWorkBuilder {
public:
    /// `tile` has been through find(), and is plain().
    CoverageWorkBuilder(const Tile<float>& tile, std::span<const std::size_t> pixels);
    bool planar() const { return planar_; }
    std::size_t clusters() const { return tile_.clusters_.size(); }
    void add_to(CoverageWork& work) const;

private:
    void add_clusters(CoverageWork& work) const;
    void add_lists(CoverageWork& work, std::uint32_t first_cluster) const;
    void add_planar(CoverageWork& work) const;
    void add_curved(CoverageWork& work) const;

    const Tile<float>& tile_;
    std::span<const std::size_t> pixels_;
    bool planar_;
};

}  // namespace dapple::methods::sliced_beams
