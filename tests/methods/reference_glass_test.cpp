// The brute-force reference follows light through bodies of glass: closed forms of E and S, and its energy.
#include <gtest/gtest.h>

#include "methods/reference/light_tracer.h"
#include "methods/reference_volume_frame.h"

namespace dapple {
namespace {

using namespace test;

constexpr light::Event kThrough = light::Event::transmission, kBack = light::Event::reflection;

scene::Object glass(scene::Shape shape, glm::dvec3 position, double index) {
    scene::Object object;
    object.name = "glass";
    object.shape = shape;
    object.transform.position = position;
    object.material.glass = true;
    object.material.refractive_index = index;
    return object;
}

/// A frame whose first round, which is the answer, has a quarter of a million rays.
struct GlassFrame : Frame {
    explicit GlassFrame(const scene::FrameState& state, std::uint64_t strata = 16384) : Frame(state) {
        options.first_strata = strata;
    }
};

/// A floor at y = 0 in the air, seen straight down from under the glass at `height`; without water.
scene::FrameState floor_below(scene::Object body, double height, double view, int pixels) {
    scene::FrameState state;
    state.clip.width = state.clip.height = pixels;
    state.clip.samples = 1;
    state.camera.projection = scene::Projection::orthographic;
    state.camera.position = {0, height, 0};
    state.camera.target = {0, 0, 0};
    state.camera.up = {0, 0, -1};
    state.camera.view_height = view;
    state.objects = {level_plane("floor", 0, 100), std::move(body)};
    state.lights = {sun_from_zenith(0)};
    state.caustics.method = "reference";
    state.caustics.reference = kOneRound;
    return state;
}

/// A slab of 0.2 m over the floor, and the part of the floor that the sun's light through its middle reaches.
/// What enters by the sides never leaves by the bottom: it is totally reflected there. What they reflect
/// leaves by the bottom nearer to them than half the slab's width.
scene::FrameState slab_over_floor(double zenith, const glm::dvec3& absorption, int pixels) {
    scene::Object slab = glass(scene::Shape::box, {0, 0.6, 0}, 1.5);
    slab.size = {2.4, 0.2, 1.2};
    slab.material.absorption = absorption;
    scene::FrameState state = floor_below(slab, 0.4, 0.5, pixels);
    state.camera.position.x = state.camera.target.x = 0.6 * std::tan(glm::radians(zenith));
    state.lights = {sun_from_zenith(zenith)};
    return state;
}

/// T^2 a / (1 - R^2 a^2): straight through, and after any number of pairs of reflections inside; a is what
/// one way through leaves.
double slab_transmittance(double zenith, double thickness, double index, double absorption) {
    const Refraction at = refract(glm::radians(zenith), 1, index);
    const double way = std::exp(-absorption * thickness / std::cos(at.angle));
    const double r = at.reflectance;
    return (1 - r) * (1 - r) * way / (1 - r * r * way * way);
}

TEST(ReferenceGlass, SlabOverAFloor) {
    for (const double zenith : {0.0, 35.0, 60.0}) {
        const glm::dvec3 absorption(0, 0.8, 3);
        GlassFrame frame(slab_over_floor(zenith, absorption, 8));
        frame.chains = {{0, kThrough, 1}};
        const LayerResult result = frame.render();
        for (int channel = 0; channel < 3; ++channel) {
            const double e = frame.scene.state.lights[0].irradiance[channel] *
                             std::cos(glm::radians(zenith)) *
                             slab_transmittance(zenith, 0.2, 1.5, absorption[channel]);
            // Light that is reflected more often inside than the weakest branches allow is left out: less
            // than 1e-4 of E, where the standard error of the mean over the picture is 1e-2.
            expect_agreement(agreement(result, std::vector<double>(64, e), channel));
        }
    }
}

TEST(ReferenceGlass, AGlassOfIndexOneIsNotThere) {
    // Sphere, box and mesh; E is that of the sun alone.
    for (const scene::Shape shape : {scene::Shape::sphere, scene::Shape::box, scene::Shape::mesh}) {
        scene::Object body = glass(shape, {0, 2, 0}, 1);
        body.radius = 1;
        body.size = {1.5, 1.3, 1.4};
        body.transform.rotation = {0.2, 0.3, 0.5};
        scene::FrameState state = floor_below(body, 0.5, 0.5, 8);
        GlassFrame frame(state);
        if (shape == scene::Shape::mesh) {
            // Two pyramids, base to base, with normals that mean nothing: they must not bend what has no
            // index.
            auto mesh = std::make_shared<scene::TriangleMesh>();
            mesh->positions = {{1, 0, 0}, {0, 0, -1}, {-1, 0, 0}, {0, 0, 1}, {0, 0.8, 0}, {0, -0.8, 0}};
            for (glm::uint i = 0; i < 4; ++i) {
                mesh->triangles.push_back({i, (i + 1) % 4, 4});
                mesh->triangles.push_back({(i + 1) % 4, i, 5});
            }
            for (const glm::dvec3& position : mesh->positions) mesh->normals.push_back(normalize(position));
            frame.scene.object_meshes[1] = mesh;
        }
        frame.chains = {{0, kThrough, 1}, {0, kBack, 1}};
        expect_agreement(agreement(frame.render(), std::vector<double>(64, 3)));
    }
}

TEST(ReferenceGlass, TwoSlabs) {
    // Each sends on t = (1 - R) / (1 + R) and r = 1 - t of the light back: together t^2 / (1 - r^2).
    scene::FrameState state = slab_over_floor(0, glm::dvec3(0), 8);
    state.objects.push_back(state.objects[1]);
    state.objects.back().transform.position.y = 1;
    GlassFrame frame(state, 4096);
    frame.chains = {{0, kThrough, 1}, {0, kThrough, 2}};
    const double r1 = refract(0, 1, 1.5).reflectance, t = (1 - r1) / (1 + r1), r = 1 - t;
    expect_agreement(agreement(frame.render(), std::vector<double>(64, 3 * t * t / (1 - r * r))));
}

TEST(ReferenceGlass, LampsBeforeAndInGlassOfIndexOne) {
    // The ball in perspective, all around a near lamp, and about it: I cos / d^2.
    for (const glm::dvec3 position :
         {glm::dvec3(0.3, 4.5, 0.2), glm::dvec3(0.1, 3.1, -0.2), glm::dvec3(0.2, 2.3, 0.1)}) {
        scene::Object ball = glass(scene::Shape::sphere, {0, 2, 0}, 1);
        ball.radius = 1;
        scene::FrameState state = floor_below(ball, 0.5, 0.6, 4);
        scene::Light lamp;
        lamp.type = scene::LightType::point;
        lamp.position = position;
        state.lights = {lamp};
        GlassFrame frame(state);
        frame.chains = {{0, kThrough, 1}};
        const auto direct = [&](double x, double z) {
            const glm::dvec3 way = glm::dvec3(x, 0, z) - position;
            return 10 * -way.y / std::pow(length(way), 3);
        };
        expect_agreement(agreement(frame.render(), pixel_means(0.6, 4, direct)));
    }
}

/// What a sun of unit irradiance overhead sends through a ball of radius 1 to the pixels of a square picture
/// of `view` m around the axis, `depth` m below its middle: W a pixel. Angles in the plane of a ray at the
/// distance b = sin(i) from the axis: it turns by i - t where it enters and leaves, and by pi - 2 t at each
/// reflection inside. Steps of b^2, for each as many angles about the axis by the golden ratio, and the mean
/// over the eight pixels that are alike.
std::vector<double> below_ball(double index, double depth, double view, int pixels) {
    constexpr int steps = 1 << 18, angles = 32;
    const auto at = [&](int x, int z) { return static_cast<std::size_t>(z * pixels + x); };
    std::vector<double> flux(at(0, pixels), 0);
    for (int step = 0; step < steps; ++step) {
        const double i = std::asin(std::sqrt((step + 0.5) / steps));
        const Refraction split = refract(i, 1, index);
        const double within = glm::pi<double>() - 2 * split.angle;
        double power = glm::pi<double>() / steps / angles * std::pow(1 - split.reflectance, 2);
        for (int reflections = 0; power * steps > 1e-9; ++reflections, power *= split.reflectance) {
            const double place = i + (reflections + 1) * within;
            const double turned = 2 * (i - split.angle) + reflections * within;
            if (!(std::cos(turned) > 0)) continue;
            const double way = (std::cos(place) + depth) / std::cos(turned);
            const double r = (std::sin(place) - way * std::sin(turned)) / view * pixels;
            if (std::abs(r) > pixels) continue;
            for (int k = 0; k < angles; ++k) {
                const double azimuth =
                    2 * glm::pi<double>() * std::fmod((step * angles + k) * 0.6180339887498949, 1.0);
                const double x = r * std::cos(azimuth) + 0.5 * pixels;
                const double z = r * std::sin(azimuth) + 0.5 * pixels;
                if (x < 0 || z < 0 || x >= pixels || z >= pixels) continue;
                flux[at(static_cast<int>(x), static_cast<int>(z))] += power;
            }
        }
    }
    std::vector<double> alike(flux.size());
    for (int z = 0; z < pixels; ++z) {
        for (int x = 0; x < pixels; ++x) {
            const int u = pixels - 1 - x, v = pixels - 1 - z;
            alike[at(x, z)] = (flux[at(x, z)] + flux[at(u, z)] + flux[at(x, v)] + flux[at(u, v)] +
                               flux[at(z, x)] + flux[at(v, x)] + flux[at(z, u)] + flux[at(v, u)]) /
                              8;
        }
    }
    return alike;
}

TEST(ReferenceGlass, BallLens) {
    // At the paraxial focus, n / (2 (n - 1)) = 1.5 radii from the middle, and well behind it.
    for (const double depth : {1.5, 2.5}) {
        // At the focus pixels are quarters of quarters of the floor, so that no light counts for the next
        // one; behind it an odd number, which keeps their edges off those of the strata.
        const double view = depth == 1.5 ? 0.0625 : 0.5;
        const int pixels = depth == 1.5 ? 16 : 15;
        scene::Object ball = glass(scene::Shape::sphere, {0, depth, 0}, 1.5);
        ball.radius = 1;
        scene::FrameState state = floor_below(ball, 0.3, view, pixels);
        state.lights[0].irradiance = glm::dvec3(1);
        state.objects[0].size = glm::dvec3(8);
        GlassFrame frame(state);
        frame.chains = {{0, kThrough, 1}};
        const LayerResult result = frame.render();
        std::vector<double> expected = below_ball(1.5, depth, view, pixels);
        const double pixel = view * view / (pixels * pixels);
        for (double& value : expected) value /= pixel;
        expect_agreement(agreement(result, expected));
        // Flux through the disc of pixels about the axis.
        double found = 0, variance = 0, exact = 0;
        for (int i = 0; i < pixels * pixels; ++i) {
            const double x = i % pixels + 0.5 - 0.5 * pixels, z = i / pixels + 0.5 - 0.5 * pixels;
            if (std::hypot(x, z) > 0.25 * pixels) continue;
            const auto at = static_cast<std::size_t>(i);
            found += pixel * static_cast<double>(result.irradiance[at].x);
            variance += pixel * pixel * static_cast<double>(result.data[0].values[at]);
            exact += pixel * expected[at];
        }
        printf("disc of %.3f m: %.6f +- %.6f of %.6f W\n", 0.25 * view, found, std::sqrt(variance), exact);
        EXPECT_NEAR(found, exact, 3 * std::sqrt(variance));
    }
}

TEST(ReferenceGlass, GlassOfWaterInWaterIsNotThere) {
    scene::FrameState state = small_pool(3, 2, 1, 8);
    scene::Object ball = glass(scene::Shape::sphere, {0.1, -1, 0}, state.water->refractive_index);
    ball.radius = 0.7;
    ball.material.absorption = state.water->absorption;
    state.objects.push_back(ball);
    state.camera.position.y = -1.8;
    state.camera.target.y = -2;
    state.lights = {sun_from_zenith(35)};
    state.caustics.reference = kOneRound;
    GlassFrame frame(state);
    frame.chains = {{0, kThrough}, {0, kThrough, 1}, {0, kBack, 1}};
    const FlatFloor exact = flat_floor(35, 2, state.water->refractive_index);
    const double e = 3 * exact.irradiance * std::exp(-state.water->absorption.x * exact.way);
    const LayerResult result = frame.render();
    expect_agreement(agreement(result, std::vector<double>(64, e)));
    // All of it is the water's own.
    frame.chains = {{0, kThrough, 1}, {0, kBack, 1}};
    for (const glm::vec3& dark : frame.render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(ReferenceGlass, BlockInTheSurface) {
    // Half in the air and half in the water, light straight down: T1 T2 a / (1 - R1 R2 a^2), then the water.
    scene::FrameState state = small_pool(3, 1, 0.4, 8);
    scene::Object block = glass(scene::Shape::box, {0, -0.1, 0}, 1.6);
    block.size = {1, 0.8, 1};
    block.material.absorption = {0.7, 0.2, 0};
    state.objects.push_back(block);
    state.camera.position.y = -0.8;
    state.lights = {sun_from_zenith(0)};
    state.caustics.reference = kOneRound;
    for (const double height : {0.0, 0.02}) {
        // Level, and with waves, which the block's bottom does not meet.
        if (height > 0) state.water->surface.waves.waves = {{0.5, 0, height, 0}};
        GlassFrame frame(state);
        frame.chains = {{0, kThrough, 1}};
        const LayerResult result = frame.render();
        for (int channel = 0; channel < 3; ++channel) {
            const double r1 = refract(0, 1, 1.6).reflectance;
            const double r2 = refract(0, 1.6, state.water->refractive_index).reflectance;
            const double a = std::exp(-0.8 * block.material.absorption[channel]);
            const double e = state.lights[0].irradiance[channel] * (1 - r1) * (1 - r2) * a /
                             (1 - r1 * r2 * a * a) * std::exp(-0.5 * state.water->absorption[channel]);
            expect_agreement(agreement(result, std::vector<double>(64, e), channel));
        }
    }
}

/// Traces all of one source, and prints where its light went.
reference::EnergyAccount account_of(const scene::FrameState& state, std::vector<light::Chain> chains,
                                    std::size_t strata = 1 << 16) {
    GlassFrame frame(state);
    const rays::RayScene rays(frame.scene);
    const reference::ReceiverCharts charts(frame.scene);
    const reference::LightTracer tracer(frame.scene, rays, chains, charts, {});
    EXPECT_EQ(tracer.sources(), 1U);
    const reference::LightPass pass{0, strata};
    const reference::EnergyAccount account = tracer.trace(pass, 0, 0, tracer.strata(pass, 0)).account;
    printf("emitted %.6f: arrived %.6f, escaped %.6f, absorbed %.6f, weak %.2g, long %.2g, astray %.2g\n",
           account.emitted, account.arrived, account.escaped, account.absorbed, account.weak,
           account.long_chains, account.astray);
    return account;
}

/// Of what is emitted all is found, but for 1e-3.
void expect_energy(const reference::EnergyAccount& account, double emitted) {
    EXPECT_NEAR(account.emitted, emitted, 1e-3 * emitted);
    EXPECT_NEAR(account.arrived + account.escaped + account.absorbed, account.emitted,
                1e-3 * account.emitted);
    EXPECT_GT(account.weak, 0);
    EXPECT_EQ(account.left_out, 0);
}

TEST(ReferenceGlass, LightIsOfTheFirstBodyThatItMeets) {
    scene::FrameState state = slab_over_floor(0, glm::dvec3(0), 8);
    state.objects.push_back(state.objects[1]);
    state.objects.back().transform.position.y = 4;
    EXPECT_EQ(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}, 4096).emitted, 0);
    EXPECT_NEAR(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 2 * 2.4 * 1.2, 1e-9);
    // Water over both is met before them.
    state.water.emplace();
    state.water->extent.size = {5, 5};
    state.objects[0].transform.position.y = -5;
    state.objects[1].transform.position.y = -2;
    state.objects[2].transform.position.y = -1;
    EXPECT_EQ(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 0);
    // Under half of the water's rectangle; beside it there is air below a pool's, and open water.
    state.water->extent.center.x = 2.5;
    EXPECT_NEAR(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 2 * 1.2 * 1.2, 0.01);
    state.water->extent.kind = scene::ExtentKind::open_water;
    EXPECT_EQ(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 0);
}

TEST(ReferenceGlass, EnergyOfABall) {
    scene::Object ball = glass(scene::Shape::sphere, {0.3, 1.5, -0.2}, 1.5);
    ball.radius = 0.7;
    ball.material.absorption = {0, 0.5, 2};
    scene::FrameState state = floor_below(ball, 0.3, 1, 4);
    state.lights = {sun_from_zenith(35)};
    const double pi = glm::pi<double>();
    expect_energy(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}), 2 * pi * 0.49);
    // An ellipsoid, and a disc of 2 degrees: the shadow of x^2/a^2 + y^2 + z^2/c^2 = 1 along unit d has the
    // area pi a c sqrt(dx^2/a^2 + dy^2 + dz^2/c^2), nearly even over the disc.
    state.objects[1].transform.scale = {2, 1, 0.5};
    state.lights[0].angular_diameter = 2 * scene::kDegree;
    const glm::dvec3 d = state.lights[0].direction / glm::dvec3(2, 1, 0.5);
    expect_energy(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}), 2 * pi * 0.49 * length(d));
    // A lamp at 3 m: 2 pi I (1 - cos of the angle of the ball).
    state.objects[1].transform.scale = glm::dvec3(1);
    state.lights[0].type = scene::LightType::point;
    state.lights[0].position = glm::dvec3(0.3, 1.5, -0.2) + 3.0 * normalize(glm::dvec3(1, 2, 0.3));
    const double sine = 0.7 / 3;
    expect_energy(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}),
                  2 * pi * 10 * sine * sine / (1 + std::sqrt(1 - sine * sine)));
}

