#pragma once
#include <glm/glm.hpp>
#include <memory>
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

    explicit GridWalk(std::shared_ptr<const grids::DensityGrid> grid);

    /// The box beyond which density is 0, in index space.
    glm::dvec3 low() const { return glm::dvec3(first_cell_); }
    glm::dvec3 high() const { return glm::dvec3(last_cell_ + 1); }

    /// Integral of the density along a part of the line that lies in the box.
    double column(const Line& line, Interval part) const;
    /// Appends its pieces where there is density, a cell each, in order, without overlap.
    void append_pieces(const Line& line, Interval part, std::vector<Piece>& pieces) const;
    double density(const glm::dvec3& at) const;

private:
    template <class Visit>
    void walk(const Line& line, Interval part, Reader& reader, Visit&& visit) const;
    template <class Visit>
    void visit_pieces(const Line& line, Interval part, Visit&& visit) const;
    /// Whether a block of 8 x 8 x 8 cells does.
    bool holds_density(const glm::ivec3& block, Reader& reader) const;

    std::shared_ptr<const grids::DensityGrid> grid_;
    glm::ivec3 first_cell_{0};
    glm::ivec3 last_cell_{-1};
};

}  // namespace dapple::media
