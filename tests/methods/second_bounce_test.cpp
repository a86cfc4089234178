// Light that mirrors in the water send up to the underside of a hull.
#include <gtest/gtest.h>

#include "closed_form/gentle_sea.h"
#include "light/beam_axes.h"
#include "methods/caustic_mesh/caustic_mesh.h"
#include "methods/reference_frame.h"
#include "methods/splat_scene.h"
#include "scene/area_light.h"

namespace dapple {
namespace {

using scene::PhotonFootprint;
using test::Frame;
using test::LayerResult;
using test::relative_l1;

constexpr double kBottom = 1.5, kHull = 0.3;  // m of depth
constexpr double kZenith = 50;                // degrees
constexpr int kPixels = 32;
constexpr double kView = 1.6;  // m

/// Refracted below flat water.
double refracted() {
    return std::asin(std::sin(kZenith * scene::kDegree) / 1.333);
}
/// m along x between the bottom and the hull.
double aside() {
    return (kBottom - kHull) * std::tan(refracted());
}

/// A hull beside the light that a mirror on the bottom gets, and above what it sends on; seen from below.
scene::FrameState dock(const scene::Object& mirror) {
    scene::FrameState state = test::pool_over_floor(4, 4, kView, kPixels);
    state.lights = {test::sun_from_zenith(kZenith)};
    state.objects = {mirror, test::level_plane("hull", -kHull, 1.6)};
    state.objects[0].material.mirror = true;
    state.objects[0].material.color = {0.9, 0.6, 0.3};
    state.objects[1].transform.position.x = aside();
    state.objects[1].transform.rotation = {glm::pi<double>(), 0, 0};
    state.camera.position = {aside(), -0.5 * (kBottom + kHull), 0};
    state.camera.target = {aside(), 0, 0};
    state.caustics.reference = test::kOneRound;
    state.caustics.map.map_resolution = 200;  // 2 cm
    state.caustics.map.second_bounce = true;
    return state;
}

scene::Object level_mirror() {
    scene::Object mirror = test::level_plane("mirror", -kBottom, 1);
    mirror.size = {0.6, 1, 0.8};
    return mirror;
}

/// A method that starts from a caustic map, and what it makes of a photon.
struct Way {
    const char* name;
    PhotonFootprint footprint = PhotonFootprint::tent;
    bool mesh = false;
};

LayerResult by_map(const scene::FrameState& state, const Way& way, FrameStats& stats) {
    Frame frame(state);
    frame.scene.state.caustics.photon_splatting.footprint = way.footprint;
    frame.chains.clear();
    for (std::size_t i = 0; i < state.lights.size(); ++i)
        frame.chains.push_back({static_cast<int>(i), light::Event::transmission});
    const rays::RayScene rays(frame.scene);
    view::LayerCounts counts;
    const view::ReceiverLayer layer = view::trace_layer(frame.scene, rays, {}, counts);
    methods::FrameContext context{frame.scene, rays, test::validated_device(), stats, frame.chains};
    methods::PhotonSplatting photons;
    methods::CausticMesh mesh;
    methods::CausticMethod& method =
        way.mesh ? static_cast<methods::CausticMethod&>(mesh) : static_cast<methods::CausticMethod&>(photons);
    method.begin(context);
    LayerResult result;
    method.irradiance(context, std::span(&layer, 1), std::span(&result, 1));
    return result;
}

const std::vector<Way> kWays = {{"tents"},
                                {"photon differences", PhotonFootprint::photon_difference},
                                {"photon differentials", PhotonFootprint::photon_differential},
                                {"fixed", PhotonFootprint::fixed},
                                {"caustic mesh", PhotonFootprint::tent, true}};

std::vector<std::pair<Way, int>> with_cascades(const std::vector<Way>& ways) {
    std::vector<std::pair<Way, int>> all;
    for (const int cascades : {1, 2})
        for (const Way& way : ways) all.emplace_back(way, cascades);
    return all;
}

TEST(SecondBounce, OfALevelMirrorBelowFlatWater) {
    const test::FlatFloor at = test::flat_floor(kZenith, 2 * kBottom - kHull, 1.333);
    // Of two cascades the finer one's share falls to nothing in the middle of what lights the mirror.
    for (const auto& [way, cascades] : with_cascades(kWays)) {
        SCOPED_TRACE(cascades);
        scene::FrameState state = dock(level_mirror());
        state.caustics.map.cascades = cascades;
        state.caustics.map.cascade_center = scene::CascadeCenter::extent;
        FrameStats stats;
        const LayerResult found = by_map(state, way, stats);
        double flux = 0, columns = 0, rows = 0;
        for (int i = 0; i < kPixels * kPixels; ++i) {
            const int column = i % kPixels, row = i / kPixels;
            const double x = kView * ((column + 0.5) / kPixels - 0.5);
            const double z = kView * ((row + 0.5) / kPixels - 0.5);
            // From the border of what the mirror sends on: a photon's spacing and a pixel beyond it, or
            // within.
            const double outside = std::max(std::abs(x) - 0.3, std::abs(z) - 0.4);
            const glm::vec3 e = found.irradiance[static_cast<std::size_t>(i)];
            for (int c = 0; c < 3; ++c) {
                const double lit = state.lights[0].irradiance[c] * at.irradiance *
                                   std::exp(-state.water->absorption[c] * at.way) *
                                   state.objects[0].material.color[c];
                if (outside > 0.07) {
                    EXPECT_EQ(e[c], 0) << way.name << " " << x << " " << z;
                } else if (outside < -0.07) {
                    EXPECT_NEAR(static_cast<double>(e[c]) / lit, 1, 1e-4) << way.name << " " << x << " " << z;
                }
                if (c == 0) {
                    const double share = static_cast<double>(e[c]) / lit;
                    flux += share * std::pow(kView / kPixels, 2);
                    if (std::abs(z) < 0.03) columns += 0.5 * share * kView / kPixels;
                    if (std::abs(x) < 0.03) rows += 0.5 * share * kView / kPixels;
                }
            }
        }
        // The border lies within a photon's spacing at either side.
        printf("%s: lit %.4f x %.4f m, %.4f m^2\n", way.name, columns, rows, flux);
        EXPECT_NEAR(columns, 0.6, 0.02);
        EXPECT_NEAR(rows, 0.8, 0.02);
        // Before the way from mirror to hull.
        const double sent = 0.48 * at.irradiance / 3 *
                            glm::dot(state.lights[0].irradiance * state.objects[0].material.color,
                                     glm::exp(-state.water->absorption * (kBottom / std::cos(refracted()))));
        EXPECT_NEAR(stats.counted("light sent on by mirrors, W") / sent, 1, 0.04);
        state.caustics.map.second_bounce = false;
        for (const glm::vec3& e : by_map(state, way, stats).irradiance) EXPECT_EQ(e, glm::vec3(0));
    }
}

TEST(SecondBounce, LightThatMeetsTheWaterOrAnotherMirrorIsCounted) {
    scene::FrameState state = dock(level_mirror());
    FrameStats open, closed;
    state.objects[1].transform.position.x = -20;
    by_map(state, kWays[0], open);
    EXPECT_GT(open.counted("light sent on by mirrors, W"), 0.1);
    EXPECT_NEAR(open.counted("lost at the water behind mirrors, W"),
                open.counted("light sent on by mirrors, W"), 1e-9);
    EXPECT_EQ(open.counted("lost to second mirrors, W"), 0);
    state.objects[1].transform.position.x = aside();
    state.objects[1].material.mirror = true;
    by_map(state, kWays[0], closed);
    // The hull's upper side is a mirror too, whose light leaves the water.
    EXPECT_NEAR(closed.counted("lost to second mirrors, W"), open.counted("light sent on by mirrors, W"),
                1e-9);
    EXPECT_NEAR(
        closed.counted("lost to second mirrors, W") + closed.counted("lost at the water behind mirrors, W"),
        closed.counted("light sent on by mirrors, W"), 1e-9);
}

TEST(SecondBounce, AMirrorThrowsTheShadowOfAMattePlate) {
    // A plate between mirror and hull, in the hull's own shadow from the sun: what it keeps from the hull
    // does not hang on what it is made of.
    scene::FrameState state = dock(level_mirror());
    scene::Object plate = test::level_plane("plate", -kHull - 0.1, 1);
    plate.size = {0.5, 1, 0.3};
    plate.transform.position.x = aside() + 0.25;
    plate.transform.rotation = {glm::pi<double>(), 0, 0};
    state.objects.push_back(plate);
    // From between plate and hull.
    state.camera.position.y = -kHull - 0.05;
    for (const Way& way : kWays) {
        FrameStats stats;
        state.objects[2].material.mirror = false;
        const LayerResult matte = by_map(state, way, stats);
        state.objects[2].material.mirror = true;
        const LayerResult mirror = by_map(state, way, stats);
        EXPECT_GT(stats.counted("lost to second mirrors, W"), 0.01);
        std::size_t dark = 0;
        for (std::size_t i = 0; i < matte.irradiance.size(); ++i) {
            dark += matte.irradiance[i].x == 0 ? 1 : 0;
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(mirror.irradiance[i][c], matte.irradiance[i][c], 1e-6f) << way.name << " " << i;
        }
        EXPECT_GT(dark, matte.irradiance.size() / 20);
    }
}

/// L1 of a method against the reference, beside what the reference's own noise makes of it, and the bias.
void expect_like_reference(const scene::FrameState& state, const std::vector<Way>& ways, std::uint64_t strata,
                           double l1, double bias) {
    Frame frame(state);
    frame.options.first_strata = strata;
    frame.options.second_crossings = false;
    const LayerResult truth = frame.render();
    for (const Way& way : ways) {
        FrameStats stats;
        const LayerResult found = by_map(state, way, stats);
        double difference = 0, noise = 0, sum = 0, all = 0;
        for (std::size_t i = 0; i < truth.irradiance.size(); ++i) {
            const auto e = static_cast<double>(truth.irradiance[i].x);
            const auto f = static_cast<double>(found.irradiance[i].x);
            difference += std::abs(f - e);
            noise += std::sqrt(2 / glm::pi<double>() * static_cast<double>(truth.data[0].values[i]));
            sum += e;
            all += f;
        }
        printf("%s: L1 %.2f %%, noise %.2f %%, bias %.2f %%\n", way.name, 100 * difference / sum,
               100 * noise / sum, 100 * (all / sum - 1));
        EXPECT_LT(difference / sum, noise / sum + l1) << way.name;
        EXPECT_LT(std::abs(all / sum - 1), bias) << way.name;
    }
}

TEST(SecondBounce, OfALevelMirrorBelowWavesIsThatOfTheReference) {
    scene::FrameState state = dock(level_mirror());
    state.objects[0].size = {1.4, 1, 1.4};
    state.camera.view_height = 1;  // within its border, which the test above looks at
    state.water->surface.type = scene::WaterSurfaceType::waves;
    state.water->surface.waves = test::gentle_waves();
    state.water->mesh_cells = 200;
    expect_like_reference(state, kWays, 1 << 16, 0.02, 0.01);
}

scene::Object mirror_ball() {
    scene::Object ball;
    ball.name = "ball";
    ball.shape = scene::Shape::sphere;
    ball.radius = 0.5;
    ball.transform.position = {0, -kBottom - 0.3, 0};
    return ball;
}

TEST(SecondBounce, OfACurvedMirrorIsThatOfTheReference) {
    scene::FrameState state = dock(mirror_ball());
    state.clip.width = state.clip.height = 12;
    expect_like_reference(state, {kWays[0], kWays[2]}, 1 << 18, 0.02, 0.025);
    // Beside rays that miss the ball its cells are laid as if their rays were parallel: 3 % of the light at 2
    // cm.
    state.caustics.map.map_resolution = 400;
    expect_like_reference(state, {kWays[4]}, 1 << 18, 0.02, 0.025);
}

/// The dock with a ball, whose curvature spreads a light's rays five times as far apart on the hull as a
/// level mirror, below waves that focus on it.
scene::FrameState dock_with_ball() {
    scene::FrameState state = dock(mirror_ball());
    state.clip.width = state.clip.height = 24;
    state.camera.view_height = 1;
    state.water->surface.type = scene::WaterSurfaceType::waves;
    state.water->surface.waves = test::gentle_waves();
    for (scene::Wave& wave : state.water->surface.waves.waves) wave.amplitude *= 2;
    state.water->mesh_cells = 160;
    return state;
}

/// `one`: the light as one ray a place, widened; `plain`: as a point; `many`: its parts as points.
void expect_blur(const Way& way, const scene::FrameState& one, const scene::FrameState& plain,
                 const scene::FrameState& many) {
    FrameStats stats;
    const LayerResult truth = by_map(many, way, stats);
    const double with = relative_l1(by_map(one, way, stats), truth);
    const double without = relative_l1(by_map(plain, way, stats), truth);
    printf("L1 widened %.2f %%, as a point %.2f %%\n", 100 * with, 100 * without);
    // Measured 0.43 and 0.52: what is left is beyond the second order. Widened as if the ball were level,
    // 0.71 and 0.74.
    EXPECT_LT(with, 0.6 * without);
}

/// With a sun of 2 degrees; its disc by so many points.
void expect_disc_blur(const Way& way, scene::FrameState one, int points) {
    one.lights[0].angular_diameter = 2 * scene::kDegree;
    scene::FrameState plain = one;
    plain.lights[0].angular_diameter = 0;
    scene::FrameState many = plain;
    many.lights.clear();
    for (const glm::dvec3& direction : light::sun_directions(one.lights[0], points)) {
        scene::Light& part = many.lights.emplace_back(plain.lights[0]);
        part.direction = direction;
        part.irradiance /= points;
    }
    expect_blur(way, one, plain, many);
}

TEST(SecondBounce, ACurvedMirrorSpreadsTheSunsDisc) {
    expect_disc_blur(kWays[0], dock_with_ball(), 16);
}

TEST(SecondBounce, ACurvedMirrorSpreadsTheSunsDiscInCells) {
    // Cells of 2 cm, each with one image of the disc, are as far off as the disc.
    scene::FrameState state = dock_with_ball();
    state.clip.width = state.clip.height = 40;
    state.water->mesh_cells = 200;
    state.caustics.map.map_resolution = 340;
    expect_disc_blur(kWays[4], state, 16);
}

TEST(SecondBounce, ACurvedMirrorSpreadsAnAreaLight) {
    scene::FrameState given = dock_with_ball();
    scene::Light& panel = given.lights[0];
    panel.type = scene::LightType::quad;
    panel.position = -4.0 * panel.direction;
    panel.size = {0.14, 0.14};
    panel.samples = 1;
    const scene::FrameState one = scene::with_emitter_parts(given);
    const auto as_points = [&](int samples) {
        panel.samples = samples;
        scene::FrameState state = scene::with_emitter_parts(given);
        for (scene::Light& part : state.lights) part.part.spread_u = part.part.spread_v = glm::dvec3(0);
        return state;
    };
    expect_blur(kWays[0], one, as_points(1), as_points(16));
}

}  // namespace
}  // namespace dapple
