#include "methods/sliced_beams/sliced_beams.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/parallel.h"
#include "light/water_beams.h"
#include "methods/sliced_beams/coverage_pass.h"
#include "methods/sliced_beams/layer_tiles.h"
#include "methods/sliced_beams/light_lattice.h"
#include "methods/sliced_beams/point_query.h"
#include "methods/sliced_beams/scatter_pass.h"
#include "methods/sliced_beams/scatter_tree.h"
#include "methods/sliced_beams/sheet_coverage.h"
#include "methods/sliced_beams/volume_light.h"
#include "ocean/water_surface.h"

namespace dapple::methods {

using sliced_beams::BeamNeighbors;
using sliced_beams::BeamPyramid;
using sliced_beams::CoveragePass;
using sliced_beams::LayerTiles;
using sliced_beams::LightLattice;
using sliced_beams::PointQuery;
using sliced_beams::QueryCounts;
using sliced_beams::ReceiverGroup;
using sliced_beams::ScatterCounts;
using sliced_beams::ScatterPass;
using sliced_beams::SheetCoverage;
using sliced_beams::VolumeLight;

struct SlicedBeams::State {
    explicit State(CoverageBackend coverage) : backend(coverage) {}

    CoverageBackend backend;
    std::unique_ptr<CoveragePass> pass;  ///< once it has been needed
    bool on_device = false;              ///< in this frame
    std::unique_ptr<ScatterPass> scatter_pass;
    std::vector<std::unique_ptr<SheetCoverage<float>>> sheets;
    std::optional<BeamNeighbors> neighbors;
    std::vector<std::unique_ptr<PointQuery<float>>>
        points;  ///< beside the sheets; made where data is asked for

    std::optional<LightLattice> lattice;  ///< of one call of irradiance(), where a sheet has a disc
    std::optional<VolumeLight> volume;    ///< once a frame's segments have been asked for

