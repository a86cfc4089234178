#pragma once
#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "base/large_vector.h"
#include "layout/splat.h"
#include "light/beam_mesh.h"
#include "light/landing.h"
#include "media/media.h"
#include "methods/photon_splatting/footprint.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// Of a stretch of the mesh, about; their splats stay in the processor's cache. Wide maps have eight rows.
inline constexpr std::size_t kStretchPhotons = 1 << 17;

/// Splats that the camera may see, of a stretch of the mesh, cut into the fixed bands of the loop.
struct Splats {
    std::vector<LargeVector<layout::Splat>> points;  ///< a band each
    std::vector<LargeVector<layout::Splat>> quads;   ///< those wider than a point sprite can be
    std::size_t without_neighbors =
        0;            ///< landed rays alone on their sheet of the water in a direction of the grid
    double lost = 0;  ///< W, mean of the channels: of footprints without area, which cannot be drawn
};

/// Turns landed photons into splats with the style's footprints on the tangent planes of their landing
/// points, and hands them over a stretch of the mesh after another, in a fixed order. What is handed over is
/// used again for the next. `largest_point`: pixels.
void build_splats(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                  const light::Landings& landings, const SplatStyle& style, float largest_point,
                  const std::function<void(const Splats&)>& take);

}  // namespace dapple::methods
