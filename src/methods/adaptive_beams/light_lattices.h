#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "layout/beam_media.h"
#include "media/media.h"
#include "methods/adaptive_beams/beam_set.h"
#include "methods/adaptive_beams/media_columns.h"

namespace dapple::methods::adaptive_beams {

/// Bytes of the columns along all rays of a frame's beams, and of those rays, at most; but for what the
/// coarsest take.
constexpr std::uint64_t kLightColumnBytes = std::uint64_t{512} << 20;
/// And these of a beam, for so many grids.
std::uint64_t least_column_bytes(std::size_t grids);

/// Voxels of each of the media's parts that lines cross at most, in air and in water.
using VoxelsCrossed = std::array<std::vector<double>, 2>;

/// The rays of a set's beams along which columns of grids are found: a lattice in each beam
/// (layout::BeamRays).
struct LightLattices {
    /// Of a beam, along an edge.
    static constexpr std::uint32_t kMostCells = 8;

    const BeamSet* set;
    /// The cells that put a beam's rays two voxels apart; from thin_out() on, the rays that it has. None of
    /// beams that meet no grid.
    std::vector<layout::BeamRays> beams;
    std::vector<float> voxels;                 ///< a beam: that a ray of it crosses of a grid at most
    std::uint64_t count[kMostCells + 1] = {};  ///< of the beams that want so many cells, or more
    std::uint32_t most = kMostCells;           ///< cells along an edge

    /// With so many cells at most.
    std::uint64_t lines(std::uint32_t cells) const;
    std::uint64_t lines() const { return lines(most); }
};

/// What the beams of a set want; `voxels` grows to what their rays cross.
LightLattices light_lattices(const BeamSet& set, const media::Media& media, const MediaColumns& columns,
                             std::vector<double>& voxels);

/// The tables of what light meets of grids in air and in water, for all beams of a frame.
struct LightTables {
    std::array<ColumnTable, 2> tables;
    /// Beams whose rays are farther apart than two voxels, or places on them than one: there are many beams,
    /// or they are wide.
    std::size_t thinned = 0;
};

/// Chooses cells and places so that buffers can be bound and all is within the budget, and gives each beam
/// its rays. Where room is short rays and places on them are thinned together, so that neither is much
/// coarser than the other.
LightTables thin_out(std::span<LightLattices> all, const MediaColumns& columns, const VoxelsCrossed& voxels,
                     std::uint64_t largest_buffer);

/// The rays themselves.
void write_lines(const LightLattices& lattices, std::span<layout::MediaLine> lines);

}  // namespace dapple::methods::adaptive_beams
