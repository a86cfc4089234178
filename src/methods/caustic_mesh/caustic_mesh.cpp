#include "methods/caustic_mesh/caustic_mesh.h"

#include <algorithm>

#include "layout/mesh_cell.h"
#include "light/caustic_map.h"
#include "light/landing.h"
#include "light/map_memory.h"
#include "media/media.h"
#include "methods/caustic_mesh/cell_builder.h"
#include "methods/caustic_mesh/cell_renderer.h"
#include "methods/caustic_mesh/mirrored_disc.h"
#include "methods/host_raster.h"
#include "methods/mirror_bounce.h"
#include "scene/area_light.h"

namespace dapple::methods {
namespace {

constexpr double kLanding = 4 + 12;  // bytes a ray: where it lands
constexpr double kBeside = 4 + 1;    // and what its cells need to know while they are made

/// One for each ray that may carry light; those that the camera does not see are not kept, cells at edges are
/// cut into more.
double cells_of(const scene::FrameState& state, const light::MapMemory& maps) {
    return (state.caustics.map.second_bounce ? 2 : 1) * maps.photons;
}

/// Cells of the paper's are triangles.
double cell_bytes(const scene::FrameState& state) {
    return sizeof(layout::MeshCell) * (state.caustics.map.paper_faithful ? 2.0 : 1.0);
}

}  // namespace

struct CausticMesh::State {
    State(gpu::Device& d, RasterBackend backend)
        : device(&d),
          mapper(d),
          renderer(draws_on_device(d.info().type, backend) ? caustic_mesh::device_cell_renderer(d)
                                                           : caustic_mesh::host_cell_renderer()) {}
    gpu::Device* device;
    light::CausticMapper mapper;
    light::Landings landings;  // memory that is used again
    std::unique_ptr<caustic_mesh::CellRenderer> renderer;
};

CausticMesh::CausticMesh(RasterBackend backend) : backend_(backend) {}
CausticMesh::~CausticMesh() = default;

Support CausticMesh::supports_surface(const scene::FrameState& state) const {
    std::string reason = "receivers that the camera sees directly; none behind water or mirrors";
    if (scene::has_glass(state)) reason += " or glass, and none of the light that glass sends on";
    if (std::any_of(state.lights.begin(), state.lights.end(), [](const scene::Light& light) {
            return light.type == scene::LightType::sun && light.angular_diameter > 0;
        }))
        reason += state.caustics.map.paper_faithful
                      ? "; the sun as a point"
                      : "; the sun's disc as a widening of pixels by its variance";
    if (std::any_of(state.lights.begin(), state.lights.end(), scene::is_area))
        reason += "; area lights as points, one for each of their samples";
    if (state.caustics.map.second_bounce) reason += "; light that mirrors send on once after the water";
    if (state.caustics.map.paper_faithful)
        reason += "; E at the samples' points, and none where triangles span edges of objects";
    return {Support::Degree::partly, reason};
}

std::size_t CausticMesh::bytes(const scene::FrameState& state, std::size_t) const {
    if (!state.water) return 0;
    const light::MapMemory maps = light::foresee_maps(state);
    return light::bounded_bytes(cells_of(state, maps) * cell_bytes(state) + maps.kept +
                                maps.largest * kLanding);
}

std::size_t CausticMesh::bytes_on(gpu::DeviceType type, const scene::FrameState& state) const {
    if (!state.water) return 0;
    const light::MapMemory maps = light::foresee_maps(state);
    // One map after another is drawn, landed and cut into cells, a stretch of them before it goes to the
    // device.
    const double stretch = std::min(maps.largest, static_cast<double>(caustic_mesh::kStretch));
    const double mirrored =
        state.caustics.map.second_bounce ? mirrored_vertex_bytes(state) + sizeof(caustic_mesh::DiscImage) : 0;
    const double begin =
        maps.tracing - maps.kept + maps.largest * (kBeside + mirrored) + stretch * cell_bytes(state);
    // Four layers' receivers, in and out, and irradiance.
    constexpr double kDevicePixel = 4 * 5 * 16;
    const double drawing =
        drawing_bytes(draws_on_device(type, backend_), state.clip, kDevicePixel, cells_of(state, maps));
    return light::bounded_bytes(std::max(begin, drawing));
}

void CausticMesh::begin(FrameContext& context) {
    if (!state_ || state_->device != &context.device)
        state_ = std::make_unique<State>(context.device, backend_);
    caustic_mesh::CellRenderer& renderer = *state_->renderer;
    renderer.clear();
    const media::Media media(context.scene);
    const scene::CausticMapParameters& map = context.scene.state.caustics.map;
    for (std::size_t next = 0; next < context.chains.size();) {
        // Chains of one light share its map.
        const int light = context.chains[next].light;
        std::vector<light::Event> events;
        for (; next < context.chains.size() && context.chains[next].light == light; ++next)
            events.push_back(context.chains[next].event);
        const auto lay_cells = [&](const light::BeamMesh& mesh, const light::Landings& landings) {
            const ScopedPass pass(context.stats, "mesh cells");
            caustic_mesh::build_cells(
                context.scene, media, mesh, landings, context.rays, context.device.largest_point_size(),
                map.paper_faithful, [&](const caustic_mesh::Cells& cells) {
                    renderer.add(cells);
                    context.stats.count("cells cut", static_cast<double>(cells.cut));
                    context.stats.count("cells widened", static_cast<double>(cells.widened));
                    context.stats.count("triangles left out", static_cast<double>(cells.left_out));
                    if (cells.overfull > 0)
                        context.stats.count("cells beside more faces than they light",
                                            static_cast<double>(cells.overfull));
                    if (cells.lost > 0) context.stats.count("lost to cells without size, W", cells.lost);
                });
        };
        const auto lay = [&](const light::BeamMesh& mesh) {
            light::Landings& landings = state_->landings;
            {
                const ScopedPass pass(context.stats, "photon tracing");
                light::land(mesh, context.rays, landings);
            }
            context.stats.count("photons landed", static_cast<double>(landings.count));
            lay_cells(mesh, landings);
            if (!map.second_bounce) return;
            for (const MirroredMesh& sent :
                 mirror_bounce(context.scene, media, context.rays, mesh, context.stats))
                lay_cells(sent.mesh, sent.landings);
        };
        state_->mapper.trace_each(
            context.scene, context.rays, light, events, map, light::PhotonCells::tents, context.stats,
            [&](std::span<light::BeamMesh> meshes) { std::for_each(meshes.begin(), meshes.end(), lay); });
    }
    context.stats.count("mesh cells", static_cast<double>(renderer.points() + renderer.quads()));
    context.stats.count("large mesh cells", static_cast<double>(renderer.quads()));
}

void CausticMesh::irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                             std::span<LayerResult> results) {
    state_->renderer->render(context.scene, context.scene.state.caustics.map.paper_faithful, layers, results,
                             context.stats);
}

}  // namespace dapple::methods
