#include "methods/photon_splatting/photon_splatting.h"

#include <algorithm>
#include <cmath>

#include "layout/splat.h"
#include "light/caustic_map.h"
#include "light/landing.h"
#include "light/map_memory.h"
#include "methods/host_raster.h"
#include "methods/mirror_bounce.h"
#include "methods/photon_splatting/footprint.h"
#include "methods/photon_splatting/splat_builder.h"
#include "methods/photon_splatting/splat_renderer.h"
#include "scene/area_light.h"

namespace dapple::methods {
namespace {

constexpr double kLanding = 4 + 12;  // bytes a photon: where it lands

/// As many as photons: those near edges of faces have more, those that the camera does not see none.
double splats_of(const scene::FrameState& state, const light::MapMemory& maps) {
    return (state.caustics.map.second_bounce ? 2 : 1) * maps.photons;
}

}  // namespace

struct PhotonSplatting::State {
    State(gpu::Device& d, RasterBackend backend)
        : device(&d),
          mapper(d),
          renderer(draws_on_device(d.info().type, backend) ? device_splat_renderer(d)
                                                           : host_splat_renderer()) {}
    gpu::Device* device;
    light::CausticMapper mapper;
    light::Landings landings;  // memory that is used again
    std::unique_ptr<SplatRenderer> renderer;
};

PhotonSplatting::PhotonSplatting(RasterBackend backend) : backend_(backend) {}
PhotonSplatting::~PhotonSplatting() = default;

Support PhotonSplatting::supports_surface(const scene::FrameState& state) const {
    std::string reason = "receivers that the camera sees directly; none behind water or mirrors";
    if (scene::has_glass(state)) reason += " or glass, and none of the light that glass sends on";
    if (std::any_of(state.lights.begin(), state.lights.end(), [](const scene::Light& light) {
            return light.type == scene::LightType::sun && light.angular_diameter > 0;
        }))
        reason += splat_style(state.caustics).disc
                      ? "; the sun's disc as a widening of the splats by its variance"
                      : "; the sun's disc as a point";
    if (state.caustics.map.second_bounce) reason += "; light that mirrors send on once after the water";
    if (std::any_of(state.lights.begin(), state.lights.end(), scene::is_area))
        reason +=
            splat_style(state.caustics).disc
                ? "; area lights as points that widen the splats by the variance of what each stands for"
                : "; area lights as points";
    return {Support::Degree::partly, reason};
}

std::size_t PhotonSplatting::bytes(const scene::FrameState& state, std::size_t) const {
    if (!state.water) return 0;
    const light::MapMemory maps = light::foresee_maps(state);
    return light::bounded_bytes(splats_of(state, maps) * sizeof(layout::Splat) + maps.kept +
                                maps.largest * kLanding);
}

std::size_t PhotonSplatting::bytes_on(gpu::DeviceType type, const scene::FrameState& state) const {
    if (!state.water) return 0;
    const light::MapMemory maps = light::foresee_maps(state);
    // One map after another is drawn, landed and cut into splats, a stretch before they go to the device.
    constexpr double kStretch = sizeof(layout::Splat) * static_cast<double>(kStretchPhotons);
    const double mirrored = state.caustics.map.second_bounce ? mirrored_vertex_bytes(state) : 0;
    const double begin = maps.tracing - maps.kept + maps.largest * mirrored + kStretch;
    // Four layers' staging, receivers and irradiance.
    constexpr double kDevicePixel = 4 * 3 * 16;
    const double drawing =
        drawing_bytes(draws_on_device(type, backend_), state.clip, kDevicePixel, splats_of(state, maps));
    return light::bounded_bytes(std::max(begin, drawing));
}

void PhotonSplatting::begin(FrameContext& context) {
    if (!state_ || state_->device != &context.device)
        state_ = std::make_unique<State>(context.device, backend_);
    SplatRenderer& renderer = *state_->renderer;
    renderer.clear();
    const media::Media media(context.scene);
    const scene::CausticMapParameters& map = context.scene.state.caustics.map;
    const SplatStyle style = splat_style(context.scene.state.caustics);
    const light::PhotonCells cells =
        style.kernel.shape == KernelShape::tent ? light::PhotonCells::tents : light::PhotonCells::boxes;
    for (std::size_t next = 0; next < context.chains.size();) {
        // Chains of one light share its map.
        const int light = context.chains[next].light;
        std::vector<light::Event> events;
        for (; next < context.chains.size() && context.chains[next].light == light; ++next)
            events.push_back(context.chains[next].event);
        const auto add = [&](const light::BeamMesh& mesh, const light::Landings& landings) {
            const ScopedPass pass(context.stats, "photon footprints");
            std::size_t without_neighbors = 0;
            double lost = 0;
            build_splats(context.scene, media, mesh, landings, style, context.device.largest_point_size(),
                         [&](const Splats& splats) {
                             renderer.add(splats);
                             without_neighbors += splats.without_neighbors;
                             lost += splats.lost;
                         });
            context.stats.count("photons without neighbors", static_cast<double>(without_neighbors));
            if (lost > 0) context.stats.count("lost to flat footprints, W", lost);
        };
        const auto splat = [&](const light::BeamMesh& mesh) {
            light::Landings& landings = state_->landings;
            {
                const ScopedPass pass(context.stats, "photon tracing");
                light::land(mesh, context.rays, landings);
            }
            context.stats.count("photons landed", static_cast<double>(landings.count));
            add(mesh, landings);
            if (!map.second_bounce) return;
            for (const MirroredMesh& sent :
                 mirror_bounce(context.scene, media, context.rays, mesh, context.stats))
                add(sent.mesh, sent.landings);
        };
        state_->mapper.trace_each(
            context.scene, context.rays, light, events, map, cells, context.stats,
            [&](std::span<light::BeamMesh> meshes) { std::for_each(meshes.begin(), meshes.end(), splat); });
    }
    context.stats.count("splats", static_cast<double>(renderer.points() + renderer.quads()));
    context.stats.count("large splats", static_cast<double>(renderer.quads()));
}

void PhotonSplatting::irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                                 std::span<LayerResult> results) {
    const SplatStyle style = splat_style(context.scene.state.caustics);
    state_->renderer->render(context.scene, style, layers, results, context.stats);
}

}  // namespace dapple::methods