TEST(ReferenceGlass, EnergyOfATurnedBlockInWaves) {
    // A block that straddles waves, under a lamp in the water; all that leaves the water's rectangle escapes.
    scene::FrameState state = small_pool(4, 2, 1, 4);
    state.water->surface.waves.waves = {{0.7, 0.3, 0.02, 0}, {0.4, 1.9, 0.01, 1}};
    state.water->absorption = glm::dvec3(0);
    scene::Object block = glass(scene::Shape::box, {0, 0, 0}, 1.5);
    block.size = {0.8, 0.7, 0.6};
    block.transform.rotation = {0.4, 0.2, 0.7};
    state.objects.push_back(block);
    state.objects.push_back(glass(scene::Shape::sphere, {0.2, -1.2, 0.1}, 1.5));
    state.objects.back().radius = 0.3;
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0.6, -1.3, 0.5};
    state.lights = {lamp};
    for (const int object : {1, 2}) {
        const reference::EnergyAccount account =
            account_of(state, {{0, kThrough, object}, {0, kBack, object}});
        expect_energy(account, account.emitted);
        EXPECT_GT(account.arrived, 0.05 * account.emitted);
        EXPECT_GT(account.escaped, 0.05 * account.emitted);
    }
}

TEST(ReferenceGlass, ScatterBelowASlab) {
    // Smoke from the floor to the slab, an eye in it that looks at the floor.
    scene::FrameState state = slab_over_floor(35, {0.5, 1, 2}, 1);
    state.objects[1].size = {6, 0.2, 6};
    state.clip.width = 8;
    state.clip.height = 6;
    state.camera = {};
    state.camera.position = {0, 0.4, 0.2};
    state.camera.target = {0.1, 0, -0.3};
    state.camera.field_of_view = 30 * scene::kDegree;
    scene::Medium smoke = box_of_smoke({0, 0.25, 0}, {6, 0.5, 6});
    smoke.transform.rotation = glm::dvec3(0);
    smoke.phase.type = scene::PhaseType::henyey_greenstein;
    smoke.phase.anisotropy = 0.4;
    state.media = {smoke};
    state.caustics.reference = {0.015, 100};
    VolumeFrame frame(state);
    frame.chains = {{0, kThrough, 1}};
    const LayerResult result = frame.scatter();
    const glm::dvec3 sun = state.lights[0].direction;
    for (int channel = 0; channel < 3; ++channel) {
        const double sigma = smoke.density * smoke.extinction[channel];
        const double across = state.lights[0].irradiance[channel] *
                              slab_transmittance(35, 0.2, 1.5, state.objects[1].material.absorption[channel]);
        const auto exact = [&](const glm::dvec3& origin, const glm::dvec3& way) {
            const double length = origin.y / -way.y, start = (0.5 - origin.y) / -sun.y;
            const double rate = sigma * (1 + way.y / sun.y);
            return smoke.albedo[channel] * sigma * henyey_greenstein(0.4, -dot(sun, way)) * across *
                   std::exp(-sigma * start) * -std::expm1(-rate * length) / rate;
        };
        expect_scatter(result, over_pixels(state, exact), 0.015, channel);
    }
}

