#include "methods/adaptive_beams/refinement.h"

#include <algorithm>
#include <cmath>

#include "methods/adaptive_beams/merged_rays.h"
#include "methods/adaptive_beams/oracle_judge.h"
#include "view/camera.h"
#include "view/camera_medium.h"

namespace dapple::methods::adaptive_beams {
namespace {

/// Texels along a side of the light's view: two a finest cell, within these bounds.
constexpr int kLeastTexels = 256;
constexpr int kMostTexels = 2048;
/// Cells on outlines are split until they are narrower than this share of the picture's size: a cell that
/// wide has a ten thousandth of its area, and of what light is even over it.
constexpr double kOutlineOfPicture = 0.01;

float mean(const glm::dvec3& v) {
    return static_cast<float>((v.x + v.y + v.z) / 3);
}

/// 32 bits of a signature, never 0.
std::uint32_t folded(std::uint64_t signature) {
    return static_cast<std::uint32_t>(signature ^ signature >> 32) | 1;
}

layout::OracleWay way_of(const LightPath& path, std::size_t leg) {
    if (leg >= path.legs.size()) return {};
    const PathLeg& from = path.legs[leg];
    return {glm::vec3(from.start), glm::vec3(from.direction), static_cast<float>(from.length),
            mean(from.throughput), folded(from.signature),    from.in_water ? 1u : 0u};
}

/// The oracle's view of a ray.
void describe(const VertexPaths& ray, glm::dvec2 uv, int texels, layout::OracleVertex& vertex,
              layout::OracleWay* ways) {
    vertex = {};
    vertex.uv = glm::vec2(uv * static_cast<double>(texels));
    vertex.falloff = static_cast<float>(ray.falloff * ray.picture);
    std::fill_n(ways, oracle_rules::kOracleWays, layout::OracleWay{});
    if (!ray.on_body) return;
    vertex.position = glm::vec3(ray.position);
    vertex.normal = glm::vec3(ray.normal);
    vertex.depth = static_cast<float>(ray.distance);
    vertex.on_body = 1;
    std::uint64_t ends = 0;
    for (std::size_t event = 0; event < 2; ++event) {
        const LightPath& path = ray.paths[event];
        for (const PathLeg& leg : path.legs)
            ends = (ends * 0x9e3779b97f4a7c15u + leg.signature) * 0x9e3779b97f4a7c15u +
                   static_cast<std::uint64_t>(leg.end + 3);
        ends = ends * 31 + path.legs.size();
        ways[2 * event] = way_of(path, 0);
        if (path.legs.size() > 1) ways[2 * event + 1] = way_of(path, path.legs.size() - 1);
    }
    vertex.ends = folded(ends);
}

layout::OraclePush settings_of(const scene::FrameScene& scene, const PathTracer& tracer, int body,
                               int texels) {
    layout::OraclePush push{};
    const scene::FrameState& state = scene.state;
    const scene::Camera& seen_by = state.camera;
    const view::Camera camera(seen_by, state.clip.width, state.clip.height);
    const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world()));
    push.camera = glm::vec3(seen_by.position - scene.origin);
    push.right = glm::vec3(world_from_camera[0]);
    push.up = glm::vec3(world_from_camera[1]);
    push.forward = glm::vec3(-world_from_camera[2]);
    const double height = state.clip.height, aspect = state.clip.width / height;
    if (seen_by.projection == scene::Projection::perspective) {
        const double half = std::tan(0.5 * seen_by.field_of_view);
        push.pixel_angle = static_cast<float>(2 * half / height);
        push.half_tangent = glm::vec2(half * glm::dvec2(aspect, 1));
    } else {
        push.pixel_size = static_cast<float>(seen_by.view_height / height);
        push.half_size = glm::vec2(0.5 * seen_by.view_height * glm::dvec2(aspect, 1));
    }
    // Rays of an orthographic camera start in many places.
    if (state.water && push.pixel_size == 0 && view::camera_medium(scene).in_water) {
        const glm::dvec3 extinction = state.water->extinction();
        push.extinction = static_cast<float>(std::min({extinction.x, extinction.y, extinction.z}));
    }
    const scene::AdaptiveBeamsParameters& parameters = state.caustics.adaptive_beams;
    push.tolerance = static_cast<float>(parameters.tolerance);
    // Whole triangles are left out at outlines there, and so must be small.
    if (!parameters.paper_faithful)
        push.least_outline = static_cast<float>(kOutlineOfPicture * std::sqrt(state.clip.width * height));
    const glm::dvec2 size = tracer.view().size();
    (tracer.view().parallel() ? push.texel_size : push.texel_angle) =
        static_cast<float>(std::max(size.x, size.y) / texels);
    // At upright incidence a normal that turns by x turns what is reflected by 2 x and what goes into a
    // medium of index n by (1 - 1/n) x; glass has two surfaces, which send it off its way by (n - 1) x each.
    push.reflection = 2;
    if (body == light::kWater) {
        push.transmission = static_cast<float>(std::abs(1 - 1 / state.water->refractive_index));
    } else {
        const double index = state.objects[static_cast<std::size_t>(body)].material.refractive_index;
        push.transmission = static_cast<float>(2 * std::abs(index - 1));
    }
    push.transmission = std::max(push.transmission, 1e-3F);
    push.texels = static_cast<std::uint32_t>(texels);
    return push;
}

