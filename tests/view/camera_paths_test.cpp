#include "view/camera_paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/parallel.h"
#include "view/camera.h"
#include "view/view_scene.h"

namespace dapple::view {
namespace {

using test::ViewScene;

constexpr double kIndex = 1.333;
/// Throughputs are products of double factors, rounded to float once.
constexpr double kFloat = 1e-6;

void expect_color(const glm::vec3& found, const glm::dvec3& expected) {
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], expected[c], kFloat * std::max(1e-3, std::abs(expected[c])));
}

glm::dvec3 absorbed(const scene::Water& water, double distance) {
    return glm::exp(-distance * water.extinction());
}

struct CameraRay {
    glm::dvec3 origin;
    glm::dvec3 direction;
};
CameraRay ray_of(const ViewScene& scene, int x, int y) {
    const auto& state = scene.frame.state;
    CameraRay ray{};
    Camera(state.camera, state.clip.width, state.clip.height)
        .ray({x + 0.5, y + 0.5}, ray.origin, ray.direction);
    return ray;
}

std::size_t index_of(const ReceiverLayer& layer, int x, int y) {
    return static_cast<std::size_t>(y * layer.width + x);
}

TEST(CameraPaths, ReceiversInAirAreWhereTheCameraProjectsThem) {
    ViewScene scene(37, 21);  // not a multiple of the tile
    scene.frame.origin = {12, 0, -7};
    scene.look({1, 2, 3}, {0, 0, 0});
    scene.add_floor(0);
    const Camera camera(scene.camera(), 37, 21);
    const ReceiverLayer layer = scene.trace();
    for (int y = 0; y < 21; ++y) {
        for (int x = 0; x < 37; ++x) {
            const std::size_t i = index_of(layer, x, y);
            ASSERT_EQ(layer.flags[i], kReceiver);
            const glm::dvec3 world = glm::dvec3(layer.position[i]) + scene.frame.origin;
            EXPECT_NEAR(world.y, 0, 1e-12) << "on the floor exactly, since the origin is at its height";
            const glm::dvec3 pixel = camera.project(world);
            EXPECT_NEAR(pixel.x, x + 0.5, 1e-3);  // position in float: 2^-24 * 14 m over 12 mm a pixel
            EXPECT_NEAR(pixel.y, y + 0.5, 1e-3);
            EXPECT_NEAR(layer.depth[i], pixel.z, 1e-5);
            EXPECT_EQ(layer.throughput[i], glm::vec3(1));
            EXPECT_EQ(layer.geometric_normal[i], glm::vec3(0, 1, 0));
        }
    }
}

TEST(CameraPaths, MissesSeeTheEnvironmentInAirAndNothingInWater) {
    ViewScene scene(4, 4);
    scene.look({0, 3, 0}, {10, 4, 0});
    ReceiverLayer layer = scene.trace();
    EXPECT_EQ(layer.flags[5], kEnvironment);
    EXPECT_EQ(layer.throughput[5], glm::vec3(1));
    EXPECT_EQ(layer.depth[5], std::numeric_limits<float>::infinity());

    scene.fill_flat(10);
    scene.look({0, -3, 0}, {10, -8, 0});
    layer = scene.trace();
    EXPECT_EQ(layer.flags[5], 0u);
    EXPECT_EQ(layer.throughput[5], glm::vec3(0));
}

