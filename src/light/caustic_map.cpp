#include "light/caustic_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "layout/caustic_map.h"
#include "light/light_shadows.h"
#include "light/map_plan.h"
#include "light/spot_picture.h"
#include "light/surface_flux.h"
#include "spirv/light_beam_rays_comp.h"
#include "spirv/light_caustic_map_frag.h"
#include "spirv/light_caustic_map_vert.h"

namespace dapple::light {
namespace {

using layout::BeamRay;
using layout::BeamRaysPush;
using layout::CausticMapPush;
static_assert(sizeof(CausticMapPush) == 36);
static_assert(sizeof(BeamRaysPush) == 100);
static_assert(sizeof(BeamRay) == 36);

constexpr std::uint32_t kGroupColumns = 16, kGroupRows = 4;  // of light/beam_rays.comp

gpu::RasterDescription map_raster() {
    gpu::RasterDescription description;
    description.interface = {.storage_buffers = 2, .push_bytes = sizeof(CausticMapPush)};
    description.color_formats = {gpu::Format::rgba32f};
    description.depth_test = true;
    return description;
}

glm::dvec2 horizontal(glm::dvec3 v) {
    return {v.x, v.z};
}

CausticMapPush map_push(const MapPlan& plan, glm::dvec3 origin) {
    const glm::dvec2 size = glm::dvec2(plan.columns, plan.rows) * plan.texel;
    CausticMapPush push;
    push.shear = glm::vec2(plan.shear - horizontal(origin) * plan.inverse_height);
    push.inverse_height = static_cast<float>(plan.inverse_height);
    push.clip_scale = glm::vec2(2.0 / size);
    push.clip_offset = glm::vec2(-2.0 * (plan.corner - horizontal(origin)) / size - 1.0);
    // Depth 0 at the bound that is nearest to the light, 1 at the other. Points beyond a light inside the
    // waves lie behind the eye.
    const double steep = std::abs(plan.inverse_height);
    const double bound = steep * plan.height_bound < 0.999 ? plan.height_bound : 0.999 / steep;
    const double scale = (1 + steep * bound) / (2 * bound);
    push.depth = glm::vec2(bound * scale, plan.from_below ? scale : -scale);
    return push;
}

BeamRaysPush rays_push(const scene::FrameScene& scene, const MapPlan& plan, const scene::Light& light,
                       const BeamMesh& mesh) {
    const double n = scene.state.water->refractive_index;
    const bool sun = light.type == scene::LightType::sun;
    BeamRaysPush push;
    push.corner = glm::vec2(plan.corner - horizontal(scene.origin));
    push.texel = glm::vec2(plan.texel);
    push.shear = glm::vec2(plan.shear - horizontal(scene.origin) * plan.inverse_height);
    push.inverse_height = static_cast<float>(plan.inverse_height);
    push.rest_height = static_cast<float>(-scene.origin.y);
    push.light = glm::vec3(sun ? light.direction : light.position - scene.origin);
    push.eta = static_cast<float>(plan.from_below ? n : 1 / n);
    push.spot_axis = glm::vec3(light.direction);
    push.cos_outer = -2;
    push.cos_inner = 1;
    if (light.type == scene::LightType::spot) {
        push.cos_outer = static_cast<float>(std::cos(light.cone_angle));
        push.cos_inner = static_cast<float>(std::cos(std::max(0.0, light.cone_angle - light.falloff_angle)));
    }
    push.axis = glm::vec3(mesh.axis);
    push.columns = static_cast<std::uint32_t>(plan.columns);
    push.first_row = 0;
    push.rows = 0;
    push.sun = sun ? 1 : 0;
    push.reflection = mesh.event == Event::reflection ? 1 : 0;
    return push;
}

BeamMesh empty_mesh(const scene::FrameScene& scene, const MapPlan& plan, int light_index, Event event) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    BeamMesh mesh;
    mesh.name = chain_name(scene.state, {light_index, event});
    mesh.light = light_index;
    mesh.event = event;
    mesh.from_below = plan.from_below;
    if (!plan.lit) return mesh;
    mesh.axis = mesh_axis(light, plan.from_below, event, scene.state.water->refractive_index);
    mesh.rows = plan.rows;
    mesh.columns = plan.columns;
    mesh.cell = glm::vec2(plan.texel);
    const std::size_t vertices = static_cast<std::size_t>(plan.rows) * static_cast<std::size_t>(plan.columns);
    mesh.origin.resize(vertices);
    mesh.slope.resize(vertices);
    mesh.start.resize(vertices);
    mesh.flux.resize(vertices);
    mesh.valid.resize(vertices);
    return mesh;
}

/// What a lamp's picture lets through the texels of a map.
class MapTint {
public:
    MapTint(const scene::FrameScene& scene, const MapPlan& plan, int light)
        : plan_(plan), light_(scene.state.lights[static_cast<std::size_t>(light)]), picture_(scene, light) {}

