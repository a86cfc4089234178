#pragma once
#include <array>
#include <glm/glm.hpp>

#include "layout/mesh_cell.h"
#include "methods/caustic_mesh/picture_map.h"

namespace dapple::methods::caustic_mesh {

/// The image of a cell on a plane, or about it; triangles (0, 1, 2) and (0, 2, 3).
struct LandedCell {
    std::array<glm::vec3, 4> corner;  ///< m
    std::array<float, 4> flux;        ///< of a whole cell of the map with each corner as its middle
    /// Image of such a cell, m^2; 0: not known.
    std::array<float, 4> area{};
    std::array<glm::vec3, 4> power;  ///< what a unit of flux is at the corner, W, a channel
    float share = 1;                 ///< of a whole cell of the map
    glm::vec3 normal{0};             ///< unit, of the plane, against the beams
    glm::vec3 beam{0};               ///< unit, mean direction of travel
    float spacing = 0;               ///< m of the rays where they leave the water
    float disc = 0;                  ///< m, radius of the image of the sun's disc across the beam
};

/// How a cell is drawn. `lost`: it has light that the camera may see, and no size or brightness in float.
enum class Drawn { not_seen, as_point, as_quad, lost };

/// Makes landed cells into what is drawn, each with its flux: brightness is flux over area, at a corner that
/// of the cells about it, all corners together such that the cell has its flux.
class CellDrawing {
public:
    /// `largest_point`: pixels.
    CellDrawing(const scene::FrameScene& scene, bool in_water, float largest_point);

    /// Whether the camera may see the cell: by its corners, normal, beam and disc alone.
    bool seen(const LandedCell& cell) const;
    /// Pixels of its longest side; infinite where it reaches behind the camera.
    float width(const LandedCell& cell) const;
    /// Pixels that a filter about the cell reaches from its middle, about; 0 behind the camera.
    float filter(const LandedCell& cell) const;
    /// Of a cell that is seen. `widened`: it was thinner than a fiftieth of a pixel, and is drawn as a quad
    /// of that width.
    Drawn draw(const LandedCell& cell, layout::MeshCell& drawn, bool& widened) const;
    /// W, mean of the channels, that a cell brings to its plane, or a triangle of the paper's.
    static float carried(const LandedCell& cell, bool paper);
    /// A triangle of the paper's, corners 0 to 2, of one brightness, as thin as it is.
    Drawn draw_paper(const LandedCell& cell, layout::MeshCell& drawn) const;

private:
    bool widen(LandedCell& cell) const;
    static float disc_box(const LandedCell& cell);
    static float disc_reach(const LandedCell& cell);
    bool cover(const LandedCell& cell, PictureCover& box, PictureCover& tight) const;
    Drawn finish(const LandedCell& cell, layout::MeshCell& drawn) const;

    PictureMap picture_;
    bool in_water_;
    float largest_point_;
};

}  // namespace dapple::methods::caustic_mesh
