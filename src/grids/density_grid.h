#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

namespace dapple::grids {

/// Which aligned blocks of 8 x 8 x 8 cells hold density: those whose cells reach a voxel that is active. The
/// cell (i, j, k) lies between voxels (i, j, k) and (i + 1, j + 1, k + 1).
struct CellBlocks {
    glm::ivec3 first{0};
    glm::ivec3 count{0};
    std::vector<std::uint64_t> occupied;  ///< a bit each, x fastest

    /// Of a block (the cell's index over 8) from `first` on.
    bool at(const glm::ivec3& block) const {
        const std::size_t i = index(block);
        return (occupied[i / 64] >> (i % 64) & 1) != 0;
    }
    std::size_t index(const glm::ivec3& block) const {
        const glm::ivec3 at = block - first;
        return (static_cast<std::size_t>(at.z) * static_cast<std::size_t>(count.y) +
                static_cast<std::size_t>(at.y)) *
                   static_cast<std::size_t>(count.x) +
               static_cast<std::size_t>(at.x);
    }
};

/// Density on a sparse grid of voxels, immutable and shared. Voxel (i, j, k) is a point sample at index
/// position (i, j, k); between samples density is trilinear, and 0 beyond one voxel around the active ones.
/// Values are finite and not negative; voxels are active where they are positive.
class DensityGrid {
public:
    /// cell_blocks() are known of boxes of at most so many blocks, a bit each.
    static constexpr std::size_t kMostBlocks = std::size_t{1} << 24;

    /// `values` are size.x * size.y * size.z densities, x fastest, the first at voxel `low`; zeros are not
    /// stored. Throws Error(input_unreadable) on values that are negative or not finite.
    static std::shared_ptr<const DensityGrid> from_values(glm::ivec3 low, glm::ivec3 size,
                                                          std::span<const float> values,
                                                          const glm::dmat4& file_from_index,
                                                          std::size_t most_blocks = kMostBlocks);
    virtual ~DensityGrid() = default;

    /// Affine: positions in the file's own world, in the file's units (taken as metres).
    const glm::dmat4& file_from_index() const { return file_from_index_; }
    /// First and last active voxel, both included; low > high where none is.
    glm::ivec3 low() const { return low_; }
    glm::ivec3 high() const { return high_; }
    bool empty() const { return low_.x > high_.x; }
    float maximum() const { return maximum_; }
    std::size_t active_voxels() const { return active_voxels_; }
    std::size_t bytes() const { return bytes_; }
    /// Of all cells with an active voxel; null where the grid is empty or there would be too many.
    const CellBlocks* cell_blocks() const { return blocks_.occupied.empty() ? nullptr : &blocks_; }

    /// Reads single voxels, remembering where it was: one a thread. The grid outlives it. Cheap to make: it
    /// allocates nothing.
    class Reader {
    public:
        explicit Reader(const DensityGrid& grid);
        Reader(const Reader&) = delete;
        Reader& operator=(const Reader&) = delete;
        /// Of a voxel; 0 where there is none.
        float voxel(glm::ivec3 at);
        /// Trilinear, at an index position.
        float density(const glm::dvec3& at);
        /// The eight voxels about a cell whose least corner is `cell`: value [x + 2 y + 4 z].
        void cell(glm::ivec3 cell, float (&corners)[8]);
        /// Whether the aligned block of 8 x 8 x 8 voxels that holds `at` has none that is active; then all of
        /// it is 0.
        bool block_is_empty(glm::ivec3 at);

    private:
        struct State;
        /// Room for the state, whose type is the grid library's.
        alignas(16) std::array<std::byte, 192> room_;
        State* state_ = nullptr;  ///< null for an empty grid
    };

protected:
    DensityGrid() = default;
    glm::dmat4 file_from_index_{1.0};
    glm::ivec3 low_{0};
    glm::ivec3 high_{-1};
    float maximum_ = 0;
    std::size_t active_voxels_ = 0;
    std::size_t bytes_ = 0;
    CellBlocks blocks_;
};

}  // namespace dapple::grids
