#include "light/wave_shadow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "light/beam_checks.h"

namespace dapple {
namespace {

using namespace test;

/// Curves on the sheets of water, extruded along z: x and h of a parameter in [0, 1], with the normals of the
/// curve. The light of a sun of azimuth 0 stays in planes of constant z.
struct Curve {
    std::vector<glm::dvec2> points;  // x, h
    std::vector<glm::dvec2> normals;
};

Curve sampled(int cells, const std::function<glm::dvec2(double)>& at) {
    Curve curve;
    for (int i = 0; i <= cells; ++i) {
        const double s = double(i) / cells, e = 1e-4 / cells;
        curve.points.push_back(at(s));
        const glm::dvec2 along = at(s + e) - at(s - e);
        curve.normals.push_back(glm::normalize(glm::dvec2(-along.y, along.x)));
    }
    return curve;
}

scene::FrameScene extruded(const Curve& curve, double width) {
    const int cells = static_cast<int>(curve.points.size()) - 1;
    const double length = curve.points.back().x - curve.points.front().x;
    scene::FrameScene scene = water_scene({length, width});
    add_water(scene, {}, cells, 16);
    auto water = std::make_shared<scene::WaterMesh>(*scene.water);
    for (std::size_t v = 0; v < water->mesh.positions.size(); ++v) {
        const std::size_t i = v % curve.points.size();
        water->mesh.positions[v].x = curve.points[i].x;
        water->mesh.positions[v].y = curve.points[i].y;
        water->mesh.normals[v] = {curve.normals[i].x, curve.normals[i].y, 0};
    }
    scene.water = water;
    return scene;
}

/// What a sun of azimuth 0 sends onto an extruded curve: light rays are the lines u = h cos(e) - x sin(e),
/// and a curve that hangs together is met from above by all between its end on the sun's side and its
/// highest.
double met_by_curve(const Curve& curve, double elevation, double width) {
    const auto u = [&](glm::dvec2 p) { return p.y * std::cos(elevation) - p.x * std::sin(elevation); };
    double most = -HUGE_VAL;
    for (const glm::dvec2 p : curve.points) most = std::max(most, u(p));
    return (most - u(curve.points.back())) * width;
}

/// Two ridges of 0.5 m with sides at 45 degrees, tops at x = 1.5 and -1, on level water from -4 to 3.
double two_ridges(double x) {
    return std::max({0.0, 0.5 - std::abs(x - 1.5), 0.5 - std::abs(x + 1)});
}

struct RidgeScene {
    double elevation = std::atan(0.2);
    double width = 1.5;
    Curve curve = sampled(350, [](double s) { return glm::dvec2(7 * s - 4, two_ridges(7 * s - 4)); });
    scene::FrameScene scene = extruded(curve, width);
    RidgeScene() { scene.state.lights = {sun(90 - glm::degrees(elevation), 0)}; }
    double middle(std::size_t t) const {
        const auto& mesh = scene.water->mesh;
        const glm::uvec3 i = mesh.triangles[t];
        return (mesh.positions[i.x].x + mesh.positions[i.y].x + mesh.positions[i.z].x) / 3;
    }
};

TEST(WaveShadow, ARidgeShadowsTheWaterBehindIt) {
    const RidgeScene ridges;
    const auto sheets = beams<double>(ridges.scene, Event::transmission);
    ASSERT_EQ(sheets.size(), 1u);
    // The sun stands over +x. The first ridge hides all down to x = -0.5 and the foot of the second up to
    // 0.5 - 0.2 (1.5 - x) = -0.5 - x, the second ridge all from its top to -1 - 0.5 / 0.2.
    const double foot = -0.7 / 1.2, behind = -3.5;
    const double cell = 7.0 / 350;
    for (std::size_t t = 0; t < sheets[0].flux.size(); ++t) {
        const double x = ridges.middle(t);
        const auto near = [&](double edge) { return std::abs(x - edge) < cell; };
        if (near(foot) || near(behind) || near(1.5) || near(-1)) continue;
        const bool lit = x < behind || (x > -1 && x < foot) || x > 1.5;
        ASSERT_EQ(sheets[0].flux[t] > 0, lit) << x;
    }
    const double carried = flux(sheets) + flux(beams<double>(ridges.scene, Event::reflection));
    // Two shadow edges, each within a cell that meets a fiftieth of the light at most (the ridge's side) and
    // that is sampled at 16 points, two of which may be misjudged.
    EXPECT_NEAR(carried / met_by_curve(ridges.curve, ridges.elevation, ridges.width), 1, 2.5e-3);
    const double all =
        flux_and_losses(sheets) + flux_and_losses(beams<double>(ridges.scene, Event::reflection));
    EXPECT_NEAR(all / met_by_sun(ridges.scene), 1, 1e-12);
}

TEST(WaveShadow, LightThatTheNextWaveCatchesIsCountedAndKept) {
    const RidgeScene ridges;
    const auto sheets = beams<double>(ridges.scene, Event::reflection);
    // Light mirrored by the level strip from x = 2 to 3 meets the first ridge; all other leaves: the lit
    // sides of the ridges send it up, and nothing stands before the strip at the far end.
    const double strip = std::sin(ridges.elevation) * ridges.width;
    const double expected = strip * reflectance(glm::radians(90.0) - ridges.elevation, kIndex);
    // The corner's normals are of neither side: one cell of fifty. Rays along the border, a sixteenth of the
    // flux, may slip past it.
    EXPECT_NEAR(sheets[0].losses.second_crossing / expected, 0.95, 0.05);
    double carried = 0;
    for (std::size_t t = 0; t < sheets[0].flux.size(); ++t)
        if (ridges.middle(t) > 2.04) carried += sheets[0].flux[t];
    EXPECT_NEAR(carried / expected, 0.96, 0.01);
}

TEST(WaveShadow, LightEntersAnOverturnedWaveAtItsTopOnly) {
    for (const double zenith : {0.0, 40.0}) {
        SCOPED_TRACE(zenith);
        const Curve curve = sampled(600, [](double s) {
            const double angle = glm::two_pi<double>() * 3 * s;
            return glm::dvec2(6 * s + 0.6 * std::sin(angle), 0.25 * std::cos(angle + 1));
        });
        scene::FrameScene scene = extruded(curve, 1);
        scene.state.lights = {sun(zenith, 0)};
        for (const bool grid : {true, false}) {
            auto water = std::make_shared<scene::WaterMesh>(*scene.water);
            if (!grid) water->rows = water->columns = 0;
            scene.water = water;
            const auto through = beams<double>(scene, Event::transmission);
            const auto mirrored = beams<double>(scene, Event::reflection);
            expect_sound(through);
            expect_sound(mirrored);
            EXPECT_GT(through[0].losses.wave_shadow, 0.1);
            // Three or six shadow edges, each good to an eighth of one of 600 cells.
            EXPECT_NEAR((flux(through) + flux(mirrored)) / met_by_curve(curve, glm::radians(90 - zenith), 1),
                        1, 2.5e-3);
        }
    }
}

TEST(WaveShadow, OnePieceOfAMeshShadowsAnother) {
    // A square of 1 m that hangs half a metre over one of 4 m; all triangles of both face the light.
    scene::FrameScene scene = water_scene({4, 4}), above = water_scene({1, 1});
    add_water(scene, {}, 80, 80);
    add_water(above, {}, 4, 4);
    auto water = std::make_shared<scene::WaterMesh>(*scene.water);
    const auto first = static_cast<std::uint32_t>(water->mesh.positions.size());
    const std::size_t below = water->mesh.triangles.size();
    for (const glm::dvec3 p : above.water->mesh.positions) {
        water->mesh.positions.push_back(p + glm::dvec3(0, 0.5, 0));
        water->mesh.normals.emplace_back(0, 1, 0);
    }
    for (const glm::uvec3 t : above.water->mesh.triangles) water->mesh.triangles.push_back(t + first);
    water->rows = water->columns = 0;
    scene.water = water;
    for (const bool is_sun : {true, false}) {
        SCOPED_TRACE(is_sun);
        const double zenith = glm::radians(40.0);
        scene.state.lights = {sun(40, 0)};
        if (!is_sun) {
            scene.state.lights[0].type = scene::LightType::point;
            scene.state.lights[0].position = {0.1, 2.5, -0.2};
        }
        // The shadow: moved by the sun's slope; from the lamp a quarter larger, about the point below it.
        const double side = is_sun ? 1 : 1.25;
        const glm::dvec2 middle =
            is_sun ? glm::dvec2(-0.5 * std::tan(zenith), 0) : -0.25 * glm::dvec2(0.1, -0.2);
        const auto sheets = beams<double>(scene, Event::transmission);
        int dark = 0;
        for (std::size_t t = 0; t < below; ++t) {
            glm::dvec3 at(0);
            for (int k = 0; k < 3; ++k) at += water->mesh.positions[water->mesh.triangles[t][k]] / 3.0;
            const glm::dvec2 off = glm::abs(glm::dvec2(at.x, at.z) - middle) - 0.5 * side;
            const double outside = std::max(off.x, off.y);
            if (std::abs(outside) < 0.05) continue;  // within a cell of its edge
            ASSERT_EQ(sheets[0].flux[t] > 0, outside > 0) << at.x << ' ' << at.z;
            dark += outside < 0 ? 1 : 0;
        }
        EXPECT_GT(dark, 500);
        for (std::size_t t = below; t < water->mesh.triangles.size(); ++t) ASSERT_GT(sheets[0].flux[t], 0);
        if (is_sun) {
            const auto mirrored = beams<double>(scene, Event::reflection);
            // Along 4 m of edges triangles of 5 cm are sampled by sixteenths.
            EXPECT_NEAR(sheets[0].losses.wave_shadow + mirrored[0].losses.wave_shadow, std::cos(zenith),
                        0.02);
        }
    }
}

TEST(WaveShadow, AMeshThatIsOneSheetHasNoShadowsBeforeSomeTriangleFacesAway) {
    // Asked or not: what is no grid is asked everywhere.
    for (const glm::dvec2 center : {glm::dvec2(0), glm::dvec2(300, -200)}) {
        scene::FrameScene scene = water_scene({6, 6}, center);
        scene.origin = {center.x, 0, center.y};
        add_water(scene, gentle_sea(), 200, 200);
        auto water = std::make_shared<scene::WaterMesh>(*scene.water);
        water->rows = water->columns = 0;
        const auto grid = scene.water;
        for (const double zenith : {0.0, 60.0, 72.0}) {
            SCOPED_TRACE(zenith);
            scene.state.lights = {sun(zenith)};
            scene.water = grid;
            const auto expected = beams<double>(scene, Event::transmission);
            ASSERT_EQ(flux_and_losses(expected), flux(expected));
            scene.water = water;
            EXPECT_EQ(beams<double>(scene, Event::transmission)[0].flux, expected[0].flux);
        }
    }
}

TEST(WaveShadow, LowSunsAreAccountedForToTheLastRay) {
    const Curve curve = sampled(800, [](double s) {
        const double x = 8 * s - 4;
        return glm::dvec2(x, 0.03 * std::cos(4 * x) + 0.02 * std::sin(9 * x + 1));
    });
    scene::FrameScene scene = extruded(curve, 2);
    for (const double elevation : {0.1, 0.3, 1.0, 2.0, 5.0}) {
        SCOPED_TRACE(elevation);
        scene.state.lights = {sun(90 - elevation, 0)};
        const auto through = beams<float>(scene, Event::transmission);
        const auto mirrored = beams<float>(scene, Event::reflection);
        expect_sound(through);
        expect_sound(mirrored);
        // Fluxes are rounded to float, a triangle.
        EXPECT_NEAR((flux_and_losses(through) + flux_and_losses(mirrored)) / met_by_sun(scene), 1, 1e-6);
        // What is lit are strips at the crests, as narrow as 20 cells, whose edges are sampled by sixteenths.
        EXPECT_NEAR((flux(through) + flux(mirrored)) / met_by_curve(curve, glm::radians(elevation), 2), 1,
                    0.01);
    }
}

/// The share of light that is not hidden, by one ray from the middle of each triangle that faces the light.
double lit_share(const scene::FrameScene& scene, const light::WaterLight& light) {
    const rays::RayScene rays(scene);
    const scene::TriangleMesh& mesh = scene.water->mesh;
    double lit = 0, all = 0;
    for (const glm::uvec3 t : mesh.triangles) {
        const double met = light::incident_on_triangle(mesh, t, light);
        if (!(met > 0)) continue;
        const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
        const glm::dvec3 from = (a + b + c) / 3.0 + 1e-5 * glm::normalize(glm::cross(b - a, c - a));
        rays::Ray ray{glm::vec3(from), 0, glm::vec3(-light.direction)};
        if (light.type != scene::LightType::sun) {
            ray.direction = glm::vec3(light.position - from);
            ray.far = 1;
        }
        rays::Hit hit;
        rays.intersect_water({&ray, 1}, {&hit, 1});
        all += met;
        if (hit.primitive == rays::kNoHit) lit += met;
    }
    return lit / all;
}

TEST(WaveShadow, OnlyTrianglesAmongThoseThatFaceAwayNeedToBeAsked) {
    scene::FrameScene scene = water_scene({6, 6});
    add_water(scene, gentle_sea(0.012), 200, 200);
    for (const glm::dvec3 lamp : {glm::dvec3(0), {0.4, 0.3, -0.7}, {7, 1, 3}}) {
        const bool sun = lamp.y == 0;
        light::WaterLight light;
        light.direction = test::sun(sun ? 80 : 0).direction;
        light.position = lamp;
        if (!sun) light.type = scene::LightType::point;
        const rays::RayScene rays(scene);
        const std::vector<float> visible = light::visible_shares(scene, rays, light);
        double lit = 0, all = 0;
        for (std::size_t i = 0; i < visible.size(); ++i) {
            const double met =
                light::incident_on_triangle(scene.water->mesh, scene.water->mesh.triangles[i], light);
            if (!(met > 0)) continue;
            all += met;
            lit += met * static_cast<double>(visible[i]);
        }
        const double expected = lit_share(scene, light);
        EXPECT_LT(expected, 0.99);
        // One ray a triangle: the edges of some hundred shadows, averaged over their cells.
        EXPECT_NEAR(lit / all, expected, 1e-3);
    }
}

TEST(WaveShadow, StatsTellBeamsAndLossesInWatts) {
    RidgeScene ridges;
    ridges.scene.state.lights[0].irradiance = {3, 2, 1};
    const rays::RayScene rays(ridges.scene);
    FrameStats stats;
    const auto sheets = light::water_beams<float>(ridges.scene, rays, {0, Event::transmission}, 1, stats);
    EXPECT_EQ(stats.counted("beams"),
              std::count_if(sheets[0].flux.begin(), sheets[0].flux.end(), [](float f) { return f > 0; }));
    EXPECT_NEAR(stats.counted("lost to wave shadow, W"), 2 * sheets[0].losses.wave_shadow, 1e-12);
    ASSERT_EQ(stats.passes().size(), 1u);
    EXPECT_EQ(stats.passes()[0].name, "beams");
}

}  // namespace
}  // namespace dapple