    bool exists() const { return picture_.exists(); }

    /// Mean over a texel, by its corners on the rest plane.
    glm::vec3 of(std::size_t vertex) const {
        const std::size_t columns = static_cast<std::size_t>(plan_.columns);
        const glm::dvec2 low = plan_.corner + glm::dvec2(vertex % columns, vertex / columns) * plan_.texel;
        const auto way = [&](double x, double z) {
            return glm::dvec3(low.x + x * plan_.texel.x, 0, low.y + z * plan_.texel.y) - light_.position;
        };
        return glm::vec3(0.5 * (picture_.mean({way(0, 0), way(0, 1), way(1, 1)}) +
                                picture_.mean({way(0, 0), way(1, 1), way(1, 0)})));
    }

    /// Of the light's own colour, all channels together.
    double share_of(glm::vec3 tint) const {
        const double all = light_.intensity.r + light_.intensity.g + light_.intensity.b;
        return all > 0 ? glm::dot(light_.intensity, glm::dvec3(tint)) / all : 0;
    }

private:
    const MapPlan& plan_;
    const scene::Light& light_;
    SpotPicture picture_;
};

/// Takes `rays` into the mesh from vertex `first` on; returns the number of those that carry light.
std::size_t take_rays(std::span<const BeamRay> rays, std::size_t first, const MapTint& tint, BeamMesh& mesh) {
    constexpr std::size_t kTile = 1 << 14;
    struct Sum {
        double lost = 0;
        std::size_t photons = 0;
    };
    std::vector<Sum> tiles(rays.size() / kTile + 1);
    parallel_for(rays.size(), kTile, [&](std::size_t begin, std::size_t end) {
        Sum sum;
        for (std::size_t i = begin; i < end; ++i) {
            const BeamRay& ray = rays[i];
            mesh.origin[first + i] = ray.origin;
            mesh.slope[first + i] = ray.slope;
            mesh.start[first + i] = ray.start;
            mesh.flux[first + i] = std::max(0.0f, ray.flux);
            mesh.valid[first + i] = ray.flux >= 0 ? 1 : 0;
            double lost = static_cast<double>(ray.lost);
            if (tint.exists() && (ray.flux > 0 || ray.lost > 0)) {
                const glm::vec3 let_through = tint.of(first + i);
                mesh.tint[first + i] = let_through;
                if (let_through == glm::vec3(0)) mesh.flux[first + i] = 0;
                lost *= tint.share_of(let_through);
            }
            sum.lost += lost;
            sum.photons += mesh.flux[first + i] > 0 ? 1 : 0;
        }
        tiles[begin / kTile] = sum;
    });
    std::size_t photons = 0;
    for (const Sum& sum : tiles) {
        mesh.lost_flux += sum.lost;
        photons += sum.photons;
    }
    return photons;
}

}  // namespace

struct CausticMapper::State {
    explicit State(gpu::Device& d)
        : device(d),
          raster(d, "caustic map", light_caustic_map_vert, light_caustic_map_frag, map_raster()),
          compute(d, "beam rays", light_beam_rays_comp,
                  {.storage_buffers = 1, .sampled_images = 1, .push_bytes = sizeof(BeamRaysPush)}) {}