TEST(ReferenceGlass, SkinOfDenseSmokeBelowASlab) {
    // A mean free path of a micrometre, seen from the clear air above: albedo p E / (1 + cos ratio).
    scene::FrameState state = slab_over_floor(0, glm::dvec3(0), 1);
    state.objects[1].size = {0.7, 0.2, 0.7};
    state.clip.width = 4;
    state.clip.height = 3;
    state.camera = {};
    state.camera.position = {0, 0.4, 0.2};
    state.camera.target = {0.1, 0.2, -0.1};
    state.camera.field_of_view = 20 * scene::kDegree;
    scene::Medium smoke = box_of_smoke({0, 0.125, 0}, {0.7, 0.25, 0.7});
    smoke.transform.rotation = glm::dvec3(0);
    smoke.density = 1e6;
    smoke.extinction = glm::dvec3(1);
    state.media = {smoke};
    state.caustics.reference = {0.08, 20};
    VolumeFrame frame(state);
    frame.chains = {{0, kThrough, 1}};
    const double across = 2 * slab_transmittance(0, 0.2, 1.5, 0);
    const auto exact = [&](const glm::dvec3&, const glm::dvec3& way) {
        return smoke.albedo.y / (4 * glm::pi<double>()) * across / (1 - way.y);
    };
    expect_scatter(frame.scatter(), over_pixels(state, exact), 0.08, 1);
}

}  // namespace
}  // namespace dapple
