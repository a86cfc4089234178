#pragma once
#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "layout/mesh_cell.h"
#include "light/beam_mesh.h"
#include "light/landing.h"
#include "media/media.h"
#include "methods/caustic_mesh/picture_map.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::caustic_mesh {

/// Cells of a stretch of the map that the camera may see, in its order, cut into the fixed bands of the loop.
struct Cells {
    std::vector<std::vector<layout::MeshCell>> points;  ///< a band each
    std::vector<std::vector<layout::MeshCell>> quads;   ///< those wider than a point sprite can be
    std::size_t cut = 0;       ///< cells of the map that were cut finer, at edges of objects or of cascades
    std::size_t widened = 0;   ///< cells drawn wider than they are, of those in `points` and `quads`
    std::size_t left_out = 0;  ///< triangles of the paper's that have no image on one surface
    std::size_t overfull = 0;  ///< cells that lie beside more faces than are lit by one
    double lost = 0;           ///< W, mean of the channels, of cells without size or brightness in float
};

/// Rays whose cells are held on the host at once, about.
inline constexpr std::size_t kStretch = std::size_t{1} << 19;

/// Turns landed rays into cells; `take` gets one stretch of the map after another. `largest_point`: pixels;
/// `paper`: as Ouyang & Yang 2020.
void build_cells(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                 const light::Landings& landings, const rays::RayScene& rays, float largest_point, bool paper,
                 const std::function<void(const Cells&)>& take);

}  // namespace dapple::methods::caustic_mesh