TEST(CameraPaths, SnellsWindow) {
    ViewScene scene(64, 64);
    scene.look({0.3, -2, 0.2}, {0.3, 0, 0.2}, 2.2);  // to 62 degrees and beyond: the window ends at 48.6
    const scene::Water water = scene.fill_flat(3);   // the rest goes on as the plane of open water
    scene.add_floor(-5, 1000);
    LayerCounts counts;
    const ReceiverLayer layer = scene.trace(0, &counts);
    const ReceiverLayer reflected = scene.trace(1);
    std::size_t inside = 0;
    std::size_t on_rest_plane = 0;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            const std::size_t i = index_of(layer, x, y);
            const glm::dvec3 direction = ray_of(scene, x, y).direction;
            const double distance = 2 / direction.y;
            const double back = 5 / direction.y;
            const test::Crossing crossing = test::cross_surface(direction.y, kIndex, 1);
            EXPECT_NEAR(layer.depth[i], 2, 1e-6);
            on_rest_plane += std::abs(0.3 + distance * direction.x) > 1.5 ? 1 : 0;
            if (crossing.cos_t >= 0) {
                ++inside;
                ASSERT_EQ(layer.flags[i], kEnvironment | kBehindSpecular);
                expect_color(layer.throughput[i],
                             kIndex * kIndex * crossing.transmittance * absorbed(water, distance));
                ASSERT_EQ(reflected.flags[i], kReceiver | kInWater | kBehindSpecular);
                expect_color(reflected.throughput[i],
                             (1 - crossing.transmittance) * absorbed(water, distance + back));
            } else {
                ASSERT_EQ(layer.flags[i], kReceiver | kInWater | kBehindSpecular);
                expect_color(layer.throughput[i], absorbed(water, distance + back));
                const glm::dvec3 expected =
                    glm::dvec3(0.3, 0, 0.2) + (distance + back) * direction * glm::dvec3(1, 0, 1);
                EXPECT_NEAR(layer.position[i].x, expected.x, 1e-5 * (distance + back));
                EXPECT_NEAR(layer.position[i].z, expected.z, 1e-5 * (distance + back));
                EXPECT_EQ(reflected.flags[i], 0u);
                EXPECT_EQ(reflected.throughput[i], glm::vec3(0));
            }
        }
    }
    EXPECT_EQ(counts.split_pixels, inside);
    EXPECT_GT(inside, 500u);
    EXPECT_LT(inside, 3500u);
    EXPECT_GT(on_rest_plane, 500u);
}

TEST(CameraPaths, LookingIntoTheWaterDividesRadianceByTheIndexSquared) {
    ViewScene scene(16, 16);
    scene.look_in_parallel({-2, 3, 0}, {0, 0, 0}, 1);
    const scene::Water water = scene.fill_flat(6);
    scene.add_floor(-2);
    const ReceiverLayer through = scene.trace(0);
    const ReceiverLayer mirrored = scene.trace(1);
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
            const std::size_t i = index_of(through, x, y);
            const CameraRay ray = ray_of(scene, x, y);
            const double cos_i = -ray.direction.y;
            const test::Crossing crossing = test::cross_surface(cos_i, 1, kIndex);
            ASSERT_EQ(through.flags[i], kReceiver | kInWater | kBehindSpecular);
            const double distance = 2 / crossing.cos_t;
            expect_color(through.throughput[i],
                         crossing.transmittance / (kIndex * kIndex) * absorbed(water, distance));
            const glm::dvec3 entry = ray.origin + ray.origin.y / cos_i * ray.direction;
            const double tangent_t = std::sqrt(1 / (crossing.cos_t * crossing.cos_t) - 1);
            const glm::dvec3 ahead = normalize(ray.direction * glm::dvec3(1, 0, 1));
            const glm::dvec3 expected = entry + 2 * tangent_t * ahead - glm::dvec3(0, 2, 0);
            EXPECT_LT(length(glm::dvec3(through.position[i]) - expected), 1e-6);
            EXPECT_EQ(through.geometric_normal[i], glm::vec3(0, 1, 0));

            ASSERT_EQ(mirrored.flags[i], kEnvironment | kBehindSpecular);
            expect_color(mirrored.throughput[i], glm::dvec3(1 - crossing.transmittance));
            // What the two branches carry is everything, once radiance is scaled back and absorption undone.
            const glm::dvec3 total =
                glm::dvec3(through.throughput[i]) * kIndex * kIndex / absorbed(water, distance) +
                glm::dvec3(mirrored.throughput[i]);
            expect_color(glm::vec3(total), glm::dvec3(1));
        }
    }
}

TEST(CameraPaths, EqualIndicesDoNotSplit) {
    ViewScene scene(4, 4);
    scene.look({0, 3, 1}, {0, 0, 0});
    scene.fill_flat(6).refractive_index = 1;
    scene.frame.state.water->absorption = {0, 0, 0};
    scene.add_floor(-2);
    LayerCounts counts;
    const ReceiverLayer layer = scene.trace(0, &counts);
    EXPECT_EQ(counts.split_pixels, 0u);
    EXPECT_EQ(layer.throughput[5], glm::vec3(1));
    const CameraRay ray = ray_of(scene, 1, 1);
    const glm::dvec3 straight = ray.origin - (ray.origin.y + 2) / ray.direction.y * ray.direction;
    EXPECT_LT(length(glm::dvec3(layer.position[5]) - straight), 1e-6);
}