    /// Fills the mesh from the map, in batches of rows that fit a storage binding.
    void trace_mesh(const scene::FrameScene& scene, const MapPlan& plan, const gpu::Image& map,
                    BeamMesh& mesh, FrameStats& stats) {
        const std::size_t columns = static_cast<std::size_t>(plan.columns);
        const std::size_t most =
            std::max<std::size_t>(1, device.largest_storage_range() / (columns * sizeof(BeamRay)));
        const std::size_t batch = std::min(static_cast<std::size_t>(plan.rows), most);
        gpu::Buffer buffer(device, "beam rays", batch * columns * sizeof(BeamRay));
        BeamRaysPush push =
            rays_push(scene, plan, scene.state.lights[static_cast<std::size_t>(mesh.light)], mesh);
        const MapTint tint(scene, plan, mesh.light);
        if (tint.exists()) mesh.tint.resize(mesh.vertices(), glm::vec3(0));
        std::size_t photons = 0;
        for (std::size_t row = 0; row < static_cast<std::size_t>(plan.rows); row += batch) {
            push.first_row = static_cast<std::uint32_t>(row);
            push.rows =
                static_cast<std::uint32_t>(std::min(batch, static_cast<std::size_t>(plan.rows) - row));
            gpu::Bindings bindings{.buffers = {&buffer}, .images = {&map}, .writes = {&buffer}, .push = {}};
            bindings.set_push(push);
            gpu::PassList passes(device);
            passes.compute("refraction", compute, std::move(bindings),
                           {(push.columns + kGroupColumns - 1) / kGroupColumns,
                            (push.rows + kGroupRows - 1) / kGroupRows, 1});
            passes.run(stats);
            photons +=
                take_rays(buffer.as<const BeamRay>().first(push.rows * columns), row * columns, tint, mesh);
        }
        if (plan.capped) mesh.lost_flux += flux_outside_map(scene, plan, mesh.light, mesh.event);
        stats.count("photons", static_cast<double>(photons));
    }

    gpu::Device& device;
    gpu::RasterPipeline raster;
    gpu::ComputePipeline compute;
};

CausticMapper::CausticMapper(gpu::Device& device) : state_(std::make_unique<State>(device)) {}
CausticMapper::~CausticMapper() = default;

std::vector<BeamMesh> CausticMapper::trace(const scene::FrameScene& scene, const rays::RayScene& rays,
                                           int light_index, const std::vector<Event>& events,
                                           const scene::CausticMapParameters& parameters, FrameStats& stats) {
    gpu::Device& device = state_->device;
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    const MapPlan plan = plan_map(scene, light_index, parameters.map_resolution);
    std::vector<BeamMesh> meshes;
    meshes.reserve(events.size());
    for (const Event event : events) meshes.push_back(empty_mesh(scene, plan, light_index, event));
    if (!plan.lit || meshes.empty()) return meshes;

    const gpu::Image map(device, "caustic map", plan.columns, plan.rows, gpu::Format::rgba32f);
    {
        const scene::TriangleMesh& water = scene.water->mesh;
        gpu::Buffer positions(device, "water positions", water.positions.size() * sizeof(glm::vec3));
        gpu::Buffer normals(device, "water normals", water.normals.size() * sizeof(glm::vec3));
        gpu::Buffer indices(device, "water triangles", water.triangles.size() * sizeof(glm::uvec3));
        const gpu::Image depth(device, "caustic map depth", plan.columns, plan.rows, gpu::Format::depth32f);
        {
            const ScopedPass pass(stats, "caustic map");
            // Heights stay absolute: their own digits are what slopes and landing points hang on.
            const glm::dvec3 origin(scene.origin.x, 0, scene.origin.z);
            const std::span<glm::vec3> p = positions.as<glm::vec3>(), n = normals.as<glm::vec3>();
            parallel_for(water.positions.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    p[i] = glm::vec3(water.positions[i] - origin);
                    n[i] = glm::vec3(water.normals[i]);
                }
            });
            std::copy(water.triangles.begin(), water.triangles.end(), indices.as<glm::uvec3>().begin());
        }
        gpu::Bindings bindings{.buffers = {&positions, &normals}, .images = {}, .writes = {}, .push = {}};
        bindings.set_push(map_push(plan, scene.origin));
        gpu::PassList passes(device);
        passes.draw(
            "caustic map", state_->raster, std::move(bindings), {.colors = {&map}, .depth = &depth},
            {.vertices = static_cast<std::uint32_t>(3 * water.triangles.size()), .index_buffer = &indices});
        passes.run(stats);
    }
    for (BeamMesh& mesh : meshes) {
        state_->trace_mesh(scene, plan, map, mesh, stats);
        const glm::dvec3 color = light.type == scene::LightType::sun ? light.irradiance : light.intensity;
        stats.count("lost flux, W", mesh.lost_flux * (color.r + color.g + color.b) / 3);
    }
    if (may_shadow(scene, rays, light)) {
        const ScopedPass pass(stats, "light shadows");
        stats.count("shadowed photons", static_cast<double>(shadow_meshes(meshes, scene, rays)));
    }
    return meshes;
}

}  // namespace dapple::light
