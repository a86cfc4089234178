#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "light/beam_mesh.h"
#include "light/cascade_layout.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// Bytes of the map's texels that are brought back from the device at once, but for wider maps, of which it
/// is a row.
inline constexpr std::size_t kTexelBatchBytes = std::size_t{4} << 20;

/// The light-view raster of the water (Kougianos & Moustakas 2021, section 3: caustic map) and the beam
/// meshes made from it. Map coordinates are the rest plane y = 0, onto which the light projects
/// the water (in parallel for a sun, centrally for point and spot lights), so that texels stay in place while
/// waves and light move and flat water fills whole texels exactly.
class CausticMapper {
public:
    explicit CausticMapper(gpu::Device& device);
    ~CausticMapper();

    /// Beam meshes of one light: of each cascade, the innermost first, one for each of the events asked for.
    /// Rays that an object shadows on their way from the light to the water have flux 0.
    std::vector<BeamMesh> trace(const scene::FrameScene& scene, const rays::RayScene& rays, int light,
                                const std::vector<Event>& events,
                                const scene::CausticMapParameters& parameters, FrameStats& stats);
    /// The same, handed over a cascade at a time, in the same order: no more than one map and its meshes take
    /// memory. It is used again for the next ones, in the next frame too. `cells`: what cascades' photons are
    /// made into.
    void trace_each(const scene::FrameScene& scene, const rays::RayScene& rays, int light,
                    const std::vector<Event>& events, const scene::CausticMapParameters& parameters,
                    PhotonCells cells, FrameStats& stats,
                    const std::function<void(std::span<BeamMesh>)>& take);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::light
