#include "render/picture_mesh.h"

#include <algorithm>
#include <cmath>

#include "ocean/grid_size.h"

namespace dapple::render {

scene::FrameState with_mesh_for_pictures(scene::FrameState state) {
    if (!state.water || state.water->mesh_cells > 0 ||
        state.water->surface.type == scene::WaterSurfaceType::mesh_sequence)
        return state;
    const glm::dvec2 extent = state.water->extent.size;
    // Cells along x are at most so many.
    const double most = std::floor(std::sqrt(ocean::kDefaultTriangleCap / 2 * extent.x / extent.y));
    double cells = 0;
    for (const scene::Light& light : state.lights) {
        if (light.type != scene::LightType::spot || light.texture.empty()) continue;
        const double across = 2 * std::abs(light.position.y) * std::tan(light.cone_angle);  // m
        const double wanted = kBeamsAcrossPicture * extent.x / across;
        cells = std::max(cells, wanted < most ? std::exp2(std::ceil(std::log2(wanted))) : most);
    }
    cells = std::min(cells, most);
    if (cells > ocean::grid_size(*state.water).cells_x)
        state.water->mesh_cells = static_cast<int>(std::max(1.0, cells));
    return state;
}

}  // namespace dapple::render
