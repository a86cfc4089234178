#include "light/caustic_map.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "base/large_pages.h"
#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "layout/caustic_map.h"
#include "light/cascade_plan.h"
#include "light/light_shadows.h"
#include "light/map_plan.h"
#include "light/ring.h"
#include "light/spot_picture.h"
#include "light/surface_flux.h"
#include "scene/area_light.h"
#include "spirv/light_beam_rays_comp.h"
#include "spirv/light_caustic_map_frag.h"
#include "spirv/light_caustic_map_vert.h"

namespace dapple::light {
namespace {

using layout::BeamRay;
using layout::BeamRaysPush;
using layout::CausticMapPush;
static_assert(sizeof(CausticMapPush) == 44);
static_assert(sizeof(BeamRaysPush) == 124);
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
    const glm::dvec2 half = 0.5 * glm::dvec2(plan.columns, plan.rows);
    const glm::dmat2 clip = glm::dmat2(1 / half.x, 0, 0, 1 / half.y) * glm::inverse(plan.texel);
    CausticMapPush push;
    push.shear = glm::vec2(plan.shear - horizontal(origin) * plan.inverse_height);
    push.inverse_height = static_cast<float>(plan.inverse_height);
    push.clip_scale = glm::vec4(clip[0], clip[1]);
    push.clip_offset = glm::vec2(-(clip * (plan.corner() - horizontal(origin))) - 1.0);
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
    push.anchor = glm::vec2(plan.anchor - horizontal(scene.origin));
    push.column_step = glm::vec2(plan.texel[0]);
    push.row_step = glm::vec2(plan.texel[1]);
    push.first_column = static_cast<int>(plan.first.x);
    push.first_row = static_cast<int>(plan.first.y);
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
    push.left = push.top = push.columns = push.rows = 0;
    push.sun = sun ? 1 : 0;
    push.reflection = mesh.event == Event::reflection ? 1 : 0;
    push.emitter = scene::is_area(light) ? 1 : 0;
    return push;
}

/// Whether rays are traced from all texels.
bool whole(const MapPlan& plan) {
    return plan.parts.size() == 1 && plan.parts[0].columns == plan.columns && plan.parts[0].rows == plan.rows;
}

BeamMesh empty_mesh(const scene::FrameScene& scene, const MapPlan& plan, int light_index, Event event) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    BeamMesh mesh;
    mesh.name = chain_name(scene.state, {light_index, event});
    mesh.light = light_index;
    mesh.event = event;
    mesh.cascade = plan.cascade;
    mesh.from_below = plan.from_below;
    if (!plan.lit) return mesh;
    mesh.axis = mesh_axis(light, plan.from_below, event, scene.state.water->refractive_index);
    mesh.rows = plan.rows;
    mesh.columns = plan.columns;
    mesh.texel = glm::mat2(plan.texel);
    const std::size_t vertices = static_cast<std::size_t>(plan.rows) * static_cast<std::size_t>(plan.columns);
    resize_large(mesh.origin, vertices);
    resize_large(mesh.slope, vertices);
    resize_large(mesh.start, vertices);
    resize_large(mesh.flux, vertices);
    resize_large(mesh.valid, vertices);
    if (plan.weighted()) resize_large(mesh.weight, vertices);
    if (whole(plan)) return mesh;  // all of it will be written
    std::fill(mesh.origin.begin(), mesh.origin.end(), glm::vec3(0));
    std::fill(mesh.slope.begin(), mesh.slope.end(), glm::vec3(mesh.axis));  // finite where no ray is traced
    std::fill(mesh.start.begin(), mesh.start.end(), 0.0f);
    std::fill(mesh.flux.begin(), mesh.flux.end(), 0.0f);
    std::fill(mesh.valid.begin(), mesh.valid.end(), std::uint8_t{0});
    std::fill(mesh.weight.begin(), mesh.weight.end(), 0.0f);
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
        const glm::dvec2 low = plan_.corner() + plan_.texel * glm::dvec2(vertex % columns, vertex / columns);
        const auto way = [&](double column, double row) {
            const glm::dvec2 point = low + plan_.texel * glm::dvec2(column, row);
            return glm::dvec3(point.x, 0, point.y) - light_.position;
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

/// Takes the rays of the texels in `box`, row by row, into the mesh; returns the number of those that carry
/// light.
std::size_t take_rays(std::span<const BeamRay> rays, const MapPlan& plan, const TexelBox& box,
                      const MapTint& tint, BeamMesh& mesh) {
    struct Sum {
        double lost = 0;
        std::size_t photons = 0;
    };
    const std::size_t columns = static_cast<std::size_t>(box.columns),
                      rows = static_cast<std::size_t>(box.rows);
    const std::size_t tile = std::max<std::size_t>(1, (1 << 14) / columns);  // rows
    std::vector<Sum> tiles(rows / tile + 1);
    parallel_for(rows, tile, [&](std::size_t begin, std::size_t end) {
        Sum sum;
        for (std::size_t i = begin * columns; i < end * columns;) {
            const int row = box.first_row + static_cast<int>(i / columns);
            std::size_t vertex = static_cast<std::size_t>(row) * static_cast<std::size_t>(plan.columns) +
                                 static_cast<std::size_t>(box.first_column);
            for (int column = box.first_column; column < box.first_column + box.columns;
                 ++column, ++vertex, ++i) {
                const BeamRay& ray = rays[i];
                mesh.origin[vertex] = ray.origin;
                mesh.slope[vertex] = ray.slope;
                mesh.start[vertex] = ray.start;
                mesh.flux[vertex] = std::max(0.0f, ray.flux);
                mesh.valid[vertex] = ray.flux >= 0 ? 1 : 0;
                double lost = static_cast<double>(ray.lost);
                if (plan.weighted()) {
                    const double share = plan.share(column, row);
                    mesh.weight[vertex] = static_cast<float>(share);
                    mesh.flux[vertex] *= mesh.weight[vertex];
                    lost *= share;
                }
                if (tint.exists() && (ray.flux > 0 || ray.lost > 0)) {
                    const glm::vec3 let_through = tint.of(vertex);
                    mesh.tint[vertex] = let_through;
                    if (let_through == glm::vec3(0)) mesh.flux[vertex] = 0;
                    lost *= tint.share_of(let_through);
                }
                sum.lost += lost;
                sum.photons += mesh.flux[vertex] > 0 ? 1 : 0;
            }
        }
        tiles[begin / tile] = sum;
    });
    std::size_t photons = 0;
    for (const Sum& sum : tiles) {
        mesh.lost_flux += sum.lost;
        photons += sum.photons;
    }
    return photons;
}

/// The water on the device, for all maps of a light.
struct WaterBuffers {
    WaterBuffers(gpu::Device& device, const scene::FrameScene& scene, bool whole_maps)
        : mesh(scene.water->mesh),
          whole(whole_maps),
          positions(device, "water positions", mesh.positions.size() * sizeof(glm::vec3)),
          normals(device, "water normals", mesh.normals.size() * sizeof(glm::vec3)),
          indices(device, "water triangles", mesh.triangles.size() * sizeof(glm::uvec3)) {
        // Heights stay absolute: their own digits are what slopes and landing points hang on.
        const glm::dvec3 origin(scene.origin.x, 0, scene.origin.z);
        const std::span<glm::vec3> p = positions.as<glm::vec3>(), n = normals.as<glm::vec3>();
        parallel_for(mesh.positions.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                p[i] = glm::vec3(mesh.positions[i] - origin);
                n[i] = glm::vec3(mesh.normals[i]);
            }
        });
    }

