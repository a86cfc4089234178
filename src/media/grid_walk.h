#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <mutex>
#include <vector>

#include "grids/density_grid.h"
#include "media/ray_box.h"

namespace dapple::media {

/// A part of a line on which a density is a polynomial of degree three at most.
struct Piece {
    double begin = 0;  ///< m along the line
    double end = 0;
    double first = 0;  ///< density just after `begin`
    double middle = 0;
    double last = 0;  ///< just before `end`
    /// Its integral, by Simpson's rule, which is exact for cubics.
    double column() const { return (end - begin) / 6 * (first + 4 * middle + last); }
};

/// A grid made ready for lines through it, which are given in its index space.
class GridWalk {
public:
    using Reader = grids::DensityGrid::Reader;

    /// Which of its blocks are empty is noted where there are at most so many, a byte each, else asked for.
    static constexpr std::size_t kMostBlocks = std::size_t{1} << 24;

    explicit GridWalk(std::shared_ptr<const grids::DensityGrid> grid, std::size_t most_blocks = kMostBlocks);

    /// The box beyond which density is 0, in index space.
    glm::dvec3 low() const { return glm::dvec3(first_cell_); }
    glm::dvec3 high() const { return glm::dvec3(last_cell_ + 1); }

    /// Integral of the density along a part of the line that lies in the box.
    double column(const Line& line, Interval part) const;
    /// Appends its pieces where there is density, a cell each, in order, without overlap.
    void append_pieces(const Line& line, Interval part, std::vector<Piece>& pieces) const;
    double density(const glm::dvec3& at) const;

private:
    /// Which blocks of 8 x 8 x 8 cells hold density: those whose cells reach a voxel that is active.
    struct Blocks {
        glm::ivec3 first{0};
        glm::ivec3 count{0};
        std::vector<std::uint8_t> occupied;  ///< x fastest; none where there would be too many: readers know
        std::size_t index(const glm::ivec3& block) const {
            const glm::ivec3 at = block - first;
            return (static_cast<std::size_t>(at.z) * static_cast<std::size_t>(count.y) +
                    static_cast<std::size_t>(at.y)) *
                       static_cast<std::size_t>(count.x) +
                   static_cast<std::size_t>(at.x);
        }
    };

    /// A reader for one call, from those that earlier calls gave back.
    class Lease;

    template <class Visit>
    void walk(const Line& line, Interval part, Reader& reader, Visit&& visit) const;
    template <class Visit>
    void visit_pieces(const Line& line, Interval part, Visit&& visit) const;
    void find_blocks(std::size_t most_blocks);
    bool holds_density(const glm::ivec3& block, Reader& reader) const;

    std::shared_ptr<const grids::DensityGrid> grid_;
    glm::ivec3 first_cell_{0};
    glm::ivec3 last_cell_{-1};
    Blocks blocks_;
    mutable std::mutex idle_lock_;
    mutable std::vector<std::unique_ptr<Reader>> idle_;
};

}  // namespace dapple::media
