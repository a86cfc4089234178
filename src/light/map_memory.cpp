#include "light/map_memory.h"

#include <algorithm>
#include <cmath>

#include "light/beam_mesh.h"
#include "light/cascade_plan.h"
#include "light/caustic_map.h"
#include "ocean/water_surface.h"

namespace dapple::light {
namespace {

/// Height above which the water does not reach, m, and below; infinite where only the mesh tells.
double highest_water(const scene::WaterSurface& surface) {
    switch (surface.type) {
        case scene::WaterSurfaceType::waves: {
            double sum = 0;
            for (const scene::Wave& wave : surface.waves.waves) sum += std::abs(wave.amplitude);
            return sum;
        }
        case scene::WaterSurfaceType::spectrum:
            // The significant height of a sea that wind has fully raised is 0.022 U^2 [m, m/s] (Pierson and
            // Moskowitz 1964); hardly a crest rises by more than it above the mean.
            return 0.03 * surface.spectrum.amplitude_scale * surface.spectrum.wind_speed *
                   surface.spectrum.wind_speed;
        case scene::WaterSurfaceType::mesh_sequence:
            break;
    }
    return HUGE_VAL;
}

/// Chains of one light that end on the camera's side of the water: both where it may be on either.
int events_seen(const scene::FrameState& state) {
    const glm::dvec3 camera = state.camera.position;
    if (state.camera.projection != scene::Projection::perspective) return 2;
    if (!(std::abs(camera.y) > highest_water(state.water->surface))) return 2;
    const scene::Extent& extent = state.water->extent;
    const glm::dvec2 off = glm::abs(glm::dvec2(camera.x, camera.z) - extent.center);
    const bool outside = extent.kind != scene::ExtentKind::open_water &&
                         (off.x > 0.5 * extent.size.x || off.y > 0.5 * extent.size.y);
    return camera.y < 0 && outside ? 2 : 1;
}

}  // namespace

MapMemory foresee_maps(const scene::FrameState& state) {
    const scene::CausticMapParameters& map = state.caustics.map;
    const MapTexels texels = count_texels(state, map);
    const bool pictures = std::any_of(state.lights.begin(), state.lights.end(),
                                      [](const scene::Light& light) { return !light.texture.empty(); });
    constexpr double kVector = sizeof(glm::vec3), kFloat = sizeof(float);
    const double vertex =
        2 * kVector + 2 * kFloat + 1 + (map.cascades > 1 ? kFloat : 0) + (pictures ? kVector : 0);
    constexpr double kColor = 4 * kFloat, kDepth = kFloat;
    double water = 0;
    if (state.water->surface.type != scene::WaterSurfaceType::mesh_sequence) {
        const ocean::MeshCounts counts = ocean::mesh_counts(*state.water);
        // Of several cascades the triangles of each are picked first.
        const double copies = map.cascades > 1 ? 3 : 1;
        water = 2 * kVector * static_cast<double>(counts.vertices) +
                copies * sizeof(glm::uvec3) * static_cast<double>(counts.triangles);
    }
    MapMemory memory;
    memory.events = events_seen(state);
    memory.kept =
        static_cast<double>(kTexelBatchBytes) + texels.largest * (kColor + kDepth + memory.events * vertex);
    memory.tracing = water + memory.kept;
    memory.largest = texels.largest;
    memory.photons = texels.photons * memory.events * static_cast<double>(state.lights.size());
    return memory;
}

}  // namespace dapple::light
