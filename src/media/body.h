#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "media/grid_walk.h"
#include "media/ray_box.h"
#include "scene/frame_scene.h"

namespace dapple::media {

/// A bounded medium as a ray sees it: where it is and how dense, whatever the water cuts off.
class Body {
public:
    /// `medium` of the scene, an index into FrameState::media; it must not be empty.
    Body(const scene::FrameScene& scene, std::size_t medium);
    /// Whether there is anything of that medium.
    static bool is_empty(const scene::FrameScene& scene, std::size_t medium);

    /// The part of a segment that lies in the body's box. Positions are m relative to FrameScene::origin.
    Interval overlap(const glm::dvec3& origin, const glm::dvec3& direction, double length) const;
    /// Integral of the density along an overlap, m.
    double column(const glm::dvec3& origin, const glm::dvec3& direction, Interval overlap) const;
    /// Appends the overlap's pieces where density may be more than 0.
    void append_pieces(const glm::dvec3& origin, const glm::dvec3& direction, Interval overlap,
                       std::vector<Piece>& pieces) const;
    double density(const glm::dvec3& position) const;
    /// Whether it is a grid; a box is evenly dense.
    bool is_grid() const { return grid_.has_value(); }

    /// Where it lies: local = turn * position + shift is -1 to 1 in a box, the index of a grid.
    struct Place {
        glm::dmat3 turn;
        glm::dvec3 shift;
        glm::dvec3 low, high;  ///< of the box that holds it, local
        double density;        ///< of a box; factor of a grid's
    };
    const Place& place() const { return place_; }

    /// Of the box, m relative to FrameScene::origin.
    double least_y() const { return least_y_; }

private:
    Line local(const glm::dvec3& origin, const glm::dvec3& direction) const;

    Place place_;
    double least_y_;
    std::optional<GridWalk> grid_;
};

}  // namespace dapple::media