TEST(CameraPaths, MirrorThenWaterIsTheUnfoldedPath) {
    ViewScene scene(9, 9);
    scene.look({-3, 2, 0}, {0, 1.5, 0}, 0.2);
    // A mirror in the plane x = 0 that faces -x.
    scene::Object& mirror = scene.add(scene::Shape::plane, {0, 1.5, 0}, {20, 1, 20});
    mirror.transform.rotation = {0, 0, M_PI / 2};
    mirror.material.mirror = true;
    mirror.material.color = {0.9, 0.8, 0.7};
    scene.add_floor(-2);
    scene.fill_flat(40);
    const ReceiverLayer layer = scene.trace();

    ViewScene unfolded = scene;
    unfolded.frame.state.objects[0].transform.position = {0, 500, 0};
    const ReceiverLayer straight = unfolded.trace();
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        ASSERT_EQ(layer.flags[i], kReceiver | kInWater | kBehindSpecular);
        const glm::vec3 image(-straight.position[i].x, straight.position[i].y, straight.position[i].z);
        EXPECT_LT(length(layer.position[i] - image), 1e-5f);
        expect_color(layer.throughput[i], glm::dvec3(straight.throughput[i]) * glm::dvec3(0.9, 0.8, 0.7));
        EXPECT_NEAR(length(layer.footprint_u[i]), length(straight.footprint_u[i]),
                    1e-5 * length(straight.footprint_u[i]));
        EXPECT_LT(layer.depth[i], 3.2f) << "the mirror is the first surface";
    }
}

TEST(CameraPaths, FacingMirrorsAreCutAndCounted) {
    ViewScene scene(3, 3);
    scene.look({0, 0, 0}, {1, 0.01, 0}, 0.01);
    for (const double x : {-1.0, 1.0}) {
        scene::Object& mirror = scene.add(scene::Shape::plane, {x, 0, 0}, {50, 1, 50});
        mirror.transform.rotation = {0, 0, M_PI / 2};
        mirror.material.mirror = true;
        mirror.material.color = {1, 1, 1};
    }
    LayerCounts counts;
    const ReceiverLayer layer = scene.trace(0, &counts);
    EXPECT_EQ(counts.longest_chain_hits, 9u);
    for (std::size_t i = 0; i < 9; ++i) {
        EXPECT_EQ(layer.flags[i], 0u);
        EXPECT_EQ(layer.throughput[i], glm::vec3(0));
    }
}

TEST(CameraPaths, LaterSplitsFollowTheStrongerSideAndCountTheRest) {
    // Into the water, off a level mirror on its floor, and out again: the second crossing keeps T.
    ViewScene scene(8, 8);
    scene.look_in_parallel({-1, 3, 0}, {0, 0, 0}, 0.5);
    const scene::Water water = scene.fill_flat(40);
    scene::Object& mirror = scene.add_floor(-1);
    mirror.material.mirror = true;
    mirror.material.color = {1, 1, 1};
    LayerCounts counts;
    const ReceiverLayer layer = scene.trace(0, &counts);
    const double cos_i = -ray_of(scene, 0, 0).direction.y;
    const test::Crossing crossing = test::cross_surface(cos_i, 1, kIndex);
    const glm::dvec3 expected =
        crossing.transmittance * crossing.transmittance * absorbed(water, 2 / crossing.cos_t);
    EXPECT_EQ(counts.dropped_splits, 64u);
    const glm::dvec3 inside = crossing.transmittance * absorbed(water, 2 / crossing.cos_t);
    const double dropped = (1 - crossing.transmittance) * (inside.x + inside.y + inside.z) / 3;
    EXPECT_NEAR(counts.dropped_weight, 64 * dropped, 1e-6 * 64 * dropped);
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        ASSERT_EQ(layer.flags[i], kEnvironment | kBehindSpecular);
        expect_color(layer.throughput[i], expected);
    }
}

TEST(CameraPaths, CameraInWater) {
    ViewScene scene(4, 4);
    EXPECT_FALSE(camera_in_water(scene.frame));
    scene.fill(test::wavy_water(4, 64), 4, scene::ExtentKind::pool);
    const auto at = [&](double x, double y, double z) {
        scene.camera().position = {x, y, z};
        return camera_in_water(scene.frame);
    };
    const double crest = M_PI / 6;  // sin(3 x) = 1: 5 cm high
    EXPECT_TRUE(at(crest, 0.049, 0));
    EXPECT_FALSE(at(crest, 0.051, 0));
    EXPECT_TRUE(at(-crest, -0.051, 0));
    EXPECT_FALSE(at(-crest, -0.049, 0));
    EXPECT_FALSE(at(3, -1, 0)) << "beside the pool";
    scene.frame.state.water->extent.kind = scene::ExtentKind::open_water;
    EXPECT_TRUE(at(3, -1, 0)) << "the sea goes on";
    EXPECT_FALSE(at(3, 0.01, 0));
    EXPECT_FALSE(at(crest, 0.051, 0));
}

