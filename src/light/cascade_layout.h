#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/frame_state.h"

namespace dapple::light {

using Places = glm::vec<2, std::int64_t>;

/// How a photon's light fills the rest plane about it, which decides what sums to one where cascades pass
/// into each other.
enum class PhotonCells {
    tents,  ///< falling to nothing at its neighbours: interpolated linearly between photons
    boxes,  ///< even over its texel
};

/// One cascade on the rest plane. Its photons have places k (whole numbers along x and z) at base + k texel.
struct CascadeBox {
    double size = 0;         ///< m, as asked for
    glm::dvec2 texel{0};     ///< m along x and z
    std::int64_t ratio = 1;  ///< texels of the next coarser cascade over those of this one
    /// Places of the next coarser cascade at which this box ends: there light is the coarser one's alone. Of
    /// the outermost, its own first place and the one after its last.
    Places low{0}, high{0};
    std::int64_t ramp = 1;  ///< steps of the coarser cascade from there to where light is this one's alone
};

/// Where cascades lie, whatever the light. Texels are whole multiples of those of the next finer cascade and
/// divide the water's extent, to which all are anchored, so that places do not move with the camera. Where
/// photons are tents every photon's place in a coarser cascade is a photon's place in all finer ones; where
/// they are boxes the texels of all finer ones tile each coarser one.
struct CascadeLayout {
    PhotonCells cells = PhotonCells::tents;
    glm::dvec2 corner{0};           ///< m, the extent's lower corner
    double first = 0.5;             ///< texels of the outermost from there to its place (0, 0)
    Places extent_texels{0};        ///< of the outermost across the extent
    std::vector<CascadeBox> boxes;  ///< the innermost first; fewer than asked for where those hold all water
    bool whole = true;              ///< the outermost holds all the water
    /// Texels of the outermost cascade over those of this one.
    std::int64_t multiple(std::size_t cascade) const;
    glm::dvec2 margin(std::size_t cascade) const;  ///< m from `corner` to the cascade's place (0, 0)
    /// m, world (x, z) of the cascade's place (0, 0).
    glm::dvec2 base(std::size_t cascade) const { return corner + margin(cascade); }
};

/// Box c is as wide as the inner one times cascade_scale^c. Texels follow its width over its resolution as
/// closely as whole ratios let them, whatever the scale.
CascadeLayout lay_out_cascades(const scene::FrameState& state, const scene::CausticMapParameters& parameters,
                               PhotonCells cells = PhotonCells::tents);

/// Share along one axis (0: x, 1: z) of the light at place `k` of the coarser cascade that the box and those
/// inside it carry: from 0 at its ends to 1 over `ramp` steps, two parabolas, the second differences of which
/// are the least. Between places it is linear; its product over both axes is so reproduced exactly by tents
/// on the coarser and on the finer photons alike.
double inner_share(const CascadeBox& box, int axis, std::int64_t k);
/// The same at place `k` of the cascade itself: of boxes that of the coarser one's texel that it lies in, so
/// that the boxes of both add up at every point.
double own_inner_share(const CascadeBox& box, PhotonCells cells, int axis, std::int64_t k);

/// Photons along each side of a cascade's box, `size` m wide.
double cascade_resolution(const scene::CausticMapParameters& parameters, std::size_t cascade, double size);

/// Side of the innermost box, m.
double inner_box_size(const scene::FrameState& state, const scene::CausticMapParameters& parameters);

/// World (x, z) that the boxes are asked to lie about.
glm::dvec2 cascade_center(const scene::FrameState& state, const scene::CausticMapParameters& parameters);

}  // namespace dapple::light
