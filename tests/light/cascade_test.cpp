#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/error.h"
#include "base/hash.h"
#include "gpu/validated_device.h"
#include "light/cascade_layout.h"
#include "light/cascade_plan.h"
#include "light/caustic_map.h"
#include "light/landing.h"
#include "light/map_memory.h"
#include "light/paper_cascades.h"
#include "light/water_grids.h"

namespace dapple {
namespace {

using light::BeamMesh;
using light::Event;
using light::MapPlan;
using light::plan_cascades;

scene::CausticMapParameters parameters(int cascades, double scale, int resolution, double inner = 0) {
    scene::CausticMapParameters map;
    map.cascades = cascades;
    map.cascade_scale = scale;
    map.map_resolution = resolution;
    map.inner_size = inner;
    return map;
}

scene::FrameScene sea_scene(glm::dvec2 size, glm::dvec2 camera, bool flat = false) {
    scene::FrameScene scene = test::water_scene(size, {1.3, -2.1});
    scene.state.lights = {test::sun(30)};
    scene.state.camera.position = {camera.x, -1, camera.y};
    scene.origin = {std::round(camera.x), 0, std::round(camera.y)};
    test::add_water(scene, flat ? std::vector<test::Sinusoid>() : test::gentle_sea(), 64, 64);
    return scene;
}

bool in_parts(const MapPlan& plan, int column, int row) {
    return std::any_of(plan.parts.begin(), plan.parts.end(), [&](const light::TexelBox& part) {
        return column >= part.first_column && column < part.first_column + part.columns &&
               row >= part.first_row && row < part.first_row + part.rows;
    });
}

double share_or_none(const MapPlan& plan, int column, int row) {
    const bool held = column >= 0 && row >= 0 && column < plan.columns && row < plan.rows;
    return held ? plan.share(column, row) : 0;
}

/// Sum over the cascades of the tents of their photons' shares at a point of the rest plane.
double sum_of_tents(const std::vector<MapPlan>& plans, glm::dvec2 point) {
    double sum = 0;
    for (const MapPlan& plan : plans) {
        const glm::dvec2 at = plan.texel_of(point) - 0.5, low = glm::floor(at), part = at - low;
        const int column = static_cast<int>(low.x), row = static_cast<int>(low.y);
        for (int i = 0; i < 4; ++i) {
            const int right = i % 2, down = i / 2;
            const double tent = (right != 0 ? part.x : 1 - part.x) * (down != 0 ? part.y : 1 - part.y);
            sum += tent * share_or_none(plan, column + right, row + down);
        }
    }
    return sum;
}

/// The same where photons are even over their texels.
double sum_of_boxes(const std::vector<MapPlan>& plans, glm::dvec2 point) {
    double sum = 0;
    for (const MapPlan& plan : plans) {
        const glm::dvec2 at = glm::floor(plan.texel_of(point));
        sum += share_or_none(plan, static_cast<int>(at.x), static_cast<int>(at.y));
    }
    return sum;
}

std::size_t carrying(const MapPlan& plan) {
    std::size_t count = 0;
    for (int row = 0; row < plan.rows; ++row)
        for (int column = 0; column < plan.columns; ++column) count += plan.share(column, row) > 0 ? 1 : 0;
    return count;
}

TEST(Cascades, SharesSumToOneAtEveryPointOfTheWater) {
    const glm::dvec2 size(23, 14);
    for (const double scale : {1.5, 2.0, 2.5, 3.0, 4.0})
        for (const int cascades : {2, 3, 5})
            for (const glm::dvec2 camera : {glm::dvec2(2.234, -3.17), glm::dvec2(-10.1, 4.8)})
                for (const int resolution : {3, 40, 131}) {
                    SCOPED_TRACE(testing::Message() << "s " << scale << ", N " << cascades << ", camera "
                                                    << camera.x << ", R " << resolution);
                    const scene::FrameScene scene = sea_scene(size, camera);
                    const scene::CausticMapParameters map = parameters(cascades, scale, resolution);
                    const std::vector<MapPlan> plans = plan_cascades(scene, 0, map);
                    const std::vector<MapPlan> even = plan_cascades(scene, 0, map, light::PhotonCells::boxes);
                    ASSERT_EQ(plans.size(), static_cast<std::size_t>(cascades));
                    ASSERT_EQ(even.size(), static_cast<std::size_t>(cascades));
                    double worst = 0;
                    for (std::uint32_t i = 0; i < 2000; ++i) {
                        const glm::dvec2 random(hash_uniform(7, 0, i, 0), hash_uniform(7, 0, i, 1));
                        // Photons lie beyond the edges too, where waves may be thrown to.
                        const glm::dvec2 point = scene.state.water->extent.center + (random - 0.5) * size;
                        worst = std::max({worst, std::abs(sum_of_tents(plans, point) - 1),
                                          std::abs(sum_of_boxes(even, point) - 1)});
                    }
                    EXPECT_LT(worst, 1e-12);  // round-off of double
                }
}

TEST(Cascades, WhatCarriesLightIsTracedAndSoAreItsNeighbors) {
    for (const bool paper : {false, true}) {
        scene::CausticMapParameters map = parameters(4, 2, 96);
        map.paper_faithful = paper;
        const std::vector<MapPlan> plans = plan_cascades(sea_scene({20, 20}, {3.1, -4.2}), 0, map);
        ASSERT_EQ(plans.size(), 4u);
        for (const MapPlan& plan : plans) {
            std::size_t traced = 0;
            for (const light::TexelBox& part : plan.parts)
                traced += static_cast<std::size_t>(part.columns) * static_cast<std::size_t>(part.rows);
            for (int row = 0; row < plan.rows; ++row)
                for (int column = 0; column < plan.columns; ++column) {
                    const double share = plan.share(column, row);
                    ASSERT_GE(share, -1e-15);
                    if (share <= 0) continue;
                    for (int i = 0; i < 9; ++i) {
                        const int x = column + i % 3 - 1, z = row + i / 3 - 1;
                        ASSERT_TRUE(x < 0 || z < 0 || x >= plan.columns || z >= plan.rows ||
                                    in_parts(plan, x, z));
                    }
                }
            // Beside what carries light only one texel all around is looked at, within and without.
            EXPECT_LE(traced, carrying(plan) + 8 * 96 + 8) << plan.cascade;
        }
    }
}

TEST(Cascades, RingsHaveTheNumberOfPhotonsOfTheFormula) {
    // Of a box 128 photons wide the middle 64 are the finer cascade's. Its ramp of 15 steps (a quarter, less
    // one for the snapping) lies inside it: 35 x 35 places of the coarser one, from step 15 to step 49, have
    // no share.
    const scene::FrameScene scene = sea_scene({16, 16}, {1.3, -2.1}, true);
    const std::vector<MapPlan> plans = plan_cascades(scene, 0, parameters(4, 2, 128));
    ASSERT_EQ(plans.size(), 4u);
    EXPECT_EQ(carrying(plans[0]), 127u * 127u);  // the box's ends carry nothing
    EXPECT_EQ(carrying(plans[1]), 127u * 127u - 35u * 35u);
    EXPECT_EQ(carrying(plans[2]), 127u * 127u - 35u * 35u);
    EXPECT_EQ(carrying(plans[3]), 128u * 128u - 35u * 35u);
    for (const double scale : {2.0, 4.0}) {
        scene::CausticMapParameters map = parameters(3, scale, 128);
        map.paper_faithful = true;
        const std::vector<MapPlan> paper = plan_cascades(scene, 0, map);
        ASSERT_EQ(paper.size(), 3u);
        EXPECT_EQ(carrying(paper[0]), 128u * 128u);
        for (const std::size_t c : {1u, 2u})
            EXPECT_EQ(static_cast<double>(carrying(paper[c])), 128 * 128 * (1 - 1 / (scale * scale)));
    }
}

TEST(Cascades, PhotonsStayInPlaceWhenTheCameraMoves) {
    std::vector<MapPlan> before;
    std::size_t moved = 0;
    for (int step = 0; step < 20; ++step) {
        // Steps of a sixth of the innermost texel, past several texels of the coarser cascade.
        const scene::FrameScene scene = sea_scene({16, 16}, {1.31 + step * 0.02 / 6, -2.12}, true);
        std::vector<MapPlan> plans = plan_cascades(scene, 0, parameters(4, 2, 100));
        for (std::size_t c = 0; step > 0 && c < plans.size(); ++c) {
            EXPECT_EQ(plans[c].anchor, before[c].anchor);
            EXPECT_EQ(plans[c].texel, before[c].texel);
            EXPECT_EQ(plans[c].columns, before[c].columns);
            const std::int64_t columns = plans[c].first.x - before[c].first.x;
            moved += columns != 0 ? 1 : 0;
            // By whole texels of the next coarser cascade, so that ramps keep their places in it.
            EXPECT_TRUE(columns == 0 || (c < 3 && columns == 2)) << c << ": " << columns;
        }
        before = std::move(plans);
    }
    EXPECT_GE(moved, 1u);  // 0.063 m in all: one or two texels of the coarser cascade, of 0.04 m
}

TEST(Cascades, RaysStayTheSameWhenTheCameraMoves) {
    light::CausticMapper mapper(test::validated_device());
    using Key = std::pair<std::int64_t, std::int64_t>;
    std::map<Key, glm::vec3> origins;
    glm::i64vec2 first(0);
    std::size_t same_box = 0, moved_box = 0;
    float farthest = 0;
    for (const double x : {1.31, 1.3123, 1.4371}) {
        const scene::FrameScene scene = sea_scene({16, 16}, {x, -2.12});
        const scene::CausticMapParameters map = parameters(3, 2, 64);
        const MapPlan plan = plan_cascades(scene, 0, map)[0];
        const rays::RayScene rays(scene);
        FrameStats stats;
        const BeamMesh mesh = mapper.trace(scene, rays, 0, {Event::transmission}, map, stats)[0];
        ASSERT_EQ(mesh.cascade, 0);
        ASSERT_EQ(mesh.columns, plan.columns);
        if (origins.empty()) first = plan.first;
        for (std::size_t i = 0; i < mesh.vertices(); ++i) {
            const std::size_t columns = static_cast<std::size_t>(mesh.columns);
            const Key key(plan.first.x + static_cast<std::int64_t>(i % columns),
                          plan.first.y + static_cast<std::int64_t>(i / columns));
            const auto [found, is_new] = origins.emplace(key, mesh.origin[i]);
            if (is_new) continue;
            ++(plan.first == first ? same_box : moved_box);
            if (plan.first == first) {
                ASSERT_EQ(found->second, mesh.origin[i]);
            }
            farthest = std::max(farthest, glm::length(found->second - mesh.origin[i]));
        }
    }
    EXPECT_GT(same_box, 4000u);  // 65 x 65
    EXPECT_GT(moved_box, 4000u);
    // Where the box has moved, by whole texels, the device projects the water about another middle: heights
    // and normals differ by round-off, against rays of 1 m.
    EXPECT_LT(farthest, 1e-6f);
}

std::vector<BeamMesh> trace(const scene::FrameScene& scene, const scene::CausticMapParameters& map,
                            FrameStats& stats) {
    light::CausticMapper mapper(test::validated_device());
    const rays::RayScene rays(scene);
    return mapper.trace(scene, rays, 0, {Event::transmission, Event::reflection}, map, stats);
}

double flux_of(const std::vector<BeamMesh>& meshes, Event event) {
    double sum = 0;
    for (const BeamMesh& mesh : meshes)
        if (mesh.event == event) sum += std::accumulate(mesh.flux.begin(), mesh.flux.end(), mesh.lost_flux);
    return sum;
}

double lost_flux_of(const std::vector<BeamMesh>& meshes, Event event) {
    double sum = 0;
    for (const BeamMesh& mesh : meshes) sum += mesh.event == event ? mesh.lost_flux : 0;
    return sum;
}

TEST(Cascades, TogetherCarryTheFluxOfOneMap) {
    for (const double lamp : {0.0, 2.5, -1.2}) {  // m above the water; 0: a sun
        scene::FrameScene scene = sea_scene({18, 12}, {4.1, -3.3}, true);
        if (lamp != 0) {
            scene.state.lights[0].type = scene::LightType::point;
            scene.state.lights[0].position = {3, lamp, -2};
        }
        FrameStats stats;
        const std::vector<BeamMesh> one = trace(scene, parameters(1, 2, 512), stats);
        for (const double scale : {2.0, 2.5, 3.0})
            for (const int cascades : {2, 4}) {
                SCOPED_TRACE(testing::Message() << lamp << ", s " << scale << ", N " << cascades);
                const std::vector<BeamMesh> all = trace(scene, parameters(cascades, scale, 128), stats);
                ASSERT_EQ(all.size(), 2u * static_cast<std::size_t>(cascades));
                for (const Event event : {Event::transmission, Event::reflection}) {
                    // A sun's light is the same everywhere, a lamp's is summed at the middles of texels of
                    // up to 14 cm, 1.2 m away and more. From below some of it leaves the water too level for
                    // a mesh.
                    const double expected = flux_of(one, event);
                    EXPECT_NEAR(flux_of(all, event) / expected, 1, lamp != 0 ? 2e-3 : 1e-6);
                    EXPECT_EQ(lost_flux_of(all, event) > 0, lamp < 0);
                    EXPECT_NEAR(lost_flux_of(all, event), lost_flux_of(one, event), 4e-3 * expected);
                }
            }
    }
}

TEST(Cascades, CountOnlyPhotonsThatAreTraced) {
    FrameStats stats;
    trace(sea_scene({16, 16}, {1.3, -2.1}, true), parameters(2, 2, 128), stats);
    EXPECT_EQ(stats.counted("photons"), 2 * (127 * 127 + 128 * 128 - 35 * 35));
}

/// Bytes of what lies in the vectors of a mesh.
double bytes_of(const BeamMesh& mesh) {
    const auto bytes = [](const auto& all) { return static_cast<double>(all.size() * sizeof(all[0])); };
    return bytes(mesh.origin) + bytes(mesh.slope) + bytes(mesh.start) + bytes(mesh.flux) +
           bytes(mesh.weight) + bytes(mesh.tint) + bytes(mesh.valid);
}

TEST(Cascades, MemoryIsForeseenAndOnlyOneMapsAtOnce) {
    // Flat, so that maps have no borders, which are left out of what is foreseen.
    scene::FrameScene scene = sea_scene({16, 16}, {1.3, -2.1}, true);
    const rays::RayScene rays(scene);
    light::CausticMapper mapper(test::validated_device());
    for (const bool paper : {false, true})
        for (const int cascades : {1, 3}) {
            SCOPED_TRACE((paper ? "paper, " : "") + std::to_string(cascades));
            scene::CausticMapParameters& map = scene.state.caustics.map;
            map = parameters(cascades, 2, 128);
            map.paper_faithful = paper;
            const light::MapMemory foreseen = light::foresee_maps(scene.state);
            EXPECT_EQ(foreseen.events, 1);  // the camera is under water: what is reflected stays above
            const light::MapTexels texels = light::count_texels(scene.state, map);
            std::size_t taken = 0;
            double traced = 0;
            for (const MapPlan& plan : plan_cascades(scene, 0, map))
                for (const light::TexelBox& part : plan.parts)
                    traced += static_cast<double>(part.columns) * part.rows;
            FrameStats stats;
            mapper.trace_each(scene, rays, 0, {Event::transmission}, map, light::PhotonCells::tents, stats,
                              [&](std::span<BeamMesh> meshes) {
                                  ASSERT_EQ(meshes.size(), 1u);
                                  EXPECT_EQ(meshes[0].cascade, static_cast<int>(taken++));
                                  EXPECT_LE(static_cast<double>(meshes[0].vertices()), foreseen.largest);
                                  EXPECT_LE(bytes_of(meshes[0]), foreseen.kept);
                              });
            EXPECT_EQ(taken, static_cast<std::size_t>(cascades));
            EXPECT_LE(foreseen.kept, foreseen.tracing);
            EXPECT_LE(stats.counted("photons"), foreseen.photons);
            EXPECT_LE(traced, texels.photons);
            // Exact but for the paper's frames, which are rounded.
            EXPECT_GE(traced, (paper ? 0.97 : 1.0) * texels.photons);
        }
}

TEST(Cascades, TakeWhatTheyAreGiven) {
    const scene::FrameScene scene = sea_scene({4, 4}, {1, -2});
    // A box larger than the water is one map, of photons as far apart as asked for.
    std::vector<MapPlan> plans = plan_cascades(scene, 0, parameters(8, 2, 100, 10));
    ASSERT_EQ(plans.size(), 1u);
    EXPECT_NEAR(plans[0].texel[0].x, 0.1, 1e-12);
    EXPECT_FALSE(plans[0].weighted());
    // Eight cascades on a small pool need no more than those that reach its edges.
    plans = plan_cascades(scene, 0, parameters(8, 2, 64, 0.5));
    EXPECT_EQ(plans.size(), 4u);  // 0.5, 1, 2, 4 m
    // A list of resolutions; texels keep whole ratios.
    scene::CausticMapParameters map = parameters(3, 2, 64);
    map.cascade_maps = {{128}, {64}, {30}};
    plans = plan_cascades(scene, 0, map);
    ASSERT_EQ(plans.size(), 3u);
    EXPECT_NEAR(plans[2].texel[0].x / plans[1].texel[0].x, 4, 1e-12);
    EXPECT_NEAR(plans[1].texel[0].x / plans[0].texel[0].x, 4, 1e-12);
    EXPECT_NEAR(plans[2].texel[0].x, 4.0 / 30, 1e-12);
    // A range that ends before the water does: what lies beyond is lost.
    plans = plan_cascades(scene, 0, parameters(2, 2, 64, 1));
    ASSERT_EQ(plans.size(), 2u);
    EXPECT_TRUE(plans[1].capped);
    EXPECT_EQ(plans[1].columns, 64);
    // A camera far from all water: boxes stay about its nearest edge.
    EXPECT_EQ(plan_cascades(sea_scene({4, 4}, {1e6, 1e6}), 0, parameters(4, 2, 64)).size(), 4u);
    // Absurd sizes end in a sentence, before memory is asked for.
    EXPECT_THROW(plan_cascades(scene, 0, parameters(2, 2, 2147483647)), Error);
    for (const int cascades : {1, 2}) {  // what the timeline asks for, whatever the device
        try {
            plan_cascades(scene, 0, parameters(cascades, 2, 70000));
            FAIL() << cascades;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::timeline_invalid);
        }
    }
    map = parameters(8, 16, 2147483647, 1e-9);
    map.paper_faithful = true;
    EXPECT_THROW(plan_cascades(scene, 0, map), Error);
    map = parameters(3, 2, 1);
    map.map_precision = 1e-12;
    EXPECT_THROW(plan_cascades(scene, 0, map), Error);
    for (const double scale : {1.1, 16.0}) {  // one photon a side
        map = parameters(8, scale, 1);
        plans = plan_cascades(scene, 0, map);
        EXPECT_NEAR(sum_of_tents(plans, {1.1, -2.3}), 1, 1e-12) << scale;
    }
}

TEST(Cascades, PrecisionGivesTheInnermostTexel) {
    scene::CausticMapParameters map = parameters(3, 2, 7, 2);
    map.map_precision = 0.01;
    const scene::FrameScene scene = sea_scene({8, 8}, {1, -2}, true);
    std::vector<MapPlan> plans = plan_cascades(scene, 0, map);
    ASSERT_EQ(plans.size(), 3u);
    EXPECT_NEAR(plans[0].texel[0].x, 0.01, 1e-12);
    EXPECT_NEAR(plans[2].texel[0].x, 0.04, 1e-12);
    map.paper_faithful = true;  // equation 3: 200 photons, so 256
    EXPECT_EQ(plan_cascades(scene, 0, map)[0].columns, 256);
    EXPECT_EQ(light::paper_resolution(3000, 2), 2048);  // the paper's own, Unreal units
    EXPECT_EQ(light::paper_resolution(511, 2), 256);
    EXPECT_EQ(light::paper_resolution(512, 2), 512);
    EXPECT_EQ(light::paper_resolution(2047, 2), 1024);
}

TEST(Cascades, PhotonsLieNoFartherApartThanThePrecision) {
    for (const double scale : {1.5, 2.0, 2.5, 3.0})
        for (const int cascades : {2, 3, 4})
            for (const double inner : {0.0, 1.7}) {
                scene::CausticMapParameters map = parameters(cascades, scale, 7, inner);
                map.map_precision = 0.03;
                const MapPlan plan = plan_cascades(sea_scene({8.03, 5.37}, {1, -2}, true), 0, map)[0];
                for (const double texel : {plan.texel[0].x, plan.texel[1].y}) {
                    EXPECT_LE(texel, 0.03 * (1 + 1e-9)) << scale << ", N " << cascades << ", " << inner;
                    EXPECT_GT(texel, 0.025) << scale << ", N " << cascades << ", " << inner;
                }
            }
}

TEST(PaperCascades, OfAPrecisionAreForeseenAsTheyAreMade) {
    scene::CausticMapParameters map = parameters(3, 2, 7, 2);
    map.map_precision = 0.01;  // 200 photons, so 256
    map.paper_faithful = true;
    const scene::FrameScene scene = sea_scene({8, 8}, {1, -2}, true);
    EXPECT_EQ(light::count_texels(scene.state, map).largest, 256.0 * 256.0);
    EXPECT_EQ(plan_cascades(scene, 0, map)[2].columns, 256);
}

TEST(Landing, OfRaysWhoseLightOtherCascadesCarryIsKnown) {
    scene::FrameScene scene = sea_scene({4, 4}, {0, 0}, true);
    scene::Object floor;
    floor.size = {10, 1, 10};
    floor.transform.position = {0, -1, 0};
    scene.state.objects = {floor};
    const rays::RayScene rays(scene);
    BeamMesh mesh;
    mesh.rows = 1;
    mesh.columns = 3;
    mesh.axis = {0, -1, 0};
    mesh.origin.assign(3, glm::vec3(0.1f, 0, 0.2f));
    mesh.slope.assign(3, glm::vec3(0, -1, 0));
    mesh.start.assign(3, 0.0f);
    mesh.flux = {1, 0, 0};
    mesh.weight = {1, 0, 0};
    mesh.valid = {1, 1, BeamMesh::kShadowed};
    const light::Landings landings = light::land(mesh, rays);
    EXPECT_EQ(landings.count, 1u);
    EXPECT_NEAR(landings.depth[0], 1, 1e-6f);
    EXPECT_EQ(landings.depth[1], landings.depth[0]);  // a neighbour of what carries light
    EXPECT_TRUE(std::isinf(landings.depth[2]));
}

TEST(PaperCascades, AreSquaresAcrossTheLightAboutTheCamera) {
    scene::FrameScene scene = sea_scene({16, 16}, {1.3, -2.1}, true);
    scene.state.lights = {test::sun(60, 25)};
    scene.state.camera.position.y = -1.5;
    scene::CausticMapParameters map = parameters(2, 2, 64, 3);
    map.paper_faithful = true;
    const std::vector<MapPlan> plans = plan_cascades(scene, 0, map);
    ASSERT_EQ(plans.size(), 2u);
    const glm::dvec3 d = scene.state.lights[0].direction;
    for (const MapPlan& plan : plans) {
        const double width = 3 * std::pow(2, plan.cascade) / 64;
        // Texels seen along the light: squares of the width of equation 2.
        const auto across = [&](glm::dvec2 step) {
            const glm::dvec3 v(step.x, 0, step.y);
            return v - glm::dot(v, d) * d;
        };
        const glm::dvec3 column = across(plan.texel[0]), row = across(plan.texel[1]);
        EXPECT_NEAR(glm::length(column), width, 1e-12);
        EXPECT_NEAR(glm::length(row), width, 1e-12);
        EXPECT_NEAR(glm::dot(column, row), 0, 1e-12);
        // Equation 1: the light's way through the camera meets the map in its middle.
        const glm::dvec3 o = scene.state.camera.position;
        const glm::dvec3 at = o - d * (o.y / d.y);
        const glm::dvec2 middle = plan.corner() + plan.texel * glm::dvec2(32, 32);
        EXPECT_NEAR(middle.x, at.x, 1e-12);
        EXPECT_NEAR(middle.y, at.z, 1e-12);
    }
    // Equation 7: a photon of cascade c carries s^(2 c) as much.
    FrameStats stats;
    const std::vector<BeamMesh> meshes = trace(scene, map, stats);
    const auto brightest = [](const BeamMesh& mesh) {
        return *std::max_element(mesh.flux.begin(), mesh.flux.end());
    };
    EXPECT_NEAR(static_cast<double>(brightest(meshes[2]) / brightest(meshes[0])), 4, 1e-5);
}

}  // namespace
}  // namespace dapple