/// What the surface itself, and what is nearer to it than floats can tell, counts as: water.
TEST(CameraPaths, ACameraAtTheSurfaceIsUnderIt) {
    for (const bool parallel : {false, true}) {
        for (const bool beside : {false, true}) {
            for (const double off : {0.0, 1e-12, -1e-12, 1e-8, -1e-8, 2e-7, -2e-7}) {
                ViewScene scene(4, 4);
                scene.fill(test::wavy_water(4, 64), 4);
                scene.add_floor(-2, 40);
                // On the mesh as it is, not on the wave that it stands for: at a vertex.
                const double x = beside ? 9 : scene.frame.water->mesh.positions[32 * 65 + 40].x;
                const double y = (beside ? 0 : scene.frame.water->mesh.positions[32 * 65 + 40].y) + off;
                const auto look = [&](double way) {
                    if (parallel)  // the vertex only: its neighbours are higher or lower
                        scene.look_in_parallel({x, y, 0}, {x, y + way, 0}, 1e-7);
                    else
                        scene.look({x, y, 0}, {x, y + way, 0});
                    scene.camera().up = {0, 0, 1};
                    return scene.trace();
                };
                ASSERT_LT(std::abs(y), 0.051);
                SCOPED_TRACE(testing::Message() << parallel << beside << " " << off);
                const ReceiverLayer down = look(-1);
                EXPECT_TRUE(camera_in_water(scene.frame));
                for (const std::uint32_t flags : down.flags) EXPECT_EQ(flags, kReceiver | kInWater);
                const ReceiverLayer up = look(1);
                for (const std::uint32_t flags : up.flags) EXPECT_EQ(flags, kEnvironment | kBehindSpecular);
            }
        }
    }
}

TEST(CameraPaths, AnOrthographicCameraMayStandInWaterAndAirAtOnce) {
    // Level, 4 m high, at the waterline: air in the upper half and water in the lower, also beside the patch.
    for (const double z : {0.0, 40.0}) {
        for (const double middle : {0.3, -0.3}) {
            ViewScene scene(4, 40);
            scene.fill(test::wavy_water(4, 64), 4);
            scene.frame.state.water->absorption = {0.5, 0.5, 0.5};
            scene.add(scene::Shape::box, {0, 0, z - 20}, {40, 40, 2});
            scene.look_in_parallel({0, middle, z}, {0, middle, z - 1}, 4);
            const ReceiverLayer layer = scene.trace();
            for (std::size_t i = 0; i < layer.pixels(); ++i) {
                const std::size_t row = i / 4;
                const double y = middle + 2 - (static_cast<double>(row) + 0.5) / 10;
                if (std::abs(y) < 0.06) continue;  // the waves
                ASSERT_EQ(layer.flags[i], y < 0 ? kReceiver | kInWater : +kReceiver) << y;
                ASSERT_NEAR(layer.throughput[i].x, y < 0 ? std::exp(-0.5 * 19) : 1, 1e-9) << y;
            }
        }
    }
}

