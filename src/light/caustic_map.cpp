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
#include "light/texel_rays.h"
#include "spirv/light_caustic_map_frag.h"
#include "spirv/light_caustic_map_vert.h"

namespace dapple::light {
namespace {

using layout::CausticMapPush;
static_assert(sizeof(CausticMapPush) == 44);

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

/// Whether rays are traced from all texels.
bool whole(const MapPlan& plan) {
    return plan.parts.size() == 1 && plan.parts[0].columns == plan.columns && plan.parts[0].rows == plan.rows;
}

/// In the memory of one that nobody needs any more.
BeamMesh empty_mesh(const scene::FrameScene& scene, const MapPlan& plan, int light_index, Event event,
                    BeamMesh mesh) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    mesh.name = chain_name(scene.state, {light_index, event});
    mesh.light = light_index;
    mesh.event = event;
    mesh.cascade = plan.cascade;
    mesh.from_below = plan.from_below;
    mesh.lost_flux = 0;
    mesh.rows = mesh.columns = 0;
    mesh.weight.clear();
    mesh.tint.clear();
    if (!plan.lit) {
        for (auto* vectors : {&mesh.origin, &mesh.slope}) vectors->clear();
        for (auto* numbers : {&mesh.start, &mesh.flux}) numbers->clear();
        mesh.valid.clear();
        return mesh;
    }
    mesh.axis = mesh_axis(light, plan.from_below, event, scene.state.water->refractive_index);
    mesh.rows = plan.rows;
    mesh.columns = plan.columns;
    mesh.texel = glm::mat2(plan.texel);
    const std::size_t vertices = static_cast<std::size_t>(plan.rows) * static_cast<std::size_t>(plan.columns);
    renew_large(mesh.origin, vertices);
    renew_large(mesh.slope, vertices);
    renew_large(mesh.start, vertices);
    renew_large(mesh.flux, vertices);
    renew_large(mesh.valid, vertices);
    if (plan.weighted()) renew_large(mesh.weight, vertices);
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

/// Traces the rays of a map's texels into a mesh.
class MeshTracer {
public:
    MeshTracer(const scene::FrameScene& scene, const MapPlan& plan, BeamMesh& mesh)
        : plan_(plan), tint_(scene, plan, mesh.light), tracer_(scene, plan, mesh), mesh_(mesh) {
        if (tint_.exists()) mesh.tint.assign(mesh.vertices(), glm::vec3(0));
    }

    /// Of the texels in `box`, row by row; returns the number of rays that carry light.
    std::size_t trace(std::span<const glm::vec4> texels, const TexelBox& box) const {
        const std::size_t columns = static_cast<std::size_t>(box.columns),
                          rows = static_cast<std::size_t>(box.rows);
        const std::size_t tile = std::max<std::size_t>(1, (1 << 14) / columns);  // rows
        std::vector<Sum> tiles(rows / tile + 1);
        parallel_for(rows, tile, [&](std::size_t begin, std::size_t end) {
            TexelRays rays;
            Sum sum;
            for (std::size_t row = begin; row < end; ++row)
                for (std::size_t left = 0; left < columns; left += TexelRays::kMost) {
                    const std::size_t count = std::min(TexelRays::kMost, columns - left);
                    const int map_column = box.first_column + static_cast<int>(left),
                              map_row = box.first_row + static_cast<int>(row);
                    tracer_.trace(texels.subspan(row * columns + left, count), map_column, map_row, rays);
                    if (plan_.weighted()) weigh(rays, count, map_column, map_row);
                    if (tint_.exists()) tint(rays, count, vertex(map_column, map_row));
                    take(rays, count, vertex(map_column, map_row), sum);
                }
            tiles[begin / tile] = sum;
        });
        std::size_t photons = 0;
        for (const Sum& sum : tiles) {
            mesh_.lost_flux += sum.lost;
            photons += sum.photons;
        }
        return photons;
    }

private:
    struct Sum {
        double lost = 0;
        std::size_t photons = 0;
    };