    bool computes(gpu::DeviceType type) const;
    void choose_backend(FrameContext& context);
    void find_shared(const FrameContext& context, std::span<const view::ReceiverLayer> layers,
                     QueryCounts& counts);
    void cover(const LayerTiles& tiles, LayerResult& result, QueryCounts& all, FrameStats& stats) const;
    void find_points(const FrameContext& context, const view::ReceiverLayer& layer, LayerResult& result);
};

namespace {

/// Whether the device computes coverage and scattered light by itself; by its type, never by timing, so that
/// bits repeat. On lavapipe the pass of coverage costs 2.0 to 2.4 times the CPU code on a level floor, more
/// than the twice that it may; 1.4 to 2 times on a pool with a column and on a curved floor
/// (tests/benchmarks/beams/bench_coverage_pass.cpp). That of scattered light costs 10 times as much
/// (bench_scatter.cpp): each number is loaded one by one for each segment, and what no segment needs is
/// executed.
bool computes_by_default(gpu::DeviceType type) {
    return type != gpu::DeviceType::cpu;
}

}  // namespace

/// The data of the receivers' own points.
void SlicedBeams::State::find_points(const FrameContext& context, const view::ReceiverLayer& layer,
                                     LayerResult& result) {
    const scene::WaterMesh& water = *context.scene.water;
    if (!neighbors) neighbors.emplace(water.rows, water.columns, water.mesh.triangles);
    if (points.empty())
        for (const auto& sheet : sheets) {
            points.push_back(sheet->sheet().counts_paths
                                 ? std::make_unique<PointQuery<float>>(*sheet, *neighbors)
                                 : nullptr);
        }
    const std::size_t pixels = layer.pixels();
    result.data = {{"paths.count", std::vector<float>(pixels)},
                   {"paths.sign", std::vector<float>(pixels)},
                   {"fold", std::vector<float>(pixels)}};
    const LayerTiles tiles(layer, context.scene.state.clip);
    parallel_for(tiles.count(), 4, [&](std::size_t begin, std::size_t end) {
        std::vector<sliced_beams::PointSummary> summaries;
        for (std::size_t tile = begin; tile < end; ++tile) {
            for (const ReceiverGroup& group : tiles.groups(tile)) {
                summaries.assign(group.pixels.size(), {});
                for (std::size_t s = 0; s < sheets.size(); ++s)
                    if (points[s] && sheets[s]->sheet().in_water() == group.in_water)
                        points[s]->summarize(group.points, summaries);
                for (std::size_t k = 0; k < group.pixels.size(); ++k) {
                    result.data[0].values[group.pixels[k]] = static_cast<float>(summaries[k].count);
                    result.data[1].values[group.pixels[k]] = static_cast<float>(summaries[k].sign);
                    result.data[2].values[group.pixels[k]] = summaries[k].fold ? 1.0f : 0.0f;
                }
            }
        }
    });
}

SlicedBeams::SlicedBeams(CoverageBackend coverage) : state_(std::make_unique<State>(coverage)) {}
SlicedBeams::~SlicedBeams() = default;

Support SlicedBeams::supports_surface(const scene::FrameState& state) const {
    if (scene::has_glass(state)) {
        return {Support::Degree::partly,
                "all receivers, also behind water, glass and mirrors; none of the light that glass sends on"};
    }
    return {Support::Degree::yes, "all receivers, also behind water and mirrors"};
}

namespace {

/// Sheets of beams of a light.
struct SheetCounts {
    double transmitted, reflected;
};

SheetCounts sheet_counts(const scene::FrameState& state, const scene::Light& light) {
    const bool disc = light.type == scene::LightType::sun && light.angular_diameter > 0;
    const double parts = disc ? state.caustics.sliced_beams.sun_samples : 1;
    const double bands = state.water->dispersion > 0 ? 3 : 1;
    // Lamps send reflected light about further axes: five sheets, measured for a low one.
    return {parts * bands, parts * (light.type == scene::LightType::sun ? 1 : 5)};
}

}  // namespace

std::size_t SlicedBeams::bytes(const scene::FrameState& state, std::size_t) const {
    if (!state.water || state.water->surface.type == scene::WaterSurfaceType::mesh_sequence) return 0;
    const ocean::MeshCounts mesh = ocean::mesh_counts(*state.water);
    using Pyramid = BeamPyramid<float>;
    double vertex = sizeof(light::BeamSheet<float>::Ray) + sizeof(float) + 1;
    // Pyramids: bounds at two depths and sums a cluster of beams, and a third of that again above it.
    const double cluster = 4.0 / 3 * (2 * sizeof(sliced_beams::Box<float>) + sizeof(Pyramid::Sums));
    double beam = sizeof(float) + cluster / sliced_beams::kClusterBeams;
    if (!state.media.empty() || state.water->scattering != glm::dvec3(0)) {
        using sliced_beams::BeamWays, sliced_beams::ScatterBounds;
        vertex += BeamWays<float>::kBytesAVertex;
        beam += BeamWays<float>::kBytesABeam +
                (ScatterBounds<float>::bytes_a_cluster() + sizeof(sliced_beams::BeamCluster<float>)) /
                    double{sliced_beams::kClusterBeams};
    }
    double sheets = 0, tinted = 0;
    for (const scene::Light& light : state.lights) {
        const SheetCounts counts = sheet_counts(state, light);
        sheets += counts.transmitted + counts.reflected;
        if (light::may_tint(state, light)) tinted += counts.transmitted + counts.reflected;
    }
    // While beams are traced and paths counted: events of vertices, shares and flags of triangles; on the
    // device a copy of the rays and indices of corners.
    const double vertices = static_cast<double>(mesh.vertices),
                 triangles = static_cast<double>(mesh.triangles);
    const double depths = state.media.empty() ? 0 : 3 * sizeof(float);
    double beside = (29 + depths) * vertices + 22 * triangles;
    // Channels are traced one by one before they are one sheet.
    constexpr double tint = sizeof(glm::vec3);
    if (tinted > 0)
        beside += 2 * (sizeof(light::BeamSheet<float>::Ray) + 5) * vertices + (tinted + 1) * tint * triangles;
    const double columns =
        state.media.empty() ? 0 : sliced_beams::RayColumns<float>::bytes(vertices, state.media.size());
    return static_cast<std::size_t>(
        std::min(0x1p61, beside + sheets * (vertex * vertices + beam * triangles + columns)));
}

std::size_t SlicedBeams::bytes_on(gpu::DeviceType type, const scene::FrameState& state) const {
    if (!state_->computes(type) || !state.water ||
        state.water->surface.type == scene::WaterSurfaceType::mesh_sequence)
        return 0;
    if (state.media.empty() && state.water->scattering == glm::dvec3(0)) return 0;
    // Of the sheets in the water, which the pass of scattered light takes, and of one the host's copy while
    // it goes up.
    double sheets = 1;
    for (const scene::Light& light : state.lights) {
        const SheetCounts counts = sheet_counts(state, light);
        const bool below = light.type != scene::LightType::sun && light.position.y < 0;
        sheets += below ? counts.reflected : counts.transmitted;
    }
    const ocean::MeshCounts mesh = ocean::mesh_counts(*state.water);
    using sliced_beams::ScatterTree;
    return static_cast<std::size_t>(
        std::min(0x1p61, sheets * (ScatterTree::bytes_a_vertex() * static_cast<double>(mesh.vertices) +
                                   ScatterTree::bytes_a_beam() * static_cast<double>(mesh.triangles))));
}

namespace {

/// Depth along the sheet's axis that no receiver lies beyond.
float deepest(const rays::RayScene& rays, const light::BeamSheet<float>& sheet) {
    glm::vec3 low, high;
    rays.object_bounds(low, high);
    const glm::vec3 axis(sheet.world_from_mesh[2]);
    const glm::vec3 corner = glm::mix(low, high, glm::greaterThan(axis, glm::vec3(0)));
    const float depth = glm::dot(corner, axis);
    return depth + 1e-3f * (1 + std::abs(depth));
}

/// Receivers whose footprint has no area or is not finite have no mean irradiance.
void count_left_out(const view::ReceiverLayer& layer, const LayerResult& result, FrameStats& stats) {
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i)
        left_out += (layer.flags[i] & view::kReceiver) != 0 && !result.covered[i] ? 1 : 0;
    if (left_out > 0) stats.count("receivers without a footprint", static_cast<double>(left_out));
}

}  // namespace

