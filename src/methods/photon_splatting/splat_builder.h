#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "layout/splat.h"
#include "light/beam_mesh.h"
#include "light/landing.h"
#include "media/media.h"
#include "methods/photon_splatting/footprint.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// Splats that the camera may see, in the order of the mesh's vertices, cut into the fixed bands of the loop.
struct Splats {
    std::vector<std::vector<layout::Splat>> points;  ///< a band each
    std::vector<std::vector<layout::Splat>> quads;   ///< those wider than a point sprite can be
    std::size_t without_neighbors =
        0;  ///< landed rays alone on their sheet of the water in a direction of the grid
};

/// Turns landed photons into splats with the style's footprints on the tangent planes of their landing
/// points. `largest_point`: pixels.
Splats build_splats(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                    const light::Landings& landings, const SplatStyle& style, float largest_point);

}  // namespace dapple::methods
