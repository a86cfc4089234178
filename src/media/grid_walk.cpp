#include "media/grid_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dapple::media {
namespace {

constexpr int kBlock = 8;  // cells along a block
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Density in one cell, trilinear between its corners.
class CellDensity {
public:
    CellDensity(const Line& line, const glm::ivec3& cell, const float (&corners)[8])
        : origin_(line.origin - glm::dvec3(cell)), direction_(line.direction), corners_(corners) {}

    double at(double t) const {
        const glm::dvec3 x = glm::clamp(origin_ + t * direction_, 0.0, 1.0);
        const auto mix = [](double a, double b, double share) { return a + share * (b - a); };
        const auto along_x = [&](int corner) {
            return mix(static_cast<double>(corners_[corner]), static_cast<double>(corners_[corner + 1]), x.x);
        };
        return mix(mix(along_x(0), along_x(2), x.y), mix(along_x(4), along_x(6), x.y), x.z);
    }

private:
    glm::dvec3 origin_, direction_;
    const float (&corners_)[8];
};

bool all_zero(const float (&corners)[8]) {
    return std::all_of(corners, corners + 8, [](float value) { return value == 0; });
}

}  // namespace

GridWalk::GridWalk(std::shared_ptr<const grids::DensityGrid> grid)
    : grid_(std::move(grid)), first_cell_(grid_->low() - 1), last_cell_(grid_->high()) {}

bool GridWalk::holds_density(const glm::ivec3& block, Reader& reader) const {
    if (const grids::CellBlocks* noted = grid_->cell_blocks()) return noted->at(block);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 reached = block + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
        if (!reader.block_is_empty(reached * kBlock)) return true;
    }
    return false;
}

/// Calls visit(cell, begin, end) for the cells that the part crosses, but those of empty blocks: Amanatides &
/// Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, 1987. A step changes one index by one, and where it
/// is made follows from the index alone, so that cells join without gaps and roundings do not add up.
template <class Visit>
void GridWalk::walk(const Line& line, Interval part, Reader& reader, Visit&& visit) const {
    if (part.empty()) return;
    const glm::dvec3 inverse = 1.0 / line.direction;
    glm::ivec3 step, cell, limit;
    glm::dvec3 next;  // m: where the line leaves the cell, by axis
    const auto place = [&](int axis, int plane) {
        return line.direction[axis] == 0 ? kInfinity : (plane - line.origin[axis]) * inverse[axis];
    };
    const glm::dvec3 start = line.at(part.begin);
    for (int axis = 0; axis < 3; ++axis) {
        step[axis] = line.direction[axis] < 0 ? -1 : 1;
        limit[axis] = step[axis] > 0 ? last_cell_[axis] + 1 : first_cell_[axis] - 1;
        cell[axis] =
            static_cast<int>(std::clamp(std::floor(start[axis]), static_cast<double>(first_cell_[axis]),
                                        static_cast<double>(last_cell_[axis])));
        next[axis] = place(axis, cell[axis] + (step[axis] > 0 ? 1 : 0));
    }
    const auto nearest_axis = [&] {
        return next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
    };
    double t = part.begin;
    glm::ivec3 block = cell >> 3;
    bool occupied = holds_density(block, reader);
    while (t < part.end) {
        if (!occupied) {
            // On to where the line leaves the block.
            const glm::ivec3 low = block * kBlock, high = low + (kBlock - 1);
            for (int axis = 0; axis < 3; ++axis)
                next[axis] = place(axis, step[axis] > 0 ? high[axis] + 1 : low[axis]);
            const int axis = nearest_axis();
            t = std::max(t, next[axis]);
            if (!(t < part.end)) return;
            const glm::dvec3 there = line.at(t);
            for (int other = 0; other < 3; ++other) {
                cell[other] =
                    static_cast<int>(std::clamp(std::floor(there[other]), static_cast<double>(low[other]),
                                                static_cast<double>(high[other])));
            }
            cell[axis] = step[axis] > 0 ? high[axis] + 1 : low[axis] - 1;
            if (step[axis] > 0 ? cell[axis] >= limit[axis] : cell[axis] <= limit[axis]) return;
            for (int other = 0; other < 3; ++other)
                next[other] = place(other, cell[other] + (step[other] > 0 ? 1 : 0));
        } else {
            const int axis = nearest_axis();
            const double end = std::min(std::max(t, next[axis]), part.end);
            if (end > t) visit(cell, t, end);
            t = end;
            cell[axis] += step[axis];
            if (cell[axis] == limit[axis]) return;
            next[axis] = place(axis, cell[axis] + (step[axis] > 0 ? 1 : 0));
        }
        const glm::ivec3 here = cell >> 3;
        if (here != block) {
            block = here;
            occupied = holds_density(block, reader);
        }
    }
}

/// Calls visit(piece) for the cells on the line that hold density.
template <class Visit>
void GridWalk::visit_pieces(const Line& line, Interval part, Visit&& visit) const {
    Reader reader(*grid_);
    Piece piece;
    float corners[8];
    walk(line, part, reader, [&](const glm::ivec3& cell, double begin, double end) {
        reader.cell(cell, corners);
        if (all_zero(corners)) return;
        const CellDensity density(line, cell, corners);
        // Density is the same on both sides of a face.
        const bool adjoins = piece.end == begin && piece.end > piece.begin;
        piece.first = adjoins ? piece.last : density.at(begin);
        piece.begin = begin;
        piece.end = end;
        piece.middle = density.at(0.5 * (begin + end));
        piece.last = density.at(end);
        visit(piece);
    });
}

double GridWalk::column(const Line& line, Interval part) const {
    double sum = 0;
    visit_pieces(line, part, [&](const Piece& piece) { sum += piece.column(); });
    return sum;
}

void GridWalk::append_pieces(const Line& line, Interval part, std::vector<Piece>& pieces) const {
    visit_pieces(line, part, [&](const Piece& piece) { pieces.push_back(piece); });
}

double GridWalk::density(const glm::dvec3& at) const {
    return static_cast<double>(Reader(*grid_).density(at));
}

}  // namespace dapple::media