TEST(CameraPaths, MediaDimWhatIsSeenThroughThem) {
    // A slab of fog across the surface of flat water, 0.3 m of it above and 0.2 m below, all of it dimming by
    // scattering as well as by absorption; a camera above looks at the floor, and at the sky.
    ViewScene scene(9, 9);
    scene.frame.origin = {3, 0, -2};
    scene::Medium fog;
    fog.type = scene::MediumType::box;
    fog.size = {1000, 0.5, 1000};
    fog.transform.position = {0, 0.05, 0};
    fog.extinction = {0.1, 0.5, 2};
    fog.density = 0.5;
    scene.frame.state.media.push_back(fog);
    scene::Water& water = scene.fill_flat(200);
    water.absorption = {0.1, 0.05, 0.02};
    water.scattering = {0.3, 0.2, 0.1};
    scene.add_floor(-1.5);
    scene.look({1, 1, 2}, {1.2, -1, 2.3}, 0.5);
    const ReceiverLayer down = scene.trace();
    for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < 9; ++x) {
            const std::size_t i = index_of(down, x, y);
            ASSERT_EQ(down.flags[i], kReceiver | kInWater | kBehindSpecular);
            const double cos_i = -ray_of(scene, x, y).direction.y;
            const test::Crossing crossing = test::cross_surface(cos_i, 1, kIndex);
            const glm::dvec3 dimmed = glm::exp(-(0.3 / cos_i + 0.2 / crossing.cos_t) * 0.5 * fog.extinction) *
                                      absorbed(water, 1.5 / crossing.cos_t);
            expect_color(down.throughput[i], crossing.transmittance / (kIndex * kIndex) * dimmed);
        }
    }
    scene.look({1, -0.2, 2}, {1.3, 10, 2.2}, 0.3);  // from the fog's lower face up into the air
    const ReceiverLayer up = scene.trace();
    for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < 9; ++x) {
            const std::size_t i = index_of(up, x, y);
            ASSERT_EQ(up.flags[i], kEnvironment | kBehindSpecular);
            const double cos_i = ray_of(scene, x, y).direction.y;
            const test::Crossing crossing = test::cross_surface(cos_i, kIndex, 1);
            const glm::dvec3 dimmed = glm::exp(-(0.2 / cos_i + 0.3 / crossing.cos_t) * 0.5 * fog.extinction) *
                                      absorbed(water, 0.2 / cos_i);
            expect_color(up.throughput[i], crossing.transmittance * kIndex * kIndex * dimmed);
        }
    }
}

TEST(CameraPaths, BoxesAndSpheresHaveOutwardNormalsAndTexture) {
    ViewScene scene(32, 32);
    scene.look({0, 0, 5}, {0, 0, 0}, 0.3);
    scene::Object& box = scene.add(scene::Shape::box, {-0.4, 0, 0}, {0.6, 0.6, 0.6});
    box.material.texture_size = 0.25;
    scene::Object& ball = scene.add(scene::Shape::sphere, {0.4, 0, 0});
    ball.radius = 0.3;
    ball.material.texture_size = 0.5;
    const ReceiverLayer layer = scene.trace();
    std::size_t on_box = 0;
    std::size_t on_ball = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        if (!(layer.flags[i] & kReceiver)) continue;
        const glm::dvec3 p(layer.position[i]);
        const double pixel = length(glm::dvec3(layer.footprint_u[i]));
        if (layer.object[i] == 0) {
            if (p.z < 0.2999) continue;  // a side
            ++on_box;
            EXPECT_EQ(layer.geometric_normal[i], glm::vec3(0, 0, 1));
            EXPECT_EQ(layer.shading_normal[i], glm::vec3(0, 0, 1));
            EXPECT_NEAR(layer.uv[i].x, (p.x + 0.4) / 0.25, 1e-5);
            EXPECT_NEAR(layer.uv[i].y, p.y / 0.25, 1e-5);
            EXPECT_NEAR(layer.uv_width[i], pixel / 0.25, 0.01 * pixel / 0.25);
        } else {
            ++on_ball;
            const glm::dvec3 local = (p - glm::dvec3(0.4, 0, 0)) / 0.3;
            EXPECT_LT(length(glm::dvec3(layer.geometric_normal[i]) - local), 1e-5);
            EXPECT_NEAR(length(local), 1, 1e-6);
            EXPECT_NEAR(layer.uv[i].x, std::atan2(local.z, local.x) * 0.3 / 0.5, 1e-5);
            EXPECT_NEAR(layer.uv[i].y, std::asin(local.y) * 0.3 / 0.5, 1e-4);
        }
    }
    EXPECT_GT(on_box, 50u);
    EXPECT_GT(on_ball, 50u);
}