bool SlicedBeams::State::computes(gpu::DeviceType type) const {
    return backend == CoverageBackend::compute ||
           (backend == CoverageBackend::automatic && computes_by_default(type));
}

void SlicedBeams::State::choose_backend(FrameContext& context) {
    const ScopedPass pass_time(context.stats, "coverage");
    on_device = computes(context.device.info().type);
    if (!on_device) return;
    if (!pass) pass = std::make_unique<CoveragePass>(context.device);
    on_device = pass->begin(sheets);
}

Support SlicedBeams::supports_volume(const scene::FrameState& state) const {
    if (scene::has_glass(state)) {
        return {Support::Degree::partly,
                "light scattered once, without noise; none of the light that glass sends on"};
    }
    return {Support::Degree::yes, "light scattered once, without noise"};
}

void SlicedBeams::begin(FrameContext& context) {
    state_->volume.reset();
    state_->points.clear();
    state_->neighbors.reset();
    state_->sheets.clear();
    const int sun_samples = context.scene.state.caustics.sliced_beams.sun_samples;
    for (const light::Chain& chain : context.chains) {
        std::vector<light::BeamSheet<float>> sheets =
            light::water_beams<float>(context.scene, context.rays, chain, sun_samples, context.stats);
        const ScopedPass pass(context.stats, "beam pyramid");
        for (light::BeamSheet<float>& sheet : sheets) {
            const float depth = deepest(context.rays, sheet);
            state_->sheets.push_back(
                std::make_unique<SheetCoverage<float>>(context.scene, context.rays, std::move(sheet), depth));
            const std::size_t coarse = state_->sheets.back()->columns().coarse_rays();
            if (coarse > 0) context.stats.count("rays of coarse columns", static_cast<double>(coarse));
        }
    }
    state_->choose_backend(context);
}