    /// Of several cascades each is drawn from the triangles that may lie on its ring.
    void take_triangles(const MapPlan& plan) {
        const std::vector<glm::uvec3> ring =
            whole ? std::vector<glm::uvec3>() : triangles_of_ring(plan, mesh);
        const std::vector<glm::uvec3>& kept = whole ? mesh.triangles : ring;
        std::copy(kept.begin(), kept.end(), indices.as<glm::uvec3>().begin());
        triangles = static_cast<std::uint32_t>(kept.size());
    }

    const scene::TriangleMesh& mesh;
    bool whole;
    gpu::Buffer positions, normals, indices;
    std::uint32_t triangles = 0;
};

}  // namespace

struct CausticMapper::State {
    explicit State(gpu::Device& d)
        : device(d),
          raster(d, "caustic map", light_caustic_map_vert, light_caustic_map_frag, map_raster()),
          compute(d, "beam rays", light_beam_rays_comp,
                  {.storage_buffers = 1, .sampled_images = 1, .push_bytes = sizeof(BeamRaysPush)}) {}

    /// The light-view raster of one map. Maps of several cascades follow one after another, so that only one
    /// takes memory; layers of one image would all.
    gpu::Image draw_map(const scene::FrameScene& scene, const MapPlan& plan, WaterBuffers& water,
                        FrameStats& stats) {
        gpu::Image map(device, "caustic map", plan.columns, plan.rows, gpu::Format::rgba32f);
        const gpu::Image depth(device, "caustic map depth", plan.columns, plan.rows, gpu::Format::depth32f);
        {
            const ScopedPass pass(stats, "caustic map");
            water.take_triangles(plan);
        }
        gpu::Bindings bindings{
            .buffers = {&water.positions, &water.normals}, .images = {}, .writes = {}, .push = {}};
        bindings.set_push(map_push(plan, scene.origin));
        gpu::PassList passes(device);
        passes.draw("caustic map", raster, std::move(bindings), {.colors = {&map}, .depth = &depth},
                    {.vertices = 3 * water.triangles, .index_buffer = &water.indices});
        passes.run(stats);
        return map;
    }