/// Traces the rays of vertices that have none yet.
void trace_new(const PathTracer& tracer, const ProjectedGrid& grid, TracedRays& rays) {
    const std::size_t first = rays.uv.size(), count = grid.vertices() - first;
    for (std::size_t i = 0; i < count; ++i) rays.uv.push_back(grid.uv(static_cast<std::uint32_t>(first + i)));
    rays.paths.resize(first + count);
    tracer.trace(std::span(rays.uv).subspan(first), std::span(rays.paths).subspan(first));
}

std::vector<layout::OracleTexel> for_oracle(const std::vector<SurfaceTexel>& found) {
    std::vector<layout::OracleTexel> surface(found.size());
    std::transform(found.begin(), found.end(), surface.begin(), [](const SurfaceTexel& texel) {
        return layout::OracleTexel{texel.normal, texel.on_body ? 1u : 0u, texel.light};
    });
    return surface;
}

/// The grid as it is, with the rays in the middle of its edges; describes the rays that are new.
void fill_task(const PathTracer& tracer, ProjectedGrid& grid, TracedRays& rays, OracleTask& task) {
    task.edges.clear();
    for (std::uint32_t e = 0; e < grid.edges().size(); ++e) {
        const auto [first, second] = grid.edges()[e].vertices;
        task.edges.push_back({first, second, grid.middle(e)});
    }
    task.triangles.clear();
    for (const ProjectedGrid::Triangle& t : grid.triangles())
        task.triangles.push_back(
            {{t.vertices[0], t.vertices[1], t.vertices[2]}, {t.edges[0], t.edges[1], t.edges[2]}});
    trace_new(tracer, grid, rays);
    const std::size_t described = task.vertices.size();
    task.vertices.resize(rays.uv.size());
    task.ways.resize(rays.uv.size() * oracle_rules::kOracleWays);
    for (std::size_t i = described; i < rays.uv.size(); ++i)
        describe(rays.paths[i], rays.uv[i], static_cast<int>(task.settings.texels), task.vertices[i],
                 &task.ways[i * oracle_rules::kOracleWays]);
}

}  // namespace

RefinedGrid refine(const scene::FrameScene& scene, const PathTracer& tracer, int body, int cells, int levels,
                   OraclePass* pass, FrameStats& stats) {
    RefinedGrid refined{ProjectedGrid(cells, levels), {}, {}};
    ProjectedGrid& grid = refined.grid;
    TracedRays& rays = refined.rays;
    {
        const ScopedPass tracing(stats, "beam grid");
        trace_new(tracer, grid, rays);
    }
    if (levels == 0) return refined;
    const int texels = std::clamp(2 * (cells << levels), kLeastTexels, kMostTexels);
    const std::vector<SurfaceTexel> light_view = [&] {
        const ScopedPass looking(stats, "light view");
        return tracer.first_surfaces(texels);
    }();
    const std::vector<layout::OracleTexel> surface = for_oracle(light_view);
    OracleTask task;
    task.settings = settings_of(scene, tracer, body, texels);
    task.settings.textured = tracer.view().textured() ? 1 : 0;
    std::ptrdiff_t cells_discarded = 0;
    for (int level = 0; level < levels; ++level) {
        {
            const ScopedPass tracing(stats, "beam grid");
            fill_task(tracer, grid, rays, task);
        }
        const Verdicts verdicts = pass != nullptr ? pass->judge(task, surface, stats) : judge(task, surface);
        const ScopedPass splitting(stats, "beam grid");
        std::vector<std::uint8_t> marks(grid.edges().size()), discarded(grid.triangles().size());
        for (std::size_t e = 0; e < marks.size(); ++e) marks[e] = verdicts.edges[e] != oracle_rules::kKept;
        for (std::size_t t = 0; t < verdicts.triangles.size(); ++t) {
            discarded[t] = verdicts.triangles[t] == oracle_rules::kDiscarded;
            if (verdicts.triangles[t] == oracle_rules::kHidden)
                for (const std::uint32_t edge : grid.triangles()[t].edges) marks[edge] = 1;
        }
        if (!grid.split(marks, kMostTriangles, discarded)) {
            stats.count("levels of beams left out for want of room", levels - level);
            break;
        }
        cells_discarded += std::count(discarded.begin(), discarded.end(), 1);
    }
    if (cells_discarded > 0) stats.count("cells discarded", static_cast<double>(cells_discarded));
    const ScopedPass tracing(stats, "beam grid");
    if (body == light::kWater) refined.entry = merge_waves(tracer, grid, light_view, texels, rays);
    return refined;
}

}  // namespace dapple::methods::adaptive_beams
