#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <span>

namespace dapple::grids {

/// Density on a sparse grid of voxels, immutable and shared. Voxel (i, j, k) is a point sample at index
/// position (i, j, k); between samples density is trilinear, and 0 beyond one voxel around the active ones.
/// Values are finite and not negative; voxels are active where they are positive.
class DensityGrid {
public:
    /// `values` are size.x * size.y * size.z densities, x fastest, the first at voxel `low`; zeros are not
    /// stored. Throws Error(input_unreadable) on values that are negative or not finite.
    static std::shared_ptr<const DensityGrid> from_values(glm::ivec3 low, glm::ivec3 size,
                                                          std::span<const float> values,
                                                          const glm::dmat4& file_from_index);
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

    /// Reads single voxels, remembering where it was: one a thread. The grid outlives it.
    class Reader {
    public:
        explicit Reader(const DensityGrid& grid);
        ~Reader();
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
        std::unique_ptr<State> state_;
    };

protected:
    DensityGrid() = default;
    glm::dmat4 file_from_index_{1.0};
    glm::ivec3 low_{0};
    glm::ivec3 high_{-1};
    float maximum_ = 0;
    std::size_t active_voxels_ = 0;
    std::size_t bytes_ = 0;
};

}  // namespace dapple::grids