/// Light that is found at lattices' nodes for all layers together.
void SlicedBeams::State::find_shared(const FrameContext& context, std::span<const view::ReceiverLayer> layers,
                                     QueryCounts& counts) {
    lattice.emplace(context.scene, sheets);
    std::vector<LightLattice::Request> all;
    for (const view::ReceiverLayer& layer : layers) {
        const LayerTiles tiles(layer, context.scene.state.clip);
        constexpr std::size_t kPart = 16;
        std::vector<std::vector<LightLattice::Request>> parts(tiles.count() / kPart + 1);
        parallel_for(tiles.count(), kPart, [&](std::size_t begin, std::size_t end) {
            for (std::size_t tile = begin; tile < end; ++tile)
                for (const ReceiverGroup& group : tiles.groups(tile))
                    for (std::size_t s = 0; s < sheets.size(); ++s)
                        if (sheets[s]->sheet().in_water() == group.in_water)
                            lattice->ask(s, group, parts[begin / kPart]);
        });
        for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    }
    lattice->find(std::move(all), counts);
}

void SlicedBeams::irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                             std::span<LayerResult> results) {
    const bool blurred = std::any_of(state_->sheets.begin(), state_->sheets.end(),
                                     [](const auto& sheet) { return sheet->blurs(); });
    state_->lattice.reset();
    if (blurred) {
        const ScopedPass pass(context.stats, "coverage");
        QueryCounts counts;
        state_->find_shared(context, layers, counts);
        counts.report(context.stats);
        context.stats.count("lattice nodes", static_cast<double>(state_->lattice->nodes()));
    }
    for (std::size_t i = 0; i < layers.size(); ++i) {
        if (layers[i].sample == 0 && layers[i].branch == 0 &&
            context.scene.state.caustics.sliced_beams.path_counts) {
            const ScopedPass pass(context.stats, "path counts");
            state_->find_points(context, layers[i], results[i]);
        }
        const LayerTiles tiles(layers[i], context.scene.state.clip);
        QueryCounts counts;
        if (state_->on_device)
            state_->pass->irradiance(tiles, state_->lattice ? &*state_->lattice : nullptr, results[i], counts,
                                     context.stats);
        else
            state_->cover(tiles, results[i], counts, context.stats);
        counts.report(context.stats);
        count_left_out(layers[i], results[i], context.stats);
    }
}

void SlicedBeams::in_scatter(FrameContext& context, const view::SegmentLayer& layer,
                             std::span<glm::vec3> radiance) {
    if (!state_->volume) {
        const ScopedPass pass(context.stats, "scattering");
        if (state_->computes(context.device.info().type) && !state_->scatter_pass)
            state_->scatter_pass = std::make_unique<ScatterPass>(context.device);
        state_->volume.emplace(context.scene, state_->sheets, context.stats, state_->scatter_pass.get());
    }
    ScatterCounts counts;
    {
        const ScopedPass pass(context.stats, "scattering");
        state_->volume->add(layer, radiance, counts);
    }
    state_->volume->add_on_device(layer, radiance, counts, context.stats);
    counts.report(context.stats);
}

/// E of all receivers of a layer by the CPU.
void SlicedBeams::State::cover(const LayerTiles& tiles, LayerResult& result, QueryCounts& all,
                               FrameStats& stats) const {
    const ScopedPass time(stats, "coverage");
    std::vector<QueryCounts> counts(tiles.count());
    parallel_for(tiles.count(), 4, [&](std::size_t begin, std::size_t end) {
        std::vector<glm::vec3> irradiance;
        for (std::size_t tile = begin; tile < end; ++tile) {
            for (const ReceiverGroup& group : tiles.groups(tile)) {
                irradiance.assign(group.pixels.size(), glm::vec3(0));
                for (std::size_t s = 0; s < sheets.size(); ++s) {
                    if (sheets[s]->sheet().in_water() != group.in_water) continue;
                    const auto alone = [&](const ReceiverGroup& part, std::span<glm::vec3> to) {
                        sheets[s]->add(part.receivers, part.object, to, counts[tile]);
                    };
                    if (lattice)
                        lattice->add_with(s, group, irradiance, alone);
                    else
                        alone(group, irradiance);
                }
                for (std::size_t k = 0; k < group.pixels.size(); ++k) {
                    result.irradiance[group.pixels[k]] = irradiance[k];
                    result.covered[group.pixels[k]] = 1;
                }
            }
        }
    });
    for (const QueryCounts& tile : counts) all.add(tile);
}

}  // namespace dapple::methods