    std::size_t vertex(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(plan_.columns) +
               static_cast<std::size_t>(column);
    }

    void weigh(TexelRays& rays, std::size_t count, int column, int row) const {
        const std::size_t first = vertex(column, row);
        for (std::size_t k = 0; k < count; ++k) {
            const auto share = static_cast<float>(plan_.share(column + static_cast<int>(k), row));
            mesh_.weight[first + k] = share;
            if (rays.flux[k] > 0) rays.flux[k] *= share;
            rays.lost[k] *= share;
        }
    }

    void tint(TexelRays& rays, std::size_t count, std::size_t first) const {
        for (std::size_t k = 0; k < count; ++k) {
            if (!(rays.flux[k] > 0 || rays.lost[k] > 0)) continue;
            const glm::vec3 let_through = tint_.of(first + k);
            mesh_.tint[first + k] = let_through;
            if (let_through == glm::vec3(0)) rays.flux[k] = std::min(rays.flux[k], 0.0f);
            rays.lost[k] *= static_cast<float>(tint_.share_of(let_through));
        }
    }

    void take(const TexelRays& rays, std::size_t count, std::size_t first, Sum& sum) const {
        for (std::size_t k = 0; k < count; ++k) {
            mesh_.origin[first + k] = rays.origin.at(k);
            mesh_.slope[first + k] = rays.slope.at(k);
        }
        std::copy_n(rays.start.begin(), count, mesh_.start.begin() + static_cast<std::ptrdiff_t>(first));
        int photons = 0;
        float most_lost = 0;
        for (std::size_t k = 0; k < count; ++k) {
            mesh_.flux[first + k] = std::max(0.0f, rays.flux[k]);
            mesh_.valid[first + k] = rays.flux[k] >= 0 ? 1 : 0;
            photons += rays.flux[k] > 0 ? 1 : 0;
            most_lost = std::max(most_lost, rays.lost[k]);
        }
        sum.photons += static_cast<std::size_t>(photons);
        if (most_lost > 0)
            for (std::size_t k = 0; k < count; ++k) sum.lost += static_cast<double>(rays.lost[k]);
    }

    const MapPlan& plan_;
    MapTint tint_;
    TexelTracer tracer_;
    BeamMesh& mesh_;
};

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
        : device(d), raster(d, "caustic map", light_caustic_map_vert, light_caustic_map_frag, map_raster()) {}

    /// The light-view raster of one map. Maps of several cascades follow one after another, so that only one
    /// takes memory; layers of one image would all.
    void draw_map(const scene::FrameScene& scene, const MapPlan& plan, WaterBuffers& water,
                  FrameStats& stats) {
        if (!map || map->width() != plan.columns || map->height() != plan.rows) {
            map.reset();
            depth.reset();
            map.emplace(device, "caustic map", plan.columns, plan.rows, gpu::Format::rgba32f);
            depth.emplace(device, "caustic map depth", plan.columns, plan.rows, gpu::Format::depth32f);
        }
        {
            const ScopedPass pass(stats, "caustic map");
            water.take_triangles(plan);
        }
        gpu::Bindings bindings{
            .buffers = {&water.positions, &water.normals}, .images = {}, .writes = {}, .push = {}};
        bindings.set_push(map_push(plan, scene.origin));
        gpu::PassList passes(device);
        passes.draw("caustic map", raster, std::move(bindings), {.colors = {&*map}, .depth = &*depth},
                    {.vertices = 3 * water.triangles, .index_buffer = &water.indices});
        passes.run(stats);
    }

