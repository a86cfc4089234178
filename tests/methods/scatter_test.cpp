// Scattered light of sheets over waves and about objects: paths, fluxes, shadows, hard cases.
#include <gtest/gtest.h>

#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "closed_form/gentle_sea.h"
#include "closed_form/segment_row.h"
#include "methods/sliced_beams/point_query.h"
#include "methods/sliced_beams/scatter_sheet.h"
#include "methods/sliced_beams/volume_light.h"
#include "rays/shape_mesh.h"

namespace dapple {
namespace {

using namespace methods::sliced_beams;
using light::Event;
using test::Ends;
using test::SheetSet;

/// h of 24 gentle waves with its slopes, times `scale`.
test::HeightField sea(double scale) {
    return [scale, waves = test::gentle_waves().waves](double x, double z) {
        glm::dvec3 h(0);
        for (const scene::Wave& wave : waves) {
            const glm::dvec2 k = 2 * glm::pi<double>() / wave.length *
                                 glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
            const double phase = k.x * x + k.y * z + wave.phase;
            h += scale * wave.amplitude *
                 glm::dvec3(std::cos(phase), -k.x * std::sin(phase), -k.y * std::sin(phase));
        }
        return h;
    };
}

/// S of segments by all sheets of a scene, as a layer of one row.
struct Scattered {
    std::vector<glm::dvec3> values;
    ScatterCounts counts;
};

Scattered scattered(const scene::FrameScene& scene, const SheetSet<float>& set, const std::vector<Ends>& ends,
                    int sample = 0) {
    view::SegmentLayer layer = test::row_of_segments(ends);
    layer.sample = sample;
    FrameStats stats;
    const VolumeLight light(scene, set.sheets(), stats);
    std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
    Scattered result;
    light.add(layer, radiance, result.counts);
    result.values.assign(radiance.begin(), radiance.end());
    return result;
}

scene::FrameScene rough_pool(int cells = 120) {
    scene::FrameScene scene = test::scene_of_water({6, 6}, cells, cells, sea(3));
    scene.state.lights = {test::sun_from_zenith(25)};
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    scene.state.water->absorption = {0.3, 0.1, 0.05};
    return scene;
}

TEST(Scatter, PiecesCoverPointsAsOftenAsPathsMeetThem) {
    const scene::FrameScene scene = rough_pool();
    const SheetSet<float> set(scene, Event::transmission, 8);
    const auto& coverage = *set.sheets().front();
    const ScatterSheet<float> scatter(coverage);
    const BeamNeighbors neighbors(scene.water->rows, scene.water->columns, scene.water->mesh.triangles);
    const PointQuery<float> query(coverage, neighbors);
    std::mt19937 random(6);
    std::uniform_real_distribution<float> uniform(-1, 1);
    int checked = 0, several = 0, wrong = 0;
    for (int round = 0; round < 40; ++round) {
        SegmentGroup<float> group;
        for (int lane = 0; lane < 8; ++lane) {
            glm::vec3 d(uniform(random), 0.3f * uniform(random), uniform(random));
            d = glm::normalize(d);
            const glm::vec3 o(uniform(random), -2.2f + uniform(random), uniform(random));
            for (int k = 0; k < 3; ++k) {
                group.origin[k][lane] = o[k];
                group.direction[k][lane] = d[k];
            }
            group.length[lane] = 1;
        }
        struct Piece {
            float from, to;
            int sign;
        };
        std::vector<Piece> pieces[8];
        const SegmentLanes<float> lanes = scatter.in_sheet(group);
        scatter.bounds().visit(lanes, {0, 0}, [&](auto node, const auto& from, const auto& to) {
            const Mask<float> met = from <= to;
            const Lanes<float> middle = met ? 0.5f * (from + to) : Lanes<float>{};
            const Lanes<float> half = met ? 0.5f * (to - from) : Lanes<float>{};
            const SegmentParts<float> part{lanes.a + middle * lanes.to_a,
                                           lanes.b + middle * lanes.to_b,
                                           lanes.depth + middle * lanes.to_depth,
                                           half * lanes.to_a,
                                           half * lanes.to_b,
                                           half * lanes.to_depth};
            const BeamCluster<float>& cluster = scatter.clusters()[coverage.pyramid().index(node)];
            BeamCorner<float> corners[BeamCluster<float>::kMost];
            cluster.corners({0, 0}, corners);
            ClusterSlices<float> slices;
            slices.find(cluster, corners, part, met);
            slices.visit_pieces([&](int beam, const auto& enter, const auto& leave, const auto& mask) {
                // Seen along the light the water's triangles turn clockwise.
                const Lanes<float> area = slices.slices(beam).edge[0](0.5f * (enter + leave));
                for (int lane = 0; lane < 8; ++lane)
                    if (mask[lane])
                        pieces[lane].push_back({middle[lane] + enter[lane] * half[lane],
                                                middle[lane] + leave[lane] * half[lane],
                                                area[lane] < 0 ? 1 : -1});
            });
        });
        for (int lane = 0; lane < 8; ++lane) {
            for (int i = 0; i < 20; ++i) {
                const float s = 0.5f + 0.499f * uniform(random);
                const glm::vec3 p(group.origin[0][lane] + s * group.direction[0][lane],
                                  group.origin[1][lane] + s * group.direction[1][lane],
                                  group.origin[2][lane] + s * group.direction[2][lane]);
                int count = 0, sign = 0;
                bool near_end = false;
                for (const Piece& piece : pieces[lane]) {
                    if (s > piece.from && s < piece.to) {
                        ++count;
                        sign += piece.sign;
                    }
                    near_end |= std::abs(s - piece.from) < 2e-5f || std::abs(s - piece.to) < 2e-5f;
                }
                if (near_end) continue;
                const Receiver<float> point{p, {0.01f, 0, 0}, {0, 0, 0.01f}, {0, 1, 0}};
                PointSummary summary;
                query.summarize(std::span(&point, 1), std::span(&summary, 1));
                wrong += summary.count != count || summary.sign != sign || sign != 1;
                several += count > 1;
                ++checked;
            }
        }
    }
    printf("paths: %d points, %d with several, %d wrong\n", checked, several, wrong);
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(several, checked / 100);
    EXPECT_GT(checked, 5000);
}

TEST(Scatter, AllOfTheFluxIsFoundOnEveryPlane) {
    scene::FrameScene scene = test::scene_of_water({2, 2}, 60, 60, sea(3));
    scene.state.lights = {test::sun_from_zenith(0)};
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    // The way back to the near end would dim as well: as good as nothing is absorbed.
    scene.state.water->absorption = -scene.state.water->scattering + glm::dvec3(1e-12);
    const SheetSet<float> set(scene, Event::transmission, 4);
    const light::BeamSheet<float>& sheet = set.sheets().front()->sheet();
    constexpr double kStep = 0.004;
    for (const double depth : {0.3, 1.5, 3.0}) {
        std::vector<Ends> rows;
        for (double z = -1.6 + kStep / 2; z < 1.6; z += kStep)
            rows.push_back({glm::dvec3(-1.6, -depth, z), glm::dvec3(1.6, -depth, z)});
        glm::dvec3 found(0);
        for (const glm::dvec3& value : scattered(scene, set, rows).values) found += kStep * value;
        double fluence = 0;
        for (std::size_t i = 0; i < sheet.flux.size(); ++i) {
            double stretch = 0;
            for (int k = 0; k < 3; ++k) {
                const auto& ray = sheet.rays[scene.water->mesh.triangles[i][k]];
                stretch += std::sqrt(1 + ray.slope_a * ray.slope_a + ray.slope_b * ray.slope_b) / 3.0;
            }
            fluence += sheet.flux[i] * stretch;
        }
        for (int c = 0; c < 3; ++c) {
            const double expected =
                fluence * sheet.color[c] * scene.state.water->scattering[c] / (4 * glm::pi<double>());
            printf("plane at %.1f m: %.5f of the flux\n", depth, found[c] / expected);
            // Lines at the borders and folds are worth a line's width of light each: a tenth of 4 mm of 2 m.
            EXPECT_NEAR(found[c] / expected, 1, 1e-3);
        }
    }
}

scene::Object box(glm::dvec3 position, glm::dvec3 size) {
    scene::Object object;
    object.shape = scene::Shape::box;
    object.size = size;
    object.transform.position = position;
    return object;
}

TEST(Scatter, BoxesCastSharpVolumetricShadows) {
    // A box over flat water, a thin column through it, a slab in it; the sun 30 degrees from the zenith along
    // +x.
    scene::FrameScene scene = test::scene_of_flat_water({12, 12}, 81, 80);
    scene.state.lights = {test::sun_from_zenith(30)};
    scene.state.lights[0].angular_diameter = 0;
    scene.state.water->scattering = {0.1, 0.1, 0.1};
    scene.state.objects = {test::level_plane("floor", -4, 30), box({-2, 1, 0}, {1, 0.2, 1}),
                           box({2, -1, 0}, {0.02, 6, 0.02}), box({0, -1, 2}, {1, 0.1, 1})};
    const SheetSet<float> set(scene, Event::transmission, 6);
    const double tan_t = std::tan(std::asin(0.5 / 1.333));
    const double over = -2 + std::tan(glm::radians(30.0));  // of the box's middle, on the water
    const double column = 2 + 2 * tan_t - tan_t * 0;
    // Down the middle of each umbra; short, so as not to leave it.
    const auto in_ray = [&](double x, double z, double depth) {
        return glm::dvec3(x + depth * tan_t, -depth, z);
    };
    std::vector<Ends> ends = {
        {in_ray(over, 0, 0.5), in_ray(over, 0, 3.5)},  // under the box
        {in_ray(over + 0.44, 0, 0.5), in_ray(over + 0.44, 0, 3.5)},
        {in_ray(over + 0.56, 0, 0.5), in_ray(over + 0.56, 0, 3.5)},  // beside its shadow
        {in_ray(-1 * tan_t, 2, 1.2), in_ray(-1 * tan_t, 2, 3.5)},    // under the slab
        {in_ray(-1 * tan_t, 2, 0.1), in_ray(-1 * tan_t, 2, 0.9)},    // above it
        {glm::dvec3(column - 0.5, -2, 0),
         glm::dvec3(column + 0.02 - 1e-4, -2, 0)},                           // along the column's shadow
        {glm::dvec3(column - 0.5, -2, 0.02), glm::dvec3(column, -2, 0.02)},  // 1 cm beside it
        {glm::dvec3(0, -4.5, -4), glm::dvec3(1, -4.5, -4)},                  // under the floor
        {glm::dvec3(-1, -3.9, -4), glm::dvec3(0, -3.9, -4)},                 // above it
    };
    const Scattered result = scattered(scene, set, ends);
    // Without objects.
    scene::FrameScene open = scene;
    open.state.objects.clear();
    const SheetSet<float> free(open, Event::transmission, 6);
    const Scattered lit = scattered(open, free, ends);
    double share[9];
    for (std::size_t i = 0; i < ends.size(); ++i) share[i] = result.values[i].x / lit.values[i].x;
    EXPECT_EQ(share[0], 0);
    EXPECT_EQ(share[1], 0);
    EXPECT_NEAR(share[2], 1, 1e-5);
    EXPECT_EQ(share[3], 0);
    EXPECT_NEAR(share[4], 1, 1e-5);
    EXPECT_LT(share[5], 0.1);
    EXPECT_NEAR(share[6], 1, 1e-5);
    EXPECT_EQ(share[7], 0);
    EXPECT_NEAR(share[8], 1, 1e-5);
    EXPECT_GT(result.counts.shadow_tests, 0u);
    // Boxes as meshes are asked by rays, a quarter of an interval at a time.
    scene::FrameScene meshes = scene;
    meshes.object_meshes.resize(meshes.state.objects.size());
    for (std::size_t i = 1; i < meshes.state.objects.size(); ++i) {
        meshes.state.objects[i].shape = scene::Shape::mesh;
        meshes.object_meshes[i] =
            std::make_shared<scene::TriangleMesh>(rays::box_mesh(meshes.state.objects[i].size));
    }
    const SheetSet<float> traced_set(meshes, Event::transmission, 6);
    const Scattered traced = scattered(meshes, traced_set, ends);
    EXPECT_GT(traced.counts.shadow_rays, 0u);
    // The column's shadow ends within a quarter of an interval, 2 cm of a way of 50 cm.
    for (std::size_t i = 0; i < ends.size(); ++i)
        EXPECT_NEAR(traced.values[i].x / lit.values[i].x, share[i], i == 5 ? 0.04 : 1e-5) << i;
    // With the sun's disc the umbrae narrow by its radius and stay dark.
    open.state.lights[0].angular_diameter = scene.state.lights[0].angular_diameter = 0.53 * scene::kDegree;
    open.state.caustics.sliced_beams.volume_sun_samples = 4;
    scene.state.caustics.sliced_beams.volume_sun_samples = 4;
    const SheetSet<float> wide(scene, Event::transmission, 6), wide_free(open, Event::transmission, 6);
    const Scattered soft = scattered(scene, wide, ends), soft_lit = scattered(open, wide_free, ends);
    EXPECT_EQ(soft.values[0].x, 0);
    EXPECT_EQ(soft.values[1].x, 0);
    // 2 mm beside the edge of the sharp shadow, in a penumbra 1 cm wide and more.
    EXPECT_GT(soft.values[2].x / soft_lit.values[2].x, 0.5);
    EXPECT_LT(soft.values[2].x / soft_lit.values[2].x, 0.9);
    EXPECT_EQ(soft.values[3].x, 0);
}

TEST(Scatter, ThinThingsCastTheirShadows) {
    // Rods of 5 mm and less across a level segment, far thinner than the beams, which are 15 cm wide.
    scene::FrameScene scene = test::scene_of_flat_water({12, 12}, 81, 80);
    scene.state.lights = {test::sun_from_zenith(30)};
    scene.state.lights[0].angular_diameter = 0;
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    scene.state.water->absorption = {0.2, 0.1, 0.05};
    const double tan_i = std::tan(glm::radians(30.0)), tan_t = std::tan(std::asin(0.5 / 1.333)), depth = 3;
    const glm::dvec3 from(-2, -depth, 0.03), to(3, -depth, 0.03);
    scene::Object strip = box({0.2, -2, 0}, {0.005, 0, 4});
    strip.shape = scene::Shape::plane;
    scene::Object ball;
    ball.shape = scene::Shape::sphere;
    ball.radius = 0.004;
    ball.transform.position = {0.3, -1, 0.03};
    const std::vector<std::pair<const char*, scene::Object>> things = {
        {"rod", box({0.4, -1, 0}, {0.005, 0.005, 4})},
        {"plate", box({0.4, -1, 0}, {0.03, 0.001, 4})},
        {"upright sheet", box({0.41, -2.5, 0}, {1e-4, 0.2, 4})},
        {"rod in the air", box({-1, 1, 0}, {0.005, 0.005, 4})},
        {"strip", strip},
        {"ball", ball}};
    const double length = to.x - from.x;
    for (const auto& [name, object] : things) {
        scene.state.objects = {object};
        const SheetSet<float> set(scene, Event::transmission, 6);
        const Scattered found = scattered(scene, set, {{from, to}});
        scene.state.objects.clear();
        const SheetSet<float> free(scene, Event::transmission, 6);
        const Scattered lit = scattered(scene, free, {{from, to}});
        // The silhouette, carried along the light to the segment's depth.
        glm::dvec3 half = 0.5 * object.size;
        if (object.shape == scene::Shape::plane) half.y = 0;
        const glm::dvec3 at = object.transform.position;
        const double lean = at.y > 0 ? tan_i : tan_t;
        const double middle = at.x + (at.y > 0 ? at.y * tan_i + depth * tan_t : (depth + at.y) * tan_t);
        double reach = half.x + half.y * lean;
        if (object.shape == scene::Shape::sphere) reach = object.radius * std::sqrt(1 + tan_t * tan_t);
        for (int c = 0; c < 3; ++c) {
            const double a = scene.state.water->scattering[c] + scene.state.water->absorption[c];
            const double first = middle - reach - from.x;
            const double dark = std::exp(-a * first) * std::expm1(-a * 2 * reach) / std::expm1(-a * length);
            const double missing = 1 - found.values[0][c] / lit.values[0][c];
            // Floats of 5 m leave 3e-7 m of shadows of 4 mm and more, and sums of S 6e-8 of it where 9e-4
            // are missing.
            EXPECT_NEAR(missing / dark, 1, 1e-3) << name << " " << c;
        }
    }
}

TEST(Scatter, HardCasesStayFinite) {
    // A cone of light through one point: h makes all rays of the lens meet there, up to the mesh.
    scene::FrameScene scene = test::scene_of_water({1, 1}, 64, 64, [](double x, double z) {
        const double curvature = 0.8;
        return glm::dvec3(-0.5 * curvature * (x * x + z * z), -curvature * x, -curvature * z);
    });
    scene.state.lights = {test::sun_from_zenith(0)};
    scene.state.water->scattering = {0.1, 0.1, 0.1};
    const double focus = 1.333 / 0.333 / 0.8;
    const auto check = [&](glm::dvec3 scattering, glm::dvec3 absorption) {
        scene.state.water->scattering = scattering;
        scene.state.water->absorption = absorption;
        const SheetSet<float> set(scene, Event::transmission, 8);
        std::vector<Ends> ends;
        for (const double y : {-focus, -focus + 1e-6, -focus - 1e-3, -0.999 * focus, -1e-7, -1e-3})
            for (const double z : {0.0, 1e-9, 1e-5, 1e-3}) ends.push_back({{-1, y, z}, {1, y, z}});
        for (const double x : {0.0, 1e-7, 0.015625, 0.1}) {
            ends.push_back({{x, -0.02, 0}, {x, -7, 0}});  // along the axis
            ends.push_back({{x, -0.1, 0}, {-x / 3, -7, 0}});
            ends.push_back({{x, -0.1, 0}, {0, -focus, 0}});       // along a beam, to the focus
            ends.push_back({{x, -0.1, x}, {x, -0.1 - 1e-7, x}});  // of hardly any length
        }
        Scattered result = scattered(scene, set, ends);
        for (const glm::dvec3& value : result.values) {
            for (int c = 0; c < 3; ++c) {
                EXPECT_TRUE(std::isfinite(value[c]));
                EXPECT_GE(value[c], 0);
            }
        }
        return result;
    };
    const Scattered clear = check({0.1, 0.1, 0.1}, {0, 0, 0});
    printf("lens: %zu intervals, %zu peak, %zu foci, %zu dropped\n", clear.counts.intervals,
           clear.counts.peaks, clear.counts.foci, clear.counts.dropped);
    EXPECT_GT(clear.counts.peaks, 100u);
    EXPECT_EQ(clear.counts.dropped, 0u);
    for (const glm::dvec3& value : check({0, 0, 0}, {0.3, 0.2, 0.1}).values) EXPECT_EQ(value, glm::dvec3(0));
    const Scattered dense = check({1e4, 1e4, 1e4}, {1e3, 2e3, 1e2});
    // The water's own light scatters where it enters: hardly any is left to be seen from 2 cm below.
    EXPECT_GT(dense.counts.intervals, 0u);
}

TEST(Scatter, DirectionsOfTheSunsDiscConverge) {
    scene::FrameScene scene = rough_pool();
    scene.state.lights[0].angular_diameter = 0.53 * scene::kDegree;
    scene.state.clip.samples = 4;
    const SheetSet<float> set(scene, Event::transmission, 8);
    std::vector<Ends> ends;  // short: what is averaged along a line hides the disc
    for (int i = 0; i < 512; ++i) {
        const glm::dvec3 from(0.004 * i - 1, -3.2, 0.1);
        ends.push_back({from, from + glm::dvec3(0, 0, 0.05)});
    }
    const auto with = [&](int directions, int sample) {
        scene.state.caustics.sliced_beams.volume_sun_samples = directions;
        return scattered(scene, set, ends, sample).values;
    };
    const std::vector<glm::dvec3> fine = with(256, 0);
    const auto difference = [&](const std::vector<glm::dvec3>& values) {
        double sum = 0, light = 0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            sum += std::abs(values[i].y - fine[i].y);
            light += fine[i].y;
        }
        return sum / light;
    };
    double errors[4];
    int n = 0;
    for (const int directions : {1, 4, 16, 64}) errors[n++] = difference(with(directions, 0));
    std::vector<glm::dvec3> pixel(ends.size(), glm::dvec3(0));
    for (int sample = 0; sample < 4; ++sample) {
        const std::vector<glm::dvec3> part = with(4, sample);
        for (std::size_t i = 0; i < pixel.size(); ++i) pixel[i] += part[i] / 4.0;
    }
    const double together = difference(pixel);
    printf(
        "disc: L1 error with 1, 4, 16, 64 directions: %.1f, %.1f, %.1f, %.1f %%; four samples of 4: %.1f "
        "%%\n",
        100 * errors[0], 100 * errors[1], 100 * errors[2], 100 * errors[3], 100 * together);
    EXPECT_LT(errors[1], errors[0]);
    EXPECT_LT(errors[2], 0.7 * errors[1]);
    EXPECT_LT(errors[3], 0.7 * errors[2]);
    // The samples' directions are as good as so many of one set, or nearly.
    EXPECT_LT(together, 1.5 * errors[2]);
}

}  // namespace
}  // namespace dapple
