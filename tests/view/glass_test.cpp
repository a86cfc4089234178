#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "rays/shape_mesh.h"
#include "view/camera.h"
#include "view/glass_bodies.h"
#include "view/view_scene.h"

namespace dapple::view {
namespace {

using test::cross_surface;
using test::Crossing;
using test::ViewScene;

constexpr double kGlass = 1.5;
constexpr double kWater = 1.333;
/// Positions and throughputs are found in double and rounded to float once, and stand within 4 m.
constexpr double kFloat = 1e-6;

scene::Material glass(double index = kGlass) {
    scene::Material material;
    material.glass = true;
    material.refractive_index = index;
    material.absorption = {0.5, 1, 2};
    return material;
}

scene::Object& add_glass(ViewScene& scene, scene::Shape shape, const glm::dvec3& position,
                         const glm::dvec3& size = glm::dvec3(1)) {
    scene::Object& body = scene.add(shape, position, size);
    body.material = glass();
    return body;
}

glm::dvec3 absorbed(double distance) {
    return glm::exp(-distance * glass().absorption);
}

struct CameraRay {
    glm::dvec3 origin;
    glm::dvec3 direction;
    glm::dvec3 at_height(double y) const { return origin + (y - origin.y) / direction.y * direction; }
};
CameraRay ray_of(const ViewScene& scene, std::size_t pixel) {
    const auto& state = scene.frame.state;
    const auto width = static_cast<std::size_t>(state.clip.width);
    CameraRay ray{};
    const std::size_t column = pixel % width, row = pixel / width;
    Camera(state.camera, state.clip.width, state.clip.height)
        .ray(glm::dvec2(column, row) + 0.5, ray.origin, ray.direction);
    return ray;
}

void expect_near(const glm::vec3& found, const glm::dvec3& expected, double share = kFloat) {
    EXPECT_LT(length(glm::dvec3(found) - expected), share * std::max(1.0, length(expected)));
}

constexpr std::uint32_t kThroughGlass = kReceiver | kBehindSpecular;

/// Beyond the first split the weaker side of the next one has a branch where it is worth following: with what
/// is dropped after that the branches carry everything.
TEST(Glass, ASlabSeenAtAGrazeHasABranchForEachSide) {
    ViewScene scene(7, 5);
    scene.look_in_parallel({-4, 2.88, 0.5}, {0, 1, 0}, 0.1);  // 65 degrees
    add_glass(scene, scene::Shape::box, {0, 0.8, 0}, {20, 0.4, 20}).material.absorption = glm::dvec3(0);
    scene.add_floor(-1);
    std::array<LayerCounts, kBranches> counts;
    std::array<ReceiverLayer, kBranches> layers;
    for (int branch = 0; branch < kBranches; ++branch) {
        const auto b = static_cast<std::size_t>(branch);
        layers[b] = scene.trace(branch, &counts[b]);
    }
    const double cos_i = -ray_of(scene, 0).direction.y;
    const Crossing in = cross_surface(cos_i, 1, kGlass);
    const double through = in.transmittance, back = 1 - through;
    ASSERT_GT(through * back, kWorthFollowing);
    ASSERT_LT(through * back, kWorthFollowing * kGlass * kGlass)
        << "a share of the pixel, not of what is within";
    EXPECT_EQ(counts[0].split_again_pixels, 35u);
    EXPECT_EQ(counts[1].split_again_pixels, 0u) << "the reflected path meets nothing more";
    EXPECT_EQ(counts[0].dropped_splits, 0u);
    EXPECT_EQ(counts[2].dropped_splits, 35u) << "after two reflections within";
    const std::array<double, kBranches> share{through * through, back, through * back * through, 0};
    for (std::size_t i = 0; i < 35; ++i) {
        double sum = 0;
        for (std::size_t b = 0; b < layers.size(); ++b) {
            expect_near(layers[b].throughput[i], glm::dvec3(share[b]));
            sum += static_cast<double>(layers[b].throughput[i].x);
        }
        EXPECT_NEAR(sum, 1 - through * back * back, 1e-6);
        EXPECT_EQ(layers[0].flags[i], kThroughGlass);
        EXPECT_EQ(layers[2].flags[i], kEnvironment | kBehindSpecular);
        EXPECT_EQ(layers[3].flags[i], 0u);
    }
}

/// A slab moves what is seen through it sideways by t sin(i - t) / cos t and dims it by both crossings; the
/// two factors n^2 cancel.
TEST(Glass, ASlabShiftsTheViewSideways) {
    constexpr double thickness = 0.4;
    for (const bool in_water : {false, true}) {
        ViewScene scene(7, 5);
        const double top = in_water ? -1 : 1, floor = top - 2, outside = in_water ? kWater : 1;
        scene.look_in_parallel({-1, top + 0.5, 0.5}, {0, top, 0}, 0.5);
        add_glass(scene, scene::Shape::box, {0, top - 0.5 * thickness, 0}, {20, thickness, 20});
        scene.add_floor(floor);
        glm::dvec3 extinction(0);
        if (in_water) extinction = scene.fill_flat(40).extinction();
        LayerCounts counts;
        const ReceiverLayer layer = scene.trace(0, &counts);
        EXPECT_EQ(counts.split_pixels, 35u);
        EXPECT_EQ(counts.dropped_splits + counts.split_again_pixels, 35u) << "the reflection on the way out";
        for (std::size_t i = 0; i < 35; ++i) {
            const CameraRay ray = ray_of(scene, i);
            const double cos_i = -ray.direction.y;
            const Crossing in = cross_surface(cos_i, outside, kGlass);
            const Crossing out = cross_surface(in.cos_t, kGlass, outside);
            EXPECT_NEAR(out.cos_t, cos_i, 1e-12);
            const double shift = thickness * std::sin(std::acos(cos_i) - std::acos(in.cos_t)) / in.cos_t;
            // Sideways, in the plane of incidence and off the ray: along the floor 1 / cos i as far.
            const glm::dvec3 level = normalize(ray.direction * glm::dvec3(1, 0, 1));
            const glm::dvec3 expected = ray.at_height(floor) - shift / cos_i * level;
            ASSERT_EQ(layer.flags[i], kThroughGlass | (in_water ? kInWater : 0u));
            expect_near(layer.position[i], expected);
            const double in_medium = (ray.origin.y - top + 2 - thickness) / cos_i;
            expect_near(layer.throughput[i], in.transmittance * out.transmittance *
                                                 absorbed(thickness / in.cos_t) *
                                                 glm::exp(-in_medium * extinction));
        }
        if (in_water) continue;
        const ReceiverLayer reflected = scene.trace(1);
        for (std::size_t i = 0; i < 35; ++i) {
            EXPECT_EQ(reflected.flags[i], kEnvironment | kBehindSpecular);
            const Crossing in = cross_surface(-ray_of(scene, i).direction.y, 1, kGlass);
            expect_near(reflected.throughput[i], glm::dvec3(1 - in.transmittance));
        }
    }
}

/// Light bends once in all, as from air to water; the water's surface is not there within the glass.
TEST(Glass, ThroughABodyThatStraddlesTheSurfaceIntoTheWater) {
    ViewScene scene(7, 5);
    scene.look_in_parallel({-1, 2, 0.5}, {0, 0.25, 0}, 0.5);
    add_glass(scene, scene::Shape::box, {0, 0, 0}, {8, 0.5, 8});
    const scene::Water water = scene.fill_flat(40);
    scene.add_floor(-2);
    const ReceiverLayer layer = scene.trace();
    for (std::size_t i = 0; i < 35; ++i) {
        const CameraRay ray = ray_of(scene, i);
        const Crossing in = cross_surface(-ray.direction.y, 1, kGlass);
        const Crossing out = cross_surface(in.cos_t, kGlass, kWater);
        const glm::dvec3 level = normalize(ray.direction * glm::dvec3(1, 0, 1));
        const auto tangent = [](double cosine) { return std::tan(std::acos(cosine)); };
        const glm::dvec3 expected = ray.at_height(0.25) * glm::dvec3(1, 0, 1) + glm::dvec3(0, -2, 0) +
                                    (0.5 * tangent(in.cos_t) + 1.75 * tangent(out.cos_t)) * level;
        ASSERT_EQ(layer.flags[i], kThroughGlass | kInWater);
        expect_near(layer.position[i], expected);
        expect_near(layer.throughput[i], in.transmittance * out.transmittance / (kWater * kWater) *
                                             absorbed(0.5 / in.cos_t) *
                                             glm::exp(-1.75 / out.cos_t * water.extinction()));
    }
}

/// In by one side above the water, out by the other below it: only the part across the sides bends.
TEST(Glass, InFromTheAirAndOutIntoTheWaterByUprightSides) {
    ViewScene scene(7, 5);
    scene.look_in_parallel({-1.5, 2, 0}, {-0.5, 0.3, 0}, 0.2);
    add_glass(scene, scene::Shape::box, {0, 0, 0}, {1, 4, 8});
    const scene::Water water = scene.fill_flat(40);
    scene.add_floor(-1.5);
    const ReceiverLayer layer = scene.trace();
    for (std::size_t i = 0; i < 35; ++i) {
        const CameraRay ray = ray_of(scene, i);
        const Crossing in = cross_surface(ray.direction.x, 1, kGlass);
        const Crossing out = cross_surface(in.cos_t, kGlass, kWater);
        const glm::dvec3 along = ray.direction * glm::dvec3(0, 1, 1);
        const glm::dvec3 inside = along / kGlass + glm::dvec3(in.cos_t, 0, 0);
        const glm::dvec3 beyond = along / kWater + glm::dvec3(out.cos_t, 0, 0);
        const glm::dvec3 entry = ray.origin + (-0.5 - ray.origin.x) / ray.direction.x * ray.direction;
        const glm::dvec3 exit = entry + inside / inside.x;
        ASSERT_GT(entry.y, 0);
        ASSERT_LT(exit.y, 0);
        const double rest = (-1.5 - exit.y) / beyond.y;
        ASSERT_EQ(layer.flags[i], kThroughGlass | kInWater);
        expect_near(layer.position[i], exit + rest * beyond);
        expect_near(layer.throughput[i], in.transmittance * out.transmittance / (kWater * kWater) *
                                             absorbed(1 / inside.x) * glm::exp(-rest * water.extinction()));
    }
}

/// Where a face lies in the surface, the body counts: air above it and water below it, no film of water.
TEST(Glass, AFaceInTheSurfaceOfTheWater) {
    for (const double middle : {0.25, -0.25}) {
        for (const double from : {2.0, -2.0}) {
            ViewScene scene(7, 5);
            scene.look_in_parallel({-1, from, 0.5}, {0, 0, 0}, 0.5);
            add_glass(scene, scene::Shape::box, {0, middle, 0}, {8, 0.5, 8});
            scene.fill_flat(40).absorption = {0, 0, 0};
            scene.add_floor(-from);
            const double n = from > 0 ? 1 : kWater, to = from > 0 ? kWater : 1;
            const ReceiverLayer layer = scene.trace();
            for (std::size_t i = 0; i < 35; ++i) {
                const double cos_i = std::abs(ray_of(scene, i).direction.y);
                const Crossing in = cross_surface(cos_i, n, kGlass);
                const Crossing out = cross_surface(in.cos_t, kGlass, to);
                ASSERT_EQ(layer.flags[i], kThroughGlass | (from > 0 ? kInWater : 0u));
                expect_near(layer.throughput[i], in.transmittance * out.transmittance * n * n / (to * to) *
                                                     absorbed(0.5 / in.cos_t));
            }
        }
    }
}

/// Both ways through a sphere's surface turn a ray by i - t, towards the middle.
TEST(Glass, ABallTurnsRaysByTwiceTheirRefraction) {
    constexpr double radius = 0.5, wall = -3;
    ViewScene scene(16, 16);
    scene.look_in_parallel({0, 0, 2}, {0, 0, 0}, 0.9);
    add_glass(scene, scene::Shape::sphere, {0, 0, 0}).radius = radius;
    scene.add(scene::Shape::box, {0, 0, wall - 0.5}, {200, 200, 1});
    const ReceiverLayer layer = scene.trace();
    std::size_t through = 0;
    for (std::size_t i = 0; i < 256; ++i) {
        const CameraRay ray = ray_of(scene, i);
        const double b = length(glm::dvec2(ray.origin));
        if (b > 0.98 * radius) continue;  // farther out a float's rounding of the hit shows
        const double theta_i = std::asin(b / radius), theta_t = std::asin(b / radius / kGlass);
        const double turn = 2 * (theta_i - theta_t);
        // In the plane of incidence: the exit stands theta_i + (pi - 2 theta_t) from the entry at theta_i,
        // both seen from the middle, off the axis to the camera.
        const double place = theta_i + (std::acos(-1.0) - 2 * theta_t);
        const glm::dvec2 exit = radius * glm::dvec2(std::sin(place), std::cos(place));  // outwards, to camera
        const glm::dvec2 direction(-std::sin(turn), -std::cos(turn));
        const glm::dvec2 end = exit + (wall - exit.y) / direction.y * direction;
        const glm::dvec3 outward = glm::dvec3(ray.origin.x, ray.origin.y, 0) / b;
        const Crossing in = cross_surface(std::cos(theta_i), 1, kGlass);
        const Crossing out = cross_surface(std::cos(theta_t), kGlass, 1);
        ASSERT_EQ(layer.flags[i], kThroughGlass);
        expect_near(layer.position[i], glm::dvec3(0, 0, wall) + end.x * outward, 1e-5);
        expect_near(layer.throughput[i],
                    in.transmittance * out.transmittance * absorbed(2 * radius * std::cos(theta_t)), 1e-5);
        ++through;
    }
    EXPECT_GT(through, 150u);
}

/// From a face of a box of index 1.5 the next face is met at more than 48 degrees: beyond the critical 41.8.
TEST(Glass, AdjacentFacesOfABoxReflectTotally) {
    ViewScene scene(7, 5);
    scene.look_in_parallel({1.2, 0.4, 2}, {-0.3, 0, 0.5}, 0.05);
    add_glass(scene, scene::Shape::box, {0, 0, 0}, {1, 8, 1});
    scene.add(scene::Shape::box, {0, 0, -3.5}, {200, 200, 1});
    for (const bool mirrored : {false, true}) {
        scene::Object& body = scene.frame.state.objects[0];
        if (mirrored) {  // the same body as a mesh that its transform turns inside out
            body.shape = scene::Shape::mesh;
            body.transform.scale = {-1, 1, 1};
            scene.frame.object_meshes = {
                std::make_shared<const scene::TriangleMesh>(rays::box_mesh(body.size)), nullptr};
        }
        const ReceiverLayer layer = scene.trace();
        std::size_t turned = 0;
        for (std::size_t i = 0; i < 35; ++i) {
            const CameraRay ray = ray_of(scene, i);
            const Crossing in = cross_surface(-ray.direction.z, 1, kGlass);
            const glm::dvec3 along = ray.direction * glm::dvec3(1, 1, 0);
            const glm::dvec3 inside = along / kGlass + glm::dvec3(0, 0, -in.cos_t);
            const glm::dvec3 entry = ray.origin + (0.5 - ray.origin.z) / ray.direction.z * ray.direction;
            const double whole = -1 / inside.z;  // to the back
            glm::dvec3 exit = entry + whole * inside, out = ray.direction;
            if (exit.x < -0.5) {
                exit.x = -1 - exit.x;
                out.x = -out.x;
                ++turned;
            }
            const glm::dvec3 expected = exit + (-3 - exit.z) / out.z * out;
            ASSERT_EQ(layer.flags[i], kThroughGlass);
            expect_near(layer.position[i], expected, 3e-6);  // 3.5 m from a few roundings of the ray's start
            const Crossing back = cross_surface(in.cos_t, kGlass, 1);
            expect_near(layer.throughput[i], in.transmittance * back.transmittance * absorbed(whole));
        }
        EXPECT_GT(turned, 10u);
    }
}

TEST(Glass, OfTheIndexAroundItCannotBeSeen) {
    for (const bool in_water : {false, true}) {
        ViewScene scene(24, 18);
        const double height = in_water ? -2 : 2;
        scene.look({0, height, 2}, {0.1, height - 0.2, 0});
        if (in_water) scene.fill_flat(40).absorption = {0, 0, 0};
        scene.add_floor(height - 1);
        const ReceiverLayer without = scene.trace();
        scene::Object& ball = add_glass(scene, scene::Shape::sphere, {0, height, 0});
        ball.material = glass(in_water ? kWater : 1);
        ball.material.absorption = {0, 0, 0};
        LayerCounts counts;
        const ReceiverLayer with = scene.trace(0, &counts);
        EXPECT_EQ(counts.split_pixels, 0u);
        std::size_t through = 0;
        for (std::size_t i = 0; i < with.pixels(); ++i) {
            if (!(with.flags[i] & kBehindSpecular)) continue;
            ++through;
            EXPECT_EQ(with.flags[i], without.flags[i] | kBehindSpecular);
            // The floor is met at down to 3 degrees, where roundings of the direction reach twenty times as
            // far.
            if (with.flags[i] & kReceiver)
                expect_near(with.position[i], glm::dvec3(without.position[i]), 2e-6);
            expect_near(with.throughput[i], glm::dvec3(without.throughput[i]));
            expect_near(with.footprint_u[i], glm::dvec3(without.footprint_u[i]), 1e-5);
        }
        EXPECT_GT(through, 40u);
    }
}

TEST(Glass, ACameraInIt) {
    for (const bool parallel : {false, true}) {
        ViewScene scene(6, 6);
        scene.look({0, 0, 0}, {0, -1, 0.001});
        if (parallel) scene.look_in_parallel({0, 0, 0}, {0, -1, 0}, 0.01);
        scene.camera().up = {1, 0, 0};
        add_glass(scene, scene::Shape::sphere, {0, 0, 0}).radius = 0.5;
        scene.fill_flat(40).absorption = {0, 0, 0};
        scene.add_floor(-2);
        const ReceiverLayer layer = scene.trace();
        const double transmittance = cross_surface(1, kGlass, kWater).transmittance;
        for (std::size_t i = 0; i < 36; ++i) {
            ASSERT_EQ(layer.flags[i], kThroughGlass | kInWater);
            // From the middle rays meet the sphere at right angles. The parallel ones nearly: 7 mm off.
            const CameraRay ray = ray_of(scene, i);
            if (!parallel) expect_near(layer.position[i], ray.at_height(-2));
            expect_near(layer.throughput[i],
                        transmittance * kGlass * kGlass / (kWater * kWater) * absorbed(0.5),
                        parallel ? 1e-4 : kFloat);
        }
    }
}

TEST(Glass, AReceiverInIt) {
    ViewScene scene(6, 6);
    scene.look_in_parallel({-1, 2, 0}, {0, 0, 0}, 0.5);
    add_glass(scene, scene::Shape::box, {0, 0, 0}, {8, 1, 8});
    scene.add_floor(-0.3);
    scene.fill_flat(40);
    const ReceiverLayer layer = scene.trace();
    for (std::size_t i = 0; i < 36; ++i) {
        const Crossing in = cross_surface(-ray_of(scene, i).direction.y, 1, kGlass);
        ASSERT_EQ(layer.flags[i], kThroughGlass | kInGlass);
        expect_near(layer.throughput[i], in.transmittance / (kGlass * kGlass) * absorbed(0.8 / in.cos_t));
    }
}

TEST(Glass, HoldsNoMedium) {
    ViewScene scene(6, 6);
    scene.look_in_parallel({-1, -0.5, 0.5}, {0, -1, 0}, 0.5);
    scene::Water& water = scene.fill_flat(40);
    water.absorption = {0.35, 0.06, 0.03};
    water.scattering = {0.05, 0.1, 0.2};
    add_glass(scene, scene::Shape::box, {0, -1.5, 0}, {8, 0.4, 8});
    scene.add_floor(-3);
    LayerCounts counts;
    SegmentLayer segments;
    const rays::RayScene rays(scene.frame);
    const ReceiverLayer layer = trace_layer(scene.frame, rays, {0, 0}, counts, &segments);
    ASSERT_EQ(segments.segments(), 72u);
    for (std::size_t i = 0; i < 36; ++i) {
        const CameraRay ray = ray_of(scene, i);
        const double cos_i = -ray.direction.y;
        const std::size_t near = 2 * i, far = near + 1;
        EXPECT_EQ(segments.primary[near], 1);
        EXPECT_EQ(segments.primary[far], 0);
        EXPECT_NEAR(segments.length[near], (ray.origin.y + 1.3) / cos_i, kFloat);
        EXPECT_NEAR(segments.length[far], 1.3 / cos_i, kFloat);
        EXPECT_NEAR(segments.origin[far].y, -1.7, kFloat);
        EXPECT_EQ(segments.in_water[far], 1);
        expect_near(segments.throughput[far] * glm::vec3(glm::exp(-1.3 / cos_i * water.extinction())),
                    glm::dvec3(layer.throughput[i]));
    }
}

TEST(Glass, BodiesHoldPoints) {
    ViewScene scene(1, 1);
    scene.frame.origin = {3, 0, -2};
    add_glass(scene, scene::Shape::sphere, {3, 1, -2}).radius = 0.5;
    scene.add(scene::Shape::sphere, {0, 5, 0}).radius = 100;  // of no glass
    scene::Object& box = add_glass(scene, scene::Shape::box, {5, 1, -2}, {1, 0.2, 1});
    box.transform.rotation = {0, 0, 0.25 * std::acos(-1.0)};
    scene::Object& mesh = add_glass(scene, scene::Shape::mesh, {8, 1, -2});
    mesh.transform.scale = {-1, 2, 1};
    scene.frame.object_meshes.assign(4, nullptr);
    scene.frame.object_meshes[3] = std::make_shared<const scene::TriangleMesh>(rays::box_mesh({1, 1, 1}));
    const GlassBodies bodies(scene.frame);
    EXPECT_EQ(bodies.at({0.3, 1.3, 0.2}), 0u);
    EXPECT_EQ(bodies.at({0.3, 1.3, 0.3}), kNoBody);
    EXPECT_EQ(bodies.at({2.3, 1.3, 0}), 2u) << "along the turned box";
    EXPECT_EQ(bodies.at({2.3, 0.7, 0}), kNoBody);
    EXPECT_EQ(bodies.at({5.4, 1.9, 0.4}), 3u);
    EXPECT_EQ(bodies.at({5.6, 1.9, 0.4}), kNoBody) << "outside its bounds";
    EXPECT_EQ(bodies.at({10, 10, 10}), kNoBody);
}

}  // namespace
}  // namespace dapple::view