    /// Fills the mesh from the parts of the map, each in batches of rows that the processor's cache holds.
    void trace_mesh(const scene::FrameScene& scene, const MapPlan& plan, const gpu::Image& map,
                    BeamMesh& mesh, FrameStats& stats) {
        BeamRaysPush push =
            rays_push(scene, plan, scene.state.lights[static_cast<std::size_t>(mesh.light)], mesh);
        const MapTint tint(scene, plan, mesh.light);
        if (tint.exists()) mesh.tint.resize(mesh.vertices(), glm::vec3(0));
        std::size_t photons = 0;
        for (const TexelBox& part : plan.parts) {
            const std::size_t columns = static_cast<std::size_t>(part.columns);
            const std::size_t most = std::max<std::size_t>(1, kRayBatchBytes / (columns * sizeof(BeamRay)));
            const int batch = static_cast<int>(std::min(static_cast<std::size_t>(part.rows), most));
            gpu::Buffer& buffer = ray_buffer(static_cast<std::size_t>(batch) * columns * sizeof(BeamRay));
            TexelBox box = part;
            for (int row = 0; row < part.rows; row += batch) {
                box.first_row = part.first_row + row;
                box.rows = std::min(batch, part.rows - row);
                push.left = static_cast<std::uint32_t>(box.first_column);
                push.top = static_cast<std::uint32_t>(box.first_row);
                push.columns = static_cast<std::uint32_t>(box.columns);
                push.rows = static_cast<std::uint32_t>(box.rows);
                gpu::Bindings bindings{
                    .buffers = {&buffer}, .images = {&map}, .writes = {&buffer}, .push = {}};
                bindings.set_push(push);
                gpu::PassList passes(device);
                passes.compute("refraction", compute, std::move(bindings),
                               {(push.columns + kGroupColumns - 1) / kGroupColumns,
                                (push.rows + kGroupRows - 1) / kGroupRows, 1});
                passes.run(stats);
                const ScopedPass pass(stats, "refraction");
                photons +=
                    take_rays(buffer.as<const BeamRay>().first(push.rows * columns), plan, box, tint, mesh);
            }
        }
        if (plan.capped) mesh.lost_flux += flux_outside_map(scene, plan, mesh.light, mesh.event);
        stats.count("photons", static_cast<double>(photons));
    }

    /// One for all batches, of at least that size: fresh memory costs more than all that is done with a ray.
    gpu::Buffer& ray_buffer(std::size_t bytes) {
        if (!rays || rays->bytes() < bytes) rays.emplace(device, "beam rays", bytes);
        return *rays;
    }

    gpu::Device& device;
    gpu::RasterPipeline raster;
    gpu::ComputePipeline compute;
    std::optional<gpu::Buffer> rays;
};

CausticMapper::CausticMapper(gpu::Device& device) : state_(std::make_unique<State>(device)) {}
CausticMapper::~CausticMapper() = default;

std::vector<BeamMesh> CausticMapper::trace(const scene::FrameScene& scene, const rays::RayScene& rays,
                                           int light, const std::vector<Event>& events,
                                           const scene::CausticMapParameters& parameters, FrameStats& stats) {
    std::vector<BeamMesh> all;
    trace_each(scene, rays, light, events, parameters, stats, [&](std::span<BeamMesh> meshes) {
        all.insert(all.end(), std::move_iterator(meshes.begin()), std::move_iterator(meshes.end()));
    });
    return all;
}

void CausticMapper::trace_each(const scene::FrameScene& scene, const rays::RayScene& rays, int light_index,
                               const std::vector<Event>& events,
                               const scene::CausticMapParameters& parameters, FrameStats& stats,
                               const std::function<void(std::span<BeamMesh>)>& take) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    const glm::dvec3 color = light.type == scene::LightType::sun ? light.irradiance : light.intensity;
    const std::vector<MapPlan> plans = plan_cascades(scene, light_index, parameters);
    if (plans.empty() || events.empty()) return;
    std::optional<WaterBuffers> water;
    if (plans.front().lit) {
        const ScopedPass pass(stats, "caustic map");
        water.emplace(state_->device, scene, plans.size() == 1);
    }
    for (const MapPlan& plan : plans) {
        std::vector<BeamMesh> meshes;
        {
            std::optional<gpu::Image> map;
            if (plan.lit) map = state_->draw_map(scene, plan, *water, stats);
            for (const Event event : events) {
                BeamMesh& mesh = meshes.emplace_back(empty_mesh(scene, plan, light_index, event));
                if (map) state_->trace_mesh(scene, plan, *map, mesh, stats);
                stats.count("lost flux, W", mesh.lost_flux * (color.r + color.g + color.b) / 3);
            }
        }
        if (plan.lit && may_shadow(scene, rays, light)) {
            const ScopedPass pass(stats, "light shadows");
            stats.count("shadowed photons", static_cast<double>(shadow_meshes(meshes, scene, rays)));
        }
        take(meshes);
    }
}

}  // namespace dapple::light
