// adaptive_beams among bounded media: columns found on the device, closed forms and quadratures below and
// above flat water.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/packing.hpp>
#include <memory>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "base/hash.h"
#include "gpu/validated_device.h"
#include "grids/dense_bricks.h"
#include "media/media.h"
#include "methods/adaptive_beams/beam_renderer.h"
#include "methods/adaptive_beams/make_beams.h"
#include "methods/adaptive_beams/media_columns.h"
#include "methods/adaptive_frame.h"
#include "methods/adaptive_media.h"
#include "methods/drawn_sheets.h"

namespace dapple {
namespace {

using namespace test::adaptive_frame;
using grids::DensityGrid;

/// Puffs in 3 of 8 octants of a box across the origin of its index space.
std::shared_ptr<const DensityGrid> puffs() {
    return grid_of({-21, -13, -17}, {43, 30, 37}, 0.07, [](glm::ivec3 at) {
        const int octant = (at.x > 0 ? 1 : 0) + (at.y > 0 ? 2 : 0) + (at.z > 0 ? 4 : 0);
        if (octant != 0 && octant != 3 && octant != 6) return 0.0;
        const glm::dvec3 p(at);
        return std::max(0.0,
                        std::sin(0.3 * p.x) * std::cos(0.4 * p.y + 0.1 * p.x) + 0.6 * std::sin(0.5 * p.z));
    });
}

TEST(DenseBricks, HoldEveryVoxelOfTheBlocksThatHaveDensity) {
    const auto grid = puffs();
    const grids::DenseBricks bricks = grids::dense_bricks(*grid, 256);
    DensityGrid::Reader reader(*grid);
    const auto row = static_cast<std::size_t>(bricks.extent().x);
    const auto slice = row * static_cast<std::size_t>(bricks.extent().y);
    std::size_t occupied = 0, empty = 0;
    double worst = 0;
    for (std::size_t i = 0; i < bricks.brick.size(); ++i) {
        const auto n = static_cast<int>(i);
        const glm::ivec3 block =
            bricks.first + glm::ivec3(n % bricks.count.x, n / bricks.count.x % bricks.count.y,
                                      n / (bricks.count.x * bricks.count.y));
        const int brick = bricks.brick[i];
        ++(brick < 0 ? empty : occupied);
        for (int z = 0; z < 9; ++z)
            for (int y = 0; y < 9; ++y)
                for (int x = 0; x < 9; ++x) {
                    const float voxel = reader.voxel(8 * block + glm::ivec3(x, y, z));
                    if (brick < 0) {
                        // All that touches its cells.
                        EXPECT_EQ(voxel, 0);
                        continue;
                    }
                    const glm::ivec3 at =
                        9 * glm::ivec3(brick % bricks.size.x, brick / bricks.size.x % bricks.size.y,
                                       brick / (bricks.size.x * bricks.size.y)) +
                        glm::ivec3(x, y, z);
                    const float texel = glm::unpackHalf1x16(
                        bricks.texels[static_cast<std::size_t>(at.z) * slice +
                                      static_cast<std::size_t>(at.y) * row + static_cast<std::size_t>(at.x)]);
                    worst = std::max(worst, static_cast<double>(std::abs(bricks.scale * texel - voxel)));
                }
    }
    EXPECT_GT(occupied, 20u);
    EXPECT_GT(empty, 20u);
    // Half floats have 11 bits.
    EXPECT_LT(worst, 0x1p-11 * static_cast<double>(grid->maximum()));
    try {
        grids::dense_bricks(*grid, 16);
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
    }
}

TEST(DenseBricks, TakeNoMoreThanTheirEstimate) {
    const auto grid = puffs();
    const grids::DenseBricks bricks = grids::dense_bricks(*grid, 256);
    grids::VdbGridInfo info;
    info.low = grid->low();
    info.high = grid->high();
    info.active_voxels = static_cast<std::int64_t>(grid->active_voxels());
    const std::uint64_t box = grids::brick_bytes(info);
    const auto occupied = static_cast<std::uint64_t>(
        std::count_if(bricks.brick.begin(), bricks.brick.end(), [](int brick) { return brick >= 0; }));
    const std::uint64_t needed = 4 * 729 * occupied + 8 * bricks.brick.size();
    EXPECT_EQ(box, (4 * 729 + 8) * bricks.brick.size());
    EXPECT_GT(box, needed);
    // A tree of few leaves in the same box: each reaches into eight blocks at most, besides full tiles.
    info.loading_bytes = 2 * 2048 * 3;
    info.active_voxels = 512;
    EXPECT_EQ(grids::brick_bytes(info), 4 * 729 * 32 + 8 * bricks.brick.size());
    // As many as blocks with voxels, at least an eighth of those with cells about them.
    info.active_voxels = 1;
    info.loading_bytes = 2 * 2048 * occupied;
    EXPECT_GE(grids::brick_bytes(info), needed);
}

TEST(MediaColumns, AreThoseOfTheExactWalk) {
    scene::FrameScene scene;
    scene.state.media = {medium(scene::MediumType::grid), medium(scene::MediumType::box, {1, 0.5, 2})};
    scene.state.media[0].transform.rotation = {0.3, 0.5, -0.2};
    scene.state.media[0].transform.position = {0.2, 0.1, 0};
    scene.state.media[0].density = 1.7;
    scene.state.media[1].transform.rotation = {0, 1, 0};
    scene.state.media[1].density = 0.3;
    scene.medium_grids = {puffs(), nullptr};
    const media::Media media(scene);
    FrameStats stats;
    gpu::Device& device = test::validated_device();
    methods::adaptive_beams::MediaColumns columns(device);
    columns.begin(scene, media, stats);
    const std::vector<double> voxels = {40, 0};
    const methods::adaptive_beams::ColumnTable table = columns.table(false, voxels);
    ASSERT_EQ(table.columns.size(), 2u);
    EXPECT_EQ(columns.table(true, voxels).entry, 0u);  // without water

    constexpr std::size_t kLines = 300;
    gpu::Buffer lines(device, "lines", kLines * sizeof(layout::MediaLine));
    gpu::Buffer values(device, "values", kLines * table.entry * sizeof(float));
    const auto roll = [](std::size_t i, std::uint32_t k) { return 2 * hash_uniform(5, 0, i, k) - 1; };
    for (std::size_t i = 0; i < kLines; ++i) {
        layout::MediaLine& line = lines.as<layout::MediaLine>()[i];
        line.origin = 2.0 * glm::dvec3(roll(i, 0), roll(i, 1), roll(i, 2));
        line.direction = 2.0 * glm::normalize(glm::dvec3(roll(i, 3), roll(i, 4), roll(i, 5)) -
                                              0.5 * glm::dvec3(line.origin));
        if (i == 0) line.direction = {0, 0, 2};
        line.begin = 0.1f;
        line.end = static_cast<float>(1.1 + roll(i, 6));
        line.in_water = 0;
    }
    gpu::PassList passes(device);
    columns.add(passes, table, false, lines, kLines, values, table.entry);
    passes.run(stats);
    double worst[2] = {}, largest[2] = {};
    for (std::size_t i = 0; i < kLines; ++i) {
        const layout::MediaLine& line = lines.as<layout::MediaLine>()[i];
        for (std::size_t p = 0; p < 2; ++p) {
            const media::Body& body = media.parts()[table.columns[p].part].body;
            const float* entry = &values.as<float>()[i * table.entry + table.columns[p].first];
            const glm::dvec3 direction(line.direction);
            const double stretch = glm::length(direction);
            const glm::dvec3 start = glm::dvec3(line.origin) + static_cast<double>(line.begin) * direction;
            const double all = static_cast<double>(line.end - line.begin) * stretch;
            ASSERT_LE(entry[2] + 1, static_cast<float>(table.columns[p].places));
            for (std::uint32_t k = 0; k <= static_cast<std::uint32_t>(entry[2]); ++k) {
                const double t = entry[1] > 0 ? static_cast<double>(entry[0] - line.begin) +
                                                    k / static_cast<double>(entry[1])
                                              : 0;
                const double length = entry[1] > 0 ? std::min(all, t * stretch) : all;
                const media::Interval overlap = body.overlap(start, direction / stretch, length);
                const double exact = overlap.empty() ? 0 : body.column(start, direction / stretch, overlap);
                worst[p] = std::max(worst[p], std::abs(static_cast<double>(entry[3 + k]) - exact));
                largest[p] = std::max(largest[p], exact);
            }
        }
    }
    printf("columns: of a grid off by %.1e of %.2f m, of a box by %.1e of %.2f m\n", worst[0], largest[0],
           worst[1], largest[1]);
    EXPECT_GT(largest[0], 1);
    EXPECT_GT(largest[1], 0.2);
    // Half floats and steps of a voxel across the kinks of a trilinear density; devices round filters'
    // weights to 8 bits. Boxes: floats.
    EXPECT_LT(worst[0], 5e-3 * largest[0]);
    EXPECT_LT(worst[1], 2e-6);
}

constexpr double kIsotropic = 0.25 * std::numbers::inv_pi;

/// (1 - e^(-a s)) / a.
double faded(double a, double s) {
    return std::abs(a * s) > 1e-12 ? -std::expm1(-a * s) / a : s;
}

TEST(Fog, InASlabOfClearWaterHasTheClosedForm) {
    // From 0.7 to 0.3 m deep, its faces level; light from 50 degrees goes down it obliquely.
    scene::FrameScene scene = pool(50);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene.state.media = {medium(scene::MediumType::box, {50, 0.4, 50})};
    scene.state.media[0].transform.position = {0, -0.5, 0};
    scene.state.media[0].density = 2;
    Frame frame(scene);
    EXPECT_EQ(frame.method.supports_volume(scene.state).degree, methods::Support::Degree::partly);
    const double cos_t = -direction_in_water(50).y;
    double worst_e = 0, worst_s = 0;
    view::SegmentLayer segments;
    const view::ReceiverLayer layer = frame.receivers(0, segments);
    const methods::LayerResult result = frame.irradiance(layer);
    const std::vector<glm::vec3> radiance = frame.in_scatter(segments);
    ASSERT_EQ(segments.segments(), layer.pixels());
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        const glm::dvec3 direction(segments.direction[i]), sun = scene.state.lights[0].irradiance;
        ASSERT_LT(direction.y, -0.5);
        for (int c = 0; c < 3; ++c) {
            const double extinction = 2 * scene.state.media[0].extinction[c];
            const double e = sun[c] * cos_t * across(50) * std::exp(-extinction * 0.4 / cos_t);
            worst_e = std::max(worst_e, std::abs(static_cast<double>(result.irradiance[i][c]) / e - 1));
            const double s = extinction * scene.state.media[0].albedo[c] * kIsotropic * sun[c] * across(50) *
                             faded(extinction * (1 - direction.y / cos_t), 0.4 / -direction.y);
            worst_s = std::max(worst_s, std::abs(static_cast<double>(radiance[i][c]) / s - 1));
        }
    }
    printf("slab: E off by %.1e, S by %.1e\n", worst_e, worst_s);
    // Floats; the exponential's mean is exact where optical depth is linear.
    EXPECT_LT(worst_e, 2e-5);
    EXPECT_LT(worst_s, 1e-4);
}

TEST(Fog, InTheAirScattersAndDimsWhatTheWaterMirrors) {
    scene::FrameScene scene = pool(50);
    scene.state.media = {medium(scene::MediumType::box, {50, 0.6, 50})};
    scene.state.media[0].side = scene::MediumSide::air;
    scene.state.media[0].transform.position = {0, 0.6, 0};
    scene.state.camera.position = {0.3, 1.2, 0.3};
    scene.state.camera.target = {0.6, 0, -0.1};
    Frame frame(scene, light::Event::reflection);
    view::SegmentLayer segments;
    frame.receivers(0, segments);
    const std::vector<glm::vec3> radiance = frame.in_scatter(segments);
    const double cos_i = std::sin(50 * scene::kDegree);
    const double reflectance = 1 - test::flat_floor(40, 1, kIndex).irradiance / cos_i;
    double worst = 0;
    std::size_t tested = 0;
    for (std::size_t i = 0; i < segments.segments(); ++i) {
        if (!segments.primary[i] || segments.in_water[i]) continue;
        ++tested;
        const glm::dvec3 direction(segments.direction[i]);
        for (int c = 0; c < 3; ++c) {
            const double extinction = scene.state.media[0].extinction[c];
            const double slant = 0.6 / cos_i, along = 0.6 / -direction.y;
            // Down through the slab, mirrored; up to the slab's far end, back by the shorter way.
            const double s = extinction * scene.state.media[0].albedo[c] * kIsotropic *
                             scene.state.lights[0].irradiance[c] * reflectance *
                             std::exp(-2 * extinction * slant) *
                             faded(extinction * (1 + direction.y / cos_i), along);
            worst = std::max(worst, std::abs(static_cast<double>(radiance[i][c]) / s - 1));
        }
    }
    printf("slab in the air: S off by %.1e\n", worst);
    EXPECT_GT(tested, 1000u);
    EXPECT_LT(worst, 1e-4);
}

TEST(Fog, NarrowerThanABeamIsLitByAllThatTheWaterMirrors) {
    // Few rays of light meet the box, if any; what it dims is next to nothing.
    scene::FrameScene scene = pool(50);
    scene.state.media = {medium(scene::MediumType::box, {0.5, 0.4, 0.3})};
    scene.state.media[0].side = scene::MediumSide::air;
    scene.state.media[0].density = 1e-4;
    scene.state.media[0].transform.rotation = {0.3, 0.5, -0.2};
    scene.state.camera.position = {0.3, 1.4, 1.5};
    const double mirrored = 1 - test::flat_floor(40, 1, kIndex).irradiance / std::sin(50 * scene::kDegree);
    for (const double x : {-0.3, 0.1, 0.6}) {
        scene.state.media[0].transform.position = {x, 0.7, -0.1};
        scene.state.camera.target = scene.state.media[0].transform.position;
        Frame frame(scene, light::Event::reflection);
        const media::Media media(scene);
        view::SegmentLayer segments;
        frame.receivers(0, segments);
        const std::vector<glm::vec3> radiance = frame.in_scatter(segments);
        double worst = 0;
        std::size_t tested = 0;
        for (std::size_t i = 0; i < segments.segments(); ++i) {
            if (!segments.primary[i] || segments.in_water[i]) continue;
            const glm::dvec3 depth =
                media.optical_depth(glm::dvec3(segments.origin[i]), glm::dvec3(segments.direction[i]),
                                    static_cast<double>(segments.length[i]), false);
            if (depth.x < 1e-6) continue;
            ++tested;
            for (int c = 0; c < 3; ++c) {
                const double s = depth[c] * scene.state.media[0].albedo[c] * kIsotropic *
                                 scene.state.lights[0].irradiance[c] * mirrored;
                worst = std::max(worst, std::abs(static_cast<double>(radiance[i][c]) / s - 1));
            }
        }
        printf("narrow fog at %.1f: S of %zu pixels off by %.1e\n", x, tested, worst);
        EXPECT_GT(tested, 100u);
        // Three ways through the box, of optical depth 1e-4 at most; floats near its edges.
        EXPECT_LT(worst, 2e-3);
    }
}

/// Murky water with a grid whose density grows with depth and to the side, and a box beside it that both have
/// phase functions of their own.
scene::FrameScene mixed() {
    scene::FrameScene scene = pool(50);
    scene.state.water->absorption = {0.1, 0.05, 0.2};
    scene.state.water->scattering = {0.1, 0.2, 0.05};
    scene.state.water->phase.type = scene::PhaseType::fournier_forand;
    scene.state.media = {medium(scene::MediumType::grid), medium(scene::MediumType::box, {0.3, 3, 3})};
    scene.state.media[0].side = scene::MediumSide::water;
    scene.state.media[0].density = 1.5;
    scene.state.media[0].phase.type = scene::PhaseType::two_lobe;
    scene.state.media[1].transform.position = {0.25, 0, 0};
    scene.state.media[1].side = scene::MediumSide::water;
    scene.state.media[1].phase.type = scene::PhaseType::table;
    scene.state.media[1].phase.samples = {{0, 3}, {1, 1}, {3, 2}};
    scene.medium_grids = {grid_of({-20, -13, -20}, {41, 12, 41}, 0.05,
                                  [](glm::ivec3 at) { return -0.1 * at.y + 0.02 * (20 + at.x); }),
                          nullptr};
    return scene;
}

/// Relative errors of E and S against a quadrature in double with the exact walk through the media.
struct Errors {
    double e = 0, s = 0;              ///< sum of the errors over the sum
    double worst_e = 0, worst_s = 0;  ///< of a pixel and channel
};

Errors errors_of(const scene::FrameScene& scene) {
    Frame frame(scene);
    const media::Media media(scene);
    view::SegmentLayer segments;
    const view::ReceiverLayer layer = frame.receivers(0, segments);
    const methods::LayerResult result = frame.irradiance(layer);
    const std::vector<glm::vec3> radiance = frame.in_scatter(segments);
    const glm::dvec3 light = direction_in_water(50), sun = across(50) * scene.state.lights[0].irradiance;
    const auto dimmed = [&](glm::dvec3 at) {
        const double way = at.y / light.y;
        return glm::exp(-media.optical_depth(at - way * light, light, way, true));
    };
    Errors errors;
    double sum_e = 0, sum_s = 0;
    for (std::size_t i = 0; i < layer.pixels(); i += 7) {
        const glm::dvec3 origin(segments.origin[i]), direction(segments.direction[i]);
        const double cosine = -glm::dot(direction, light);
        glm::dvec3 sum(0);
        constexpr int kSteps = 600;
        const double step = static_cast<double>(segments.length[i]) / kSteps;
        for (int k = 0; k < kSteps; ++k) {
            const double t = (k + 0.5) * step;
            const glm::dvec3 at = origin + t * direction;
            glm::dvec3 scatters(0);
            for (std::size_t c = 0; c < media.components().size(); ++c)
                scatters +=
                    media.density(c, at, true) * media.phase(c, cosine) * media.components()[c].scattering;
            if (scatters == glm::dvec3(0)) continue;
            sum += step * scatters * dimmed(at) * glm::exp(-media.optical_depth(origin, direction, t, true));
        }
        const glm::dvec3 s = sum * sun, e = sun * -light.y * dimmed(glm::dvec3(layer.position[i]));
        for (int c = 0; c < 3; ++c) {
            const double s_error = std::abs(static_cast<double>(radiance[i][c]) - s[c]);
            const double e_error = std::abs(static_cast<double>(result.irradiance[i][c]) - e[c]);
            if (s[c] > 0) errors.worst_s = std::max(errors.worst_s, s_error / s[c]);
            errors.worst_e = std::max(errors.worst_e, e_error / e[c]);
            errors.s += s_error;
            errors.e += e_error;
            sum_s += s[c];
            sum_e += e[c];
        }
    }
    errors.s /= sum_s;
    errors.e /= sum_e;
    return errors;
}

TEST(Gradient, AndOtherMediaHaveWhatAQuadratureFinds) {
    const Errors errors = errors_of(mixed());
    printf("gradient: E off by %.1e, at worst %.1e; S by %.1e, at worst %.1e\n", errors.e, errors.worst_e,
           errors.s, errors.worst_s);
    // Half floats; along a linear density the columns between places of a table are parabolas (2e-5 of a
    // column), and light comes into the box somewhere within a panel.
    EXPECT_LT(errors.worst_e, 5e-4);
    EXPECT_LT(errors.s, 1e-3);
    EXPECT_LT(errors.worst_s, 4e-3);
}

TEST(Puffs, HaveWhatAQuadratureFindsAlsoInWideBeams) {
    scene::FrameScene scene = mixed();
    scene.state.media.pop_back();
    scene.state.water->scattering = glm::dvec3(0);
    scene.medium_grids = {puffs()};
    scene.state.media[0].transform.position = {0, -0.6, 0};
    scene.state.media[0].transform.scale = glm::dvec3(0.6);
    for (const int grid : {8, 64}) {
        scene.state.caustics.adaptive_beams.grid = grid;
        const Errors errors = errors_of(scene);
        printf("puffs, %d beams a side: E off by %.1e, S by %.1e\n", grid, errors.e, errors.s);
        // Voxels of 4 cm, and puffs of some 6 voxels: between rays two voxels apart their columns are
        // interpolated, with an error of second order.
        EXPECT_LT(errors.e, 0.02);
        EXPECT_LT(errors.s, 0.02);
    }
}

/// The beams of a scene, drawn by a renderer.
methods::adaptive_beams::BeamSums drawn(const scene::FrameScene& scene,
                                        methods::adaptive_beams::Shading shading,
                                        std::uint64_t largest_buffer = std::uint64_t{1} << 30) {
    FrameStats stats;
    const rays::RayScene rays(scene);
    gpu::Device& device = test::validated_device();
    methods::FrameContext context{scene, rays, device, stats, {{0, light::Event::transmission}}};
    const std::vector<methods::adaptive_beams::BeamSet> sets = methods::adaptive_beams::make_beams(context);
    view::SegmentLayer segments;
    view::LayerCounts counts;
    const view::ReceiverLayer layer = view::trace_layer(scene, rays, {}, counts, &segments);
    methods::adaptive_beams::BeamRenderer renderer(device, largest_buffer);
    renderer.begin(scene, sets, methods::adaptive_beams::VolumeKind::six_triangles, shading, stats);
    return renderer.render(&segments, &layer, stats);
}

TEST(Grids, DimEveryRayOfABeamOnItsOwnWay) {
    // Four by four beams that meet 1 m deep, over a floor before and one beyond the focus; the grid grows
    // denser to one side.
    scene::FrameScene scene = pool(90);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene.state.media = {medium(scene::MediumType::grid)};
    scene.medium_grids = {
        grid_of({-8, -40, -8}, {17, 40, 17}, 0.05, [](glm::ivec3 at) { return 0.1 * (8 + at.x); })};
    scene.state.camera.projection = scene::Projection::orthographic;
    scene.state.camera.up = {0, 0, -1};
    const media::Media media(scene);
    for (const double depth : {0.7, 1.5}) {
        scene.state.objects = {test::floor_at(-depth, 100)};
        scene.state.camera.position = {0, -depth + 0.1, 0};
        scene.state.camera.target = {0, -depth, 0};
        const double width = 0.4 * std::abs(1 - depth);
        scene.state.camera.view_height = 0.9 * width;
        scene.state.clip.width = scene.state.clip.height = 24;
        const rays::RayScene rays(scene);
        FrameStats stats;
        view::SegmentLayer segments;
        view::LayerCounts counts;
        const view::ReceiverLayer layer = view::trace_layer(scene, rays, {}, counts, &segments);
        const methods::adaptive_beams::BeamSet lens = test::lens_of_beams(1);
        methods::adaptive_beams::BeamRenderer renderer(test::validated_device(), std::uint64_t{1} << 30);
        renderer.begin(scene, {&lens, 1}, methods::adaptive_beams::VolumeKind::six_triangles,
                       methods::adaptive_beams::Shading::exact, stats);
        const auto found = renderer.render(&segments, &layer, stats).irradiance;
        double worst = 0, brightest = 0, darkest = 1;
        for (std::size_t i = 0; i < layer.pixels(); ++i) {
            const glm::dvec3 end(layer.position[i]);
            const glm::dvec3 start(end.x / (1 - depth), 0, end.z / (1 - depth));
            const double way = glm::distance(start, end);
            const glm::dvec3 left = glm::exp(-media.optical_depth(start, (end - start) / way, way, true));
            const double expected = 32 / (width * width) * left.r;
            brightest = std::max(brightest, left.r);
            darkest = std::min(darkest, left.r);
            worst = std::max(worst, std::abs(static_cast<double>(found[i].r) / expected - 1));
        }
        printf("grid over a floor at %g m: E off by %.1e\n", depth, worst);
        EXPECT_LT(darkest, 0.9 * brightest);
        // Half floats; between places of a table columns are parabolas.
        EXPECT_LT(worst, 1e-3);
    }
}

TEST(Rows, OfAPictureMayBeDrawnByThemselves) {
    // An entry of the grid and the box is 72 floats a pixel, a row of 40 pixels 11520 bytes: three rows at a
    // time.
    using methods::adaptive_beams::Shading;
    const scene::FrameScene scene = mixed();
    const auto whole = drawn(scene, Shading::exact), parts = drawn(scene, Shading::exact, 36000);
    double worst = 0;
    for (std::size_t i = 0; i < whole.scattered.size(); ++i) {
        EXPECT_GT(whole.scattered[i].g, 0);
        worst = std::max(worst, static_cast<double>(glm::length(parts.scattered[i] - whole.scattered[i]) /
                                                    glm::length(whole.scattered[i])));
        worst = std::max(worst, static_cast<double>(glm::length(parts.irradiance[i] - whole.irradiance[i]) /
                                                    glm::length(whole.irradiance[i])));
    }
    printf("drawn by rows: %.1e apart\n", worst);
    // Rays of pixels are rounded from another first row; tables along light have fewer places, if any.
    EXPECT_LT(worst, 2e-3);
}

TEST(Paper, HasTheSumsOfTheExactShadingAmongMedia) {
    using methods::adaptive_beams::Shading;
    scene::FrameScene scene = mixed();
    scene.state.caustics.adaptive_beams.grid = 32;
    const auto exact = drawn(scene, Shading::exact);
    scene.state.caustics.adaptive_beams.paper_faithful = true;
    const auto paper = drawn(scene, Shading::paper);
    glm::dvec3 s[2] = {}, e[2] = {};
    for (std::size_t i = 0; i < exact.scattered.size(); ++i) {
        s[0] += exact.scattered[i];
        s[1] += paper.scattered[i];
        e[0] += exact.irradiance[i];
        e[1] += paper.irradiance[i];
    }
    const glm::dvec3 s_error = glm::abs(s[1] / s[0] - 1.0), e_error = glm::abs(e[1] / e[0] - 1.0);
    printf("as in the paper: S off by %.1e, E by %.1e\n", std::max({s_error.x, s_error.y, s_error.z}),
           std::max({e_error.x, e_error.y, e_error.z}));
    // One transmittance a beam, in its middle, also where the box begins within it; beams are some 20 cm long
    // along camera rays.
    EXPECT_LT(std::max({s_error.x, s_error.y, s_error.z}), 0.05);
    EXPECT_LT(std::max({e_error.x, e_error.y, e_error.z}), 0.005);
}

}  // namespace
}  // namespace dapple