    /// Fills the meshes from the parts of the map, each in batches of rows that the processor's cache holds.
    void trace_meshes(const scene::FrameScene& scene, const MapPlan& plan, FrameStats& stats) {
        std::vector<MeshTracer> tracers;
        for (BeamMesh& mesh : meshes) tracers.emplace_back(scene, plan, mesh);
        std::size_t photons = 0;
        for (const TexelBox& part : plan.parts) {
            const std::size_t columns = static_cast<std::size_t>(part.columns);
            const std::size_t most =
                std::max<std::size_t>(1, kTexelBatchBytes / (columns * sizeof(glm::vec4)));
            const int batch = static_cast<int>(std::min(static_cast<std::size_t>(part.rows), most));
            gpu::Buffer& buffer = texel_buffer(static_cast<std::size_t>(batch) * columns * sizeof(glm::vec4));
            TexelBox box = part;
            for (int row = 0; row < part.rows; row += batch) {
                box.first_row = part.first_row + row;
                box.rows = std::min(batch, part.rows - row);
                gpu::PassList passes(device);
                passes.copy("refraction", *map, {box.first_column, box.first_row, box.columns, box.rows},
                            buffer);
                passes.run(stats);
                const ScopedPass pass(stats, "refraction");
                for (const MeshTracer& tracer : tracers)
                    photons += tracer.trace(buffer.as<const glm::vec4>(), box);
            }
        }
        for (BeamMesh& mesh : meshes)
            if (plan.capped) mesh.lost_flux += flux_outside_map(scene, plan, mesh.light, mesh.event);
        stats.count("photons", static_cast<double>(photons));
    }

    /// One for all batches, of at least that size.
    gpu::Buffer& texel_buffer(std::size_t bytes) {
        if (!texels || texels->bytes() < bytes) texels.emplace(device, "texels", bytes);
        return *texels;
    }

    gpu::Device& device;
    gpu::RasterPipeline raster;
    // Kept from map to map and from frame to frame: to touch fresh memory costs more than most of what is
    // done with it.
    std::optional<gpu::Image> map, depth;
    std::optional<gpu::Buffer> texels;
    std::vector<BeamMesh> meshes;
};

CausticMapper::CausticMapper(gpu::Device& device) : state_(std::make_unique<State>(device)) {}
CausticMapper::~CausticMapper() = default;

std::vector<BeamMesh> CausticMapper::trace(const scene::FrameScene& scene, const rays::RayScene& rays,
                                           int light, const std::vector<Event>& events,
                                           const scene::CausticMapParameters& parameters, FrameStats& stats) {
    std::vector<BeamMesh> all;
    trace_each(
        scene, rays, light, events, parameters, PhotonCells::tents, stats, [&](std::span<BeamMesh> meshes) {
            all.insert(all.end(), std::move_iterator(meshes.begin()), std::move_iterator(meshes.end()));
        });
    return all;
}

void CausticMapper::trace_each(const scene::FrameScene& scene, const rays::RayScene& rays, int light_index,
                               const std::vector<Event>& events,
                               const scene::CausticMapParameters& parameters, PhotonCells cells,
                               FrameStats& stats, const std::function<void(std::span<BeamMesh>)>& take) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    const glm::dvec3 color = light.type == scene::LightType::sun ? light.irradiance : light.intensity;
    const std::vector<MapPlan> plans = plan_cascades(scene, light_index, parameters, cells);
    if (plans.empty() || events.empty()) return;
    std::optional<WaterBuffers> water;
    if (plans.front().lit) {
        const ScopedPass pass(stats, "caustic map");
        water.emplace(state_->device, scene, plans.size() == 1);
    }
    std::vector<BeamMesh>& meshes = state_->meshes;
    meshes.resize(events.size());
    for (const MapPlan& plan : plans) {
        for (std::size_t i = 0; i < events.size(); ++i)
            meshes[i] = empty_mesh(scene, plan, light_index, events[i], std::move(meshes[i]));
        if (plan.lit) {
            state_->draw_map(scene, plan, *water, stats);
            state_->trace_meshes(scene, plan, stats);
        }
        for (const BeamMesh& mesh : meshes)
            stats.count("lost flux, W", mesh.lost_flux * (color.r + color.g + color.b) / 3);
        if (plan.lit && may_shadow(scene, rays, light)) {
            const ScopedPass pass(stats, "light shadows");
            stats.count("shadowed photons", static_cast<double>(shadow_meshes(meshes, scene, rays)));
        }
        take(meshes);
    }
}

}  // namespace dapple::light
