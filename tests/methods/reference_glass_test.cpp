// The brute-force reference follows light through bodies of glass in the air: closed forms of E and S.
#include <gtest/gtest.h>

#include "methods/reference_glass_frame.h"

namespace dapple {
namespace {

using namespace test;

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
            const int column = i % pixels, row = i / pixels;
            const double x = column + 0.5 - 0.5 * pixels, z = row + 0.5 - 0.5 * pixels;
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