TEST(CameraPaths, MeshesInterpolateNormalsAndTexture) {
    ViewScene scene(8, 8);
    scene.look_in_parallel({0.25, 2, 0.25}, {0.25, 0, 0.25}, 0.4);
    scene.add(scene::Shape::mesh, {0, 0, 0});
    auto mesh = std::make_shared<scene::TriangleMesh>();
    mesh->positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}};
    mesh->normals = {{0, 1, 0}, {0, 1, 0}, normalize(glm::dvec3(1, 2, 0))};
    mesh->uv = {{0, 0}, {0, 2}, {3, 0}};
    mesh->triangles = {{0, 1, 2}};
    scene.frame.object_meshes = {mesh};
    for (const double scale : {1.0, -1.0}) {  // turned inside out it is seen at -x, still from outside
        scene.frame.state.objects[0].transform.scale = {scale, 1, 1};
        scene.look_in_parallel({scale * 0.25, 2, 0.25}, {scale * 0.25, 0, 0.25}, 0.4);
        const ReceiverLayer layer = scene.trace();
        for (std::size_t i = 0; i < layer.pixels(); ++i) {
            ASSERT_EQ(layer.flags[i], kReceiver);
            const glm::dvec3 p(layer.position[i]);
            const double x = scale * p.x;
            EXPECT_NEAR(layer.uv[i].x, 3 * x, 1e-6);
            EXPECT_NEAR(layer.uv[i].y, 2 * p.z, 1e-6);
            const glm::dvec3 tilted = normalize(glm::dvec3(scale * 1, 2, 0));
            const glm::dvec3 normal = normalize((1 - x) * glm::dvec3(0, 1, 0) + x * tilted);
            EXPECT_LT(length(glm::dvec3(layer.shading_normal[i]) - normal), 1e-6);
            EXPECT_EQ(layer.geometric_normal[i], glm::vec3(0, 1, 0));
            EXPECT_NEAR(layer.uv_width[i], 3 * 0.05, 1e-6);  // a pixel is 5 cm
        }
    }
}

TEST(CameraPaths, OfOnlyThePixelsThatSplitAreTheSame) {
    ViewScene scene(64, 48);
    scene.look({0, 0.6, 2.5}, {0, 0.3, 0});
    scene.fill(test::wavy_water(6, 60), 6);
    scene.add_floor(-2);
    scene::Object& ball = scene.add(scene::Shape::sphere, {0, 0.5, 0});
    ball.radius = 0.4;
    ball.material.glass = true;
    const rays::RayScene rays(scene.frame);
    LayerCounts counts;
    std::array<std::vector<std::uint8_t>, kBranches> splits;
    splits[0] = scene.trace(0, &counts).splits;
    EXPECT_EQ(counts.paths, 64u * 48u);
    for (const int branch : {1, 2, 3}) {
        const auto b = static_cast<std::size_t>(branch);
        const ReceiverLayer all = scene.trace(branch);
        LayerRequest request{0, branch};
        request.only = branch == 1 ? kSplits : kSplitsAgain;
        request.splits = splits[branch == 3 ? 1 : 0];
        const ReceiverLayer some = trace_layer(scene.frame, rays, request, counts);
        splits[b] = some.splits;
        const auto asked = std::count_if(request.splits.begin(), request.splits.end(),
                                         [&](std::uint8_t s) { return (s & request.only) != 0; });
        EXPECT_EQ(counts.paths, static_cast<std::size_t>(asked));
        EXPECT_GT(asked, 0) << branch;
        EXPECT_LT(asked, 64 * 48) << branch;
        EXPECT_EQ(some.flags, all.flags) << branch;
        EXPECT_EQ(some.throughput, all.throughput) << branch;
        EXPECT_EQ(some.position, all.position) << branch;
    }
}

TEST(CameraPaths, SameBitsOnOneAndTwoThreads) {
    ViewScene scene(160, 90);
    scene.look({0, 0.6, 3}, {0, -0.4, 0});
    scene.fill(test::wavy_water(6, 200), 6);
    scene.add_floor(-2);
    scene.add(scene::Shape::box, {0, 0, 0});
    scene.add(scene::Shape::sphere, {1, 0, 0}).material.mirror = true;
    std::vector<ReceiverLayer> layers;
    std::vector<LayerCounts> counts(4);
    for (const int threads : {1, 2}) {
        set_thread_count(threads);
        layers.push_back(scene.trace(0, &counts[layers.size()]));
        layers.push_back(scene.trace(1, &counts[layers.size()]));
    }
    set_thread_count(0);
    const auto same = [](const auto& a, const auto& b) {
        return std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
    };
    for (std::size_t i = 0; i < 2; ++i) {
        const ReceiverLayer& a = layers[i];
        const ReceiverLayer& b = layers[i + 2];
        EXPECT_TRUE(same(a.flags, b.flags) && same(a.position, b.position) &&
                    same(a.throughput, b.throughput) && same(a.footprint_u, b.footprint_u) &&
                    same(a.footprint_v, b.footprint_v) && same(a.shading_normal, b.shading_normal) &&
                    same(a.uv_width, b.uv_width) && same(a.depth, b.depth));
        EXPECT_EQ(counts[i].dropped_weight, counts[i + 2].dropped_weight);
    }
    EXPECT_GT(counts[0].split_pixels, 1000u);
    EXPECT_GT(counts[0].dropped_splits + counts[1].dropped_splits, 0u);
}

}  // namespace
}  // namespace dapple::view
