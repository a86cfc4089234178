#include "rays/ray_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "base/hash.h"
#include "base/parallel.h"
#include "rays/ray_lanes.h"
#include "rays/water_meshes.h"
#include "scene/transform.h"

namespace dapple::rays {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

double uniform(std::uint64_t index, std::uint32_t dimension) {
    return hash_uniform(7, 0, index, dimension);
}

std::vector<Hit> object_hits(const RayScene& rays, const std::vector<Ray>& tests) {
    std::vector<Hit> hits(tests.size());
    rays.intersect_objects(tests, hits);
    return hits;
}

std::vector<Hit> water_hits(const RayScene& rays, const std::vector<Ray>& tests) {
    std::vector<Hit> hits(tests.size());
    rays.intersect_water(tests, hits);
    return hits;
}

scene::Object make(scene::Shape shape) {
    scene::Object object;
    object.shape = shape;
    return object;
}

glm::dvec3 interpolated(const scene::TriangleMesh& mesh, const Hit& hit) {
    const glm::uvec3 t = mesh.triangles[hit.primitive];
    const double u = hit.barycentric.x;
    const double v = hit.barycentric.y;
    return (1 - u - v) * mesh.positions[t.x] + u * mesh.positions[t.y] + v * mesh.positions[t.z];
}

TEST(RayScene, EmptySceneHitsNothing) {
    const RayScene rays{scene::FrameScene{}};
    const std::vector<Ray> tests(11, Ray{glm::vec3(0, 1, 0), 0, glm::vec3(0, -1, 0)});
    for (const Hit& hit : object_hits(rays, tests)) EXPECT_EQ(hit.primitive, kNoHit);
    for (const Hit& hit : water_hits(rays, tests)) EXPECT_EQ(hit.primitive, kNoHit);
    std::vector<std::uint8_t> occluded(tests.size(), 1);
    rays.occluded_by_objects(tests, occluded);
    EXPECT_EQ(occluded, std::vector<std::uint8_t>(tests.size(), 0));
    glm::vec3 lower;
    glm::vec3 upper;
    rays.object_bounds(lower, upper);
    EXPECT_GT(lower.x, upper.x);
    EXPECT_FALSE(rays.has_objects());
}

TEST(RayScene, RaysThatMeanNothingHitNothingAndHarmNoNeighbours) {
    scene::FrameScene scene;
    scene.state.objects.push_back(make(scene::Shape::plane));
    const RayScene rays(scene);
    const Ray good{glm::vec3(0.1f, 1, 0.1f), 0, glm::vec3(0, -1, 0)};
    std::vector<Ray> tests;
    for (const float bad : {kNan, kInfinity, -kInfinity}) {
        for (int axis = 0; axis < 3; ++axis) {
            tests.insert(tests.end(), 2, good);
            tests[tests.size() - 2].origin[axis] = bad;
            tests.insert(tests.end(), 2, good);
            tests[tests.size() - 2].direction[axis] = bad;
        }
        tests.insert(tests.end(), 2, good);
        tests[tests.size() - 2].near = bad == -kInfinity ? kNan : bad;
        tests.insert(tests.end(), 2, good);
        tests[tests.size() - 2].far = bad == kInfinity ? -1 : bad;
    }
    tests.insert(tests.end(), 2, good);
    tests[tests.size() - 2].direction = glm::vec3(0);
    const std::vector<Hit> hits = object_hits(rays, tests);
    std::vector<std::uint8_t> occluded(tests.size());
    rays.occluded_by_objects(tests, occluded);
    for (std::size_t i = 0; i < tests.size(); ++i) {
        const bool is_good = i % 2 == 1;
        EXPECT_EQ(hits[i].primitive != kNoHit, is_good) << i;
        EXPECT_EQ(occluded[i] == 1, is_good) << i;
        if (is_good) {
            EXPECT_FLOAT_EQ(hits[i].distance, 1);
        }
    }
}

TEST(RayScene, PlaneIsHitFromBothSidesAtItsDistance) {
    scene::FrameScene scene;
    scene.origin = {1000, 0, -2000};
    scene::Object plane = make(scene::Shape::plane);
    plane.size = {6, 1, 4};
    plane.transform.position = {1001, -2, -1998};
    plane.transform.rotation = {0.3, 0.5, 0.2};
    scene.state.objects.push_back(plane);
    const RayScene rays(scene);
    const glm::dmat4 matrix = scene::relative_from_object(plane.transform, scene.origin);
    const auto normal = glm::normalize(glm::dvec3(matrix[1]));

    std::vector<Ray> tests;
    std::vector<double> expected;
    std::vector<bool> inside;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const glm::dvec3 local(7 * (uniform(i, 0) - 0.5), 0, 5 * (uniform(i, 1) - 0.5));
        const glm::dvec3 target(matrix * glm::dvec4(local, 1));
        const double side = i % 2 == 0 ? 1 : -1;
        const glm::dvec3 origin = target + side * 3.0 * normal + glm::dvec3(uniform(i, 2), 0, uniform(i, 3));
        const glm::vec3 start(origin);
        tests.push_back({start, 0, glm::vec3(target) - start});
        expected.push_back(1);
        inside.push_back(std::abs(local.x) < 2.9999 && std::abs(local.z) < 1.9999);
    }
    const std::vector<Hit> hits = object_hits(rays, tests);
    std::size_t hit_count = 0;
    for (std::size_t i = 0; i < tests.size(); ++i) {
        if (!inside[i]) continue;
        ++hit_count;
        ASSERT_NE(hits[i].primitive, kNoHit) << i;
        // Positions of some 5 m in float: 2^-24 * 5, amplified by at most 3 at these angles.
        EXPECT_NEAR(hits[i].distance, 1, 1e-6);
        EXPECT_NEAR(dot(glm::normalize(glm::dvec3(hits[i].normal)), normal), 1, 1e-6);
    }
    EXPECT_GT(hit_count, 10000u);
}

TEST(RayScene, SphereAndEllipsoidAgreeWithTheQuadric) {
    scene::FrameScene scene;
    scene::Object ball = make(scene::Shape::sphere);
    ball.radius = 0.01;
    ball.transform.position = {3, -1, 2};
    scene::Object egg = make(scene::Shape::sphere);
    egg.radius = 0.5;
    egg.transform.position = {-3, -1, 0};
    egg.transform.rotation = {0.4, 0.9, -0.3};
    egg.transform.scale = {1, 2, -3};
    scene.state.objects = {ball, egg};
    const RayScene rays(scene);
    for (std::uint32_t id = 0; id < 2; ++id) {
        const scene::Object& object = scene.state.objects[id];
        const glm::dmat4 matrix = scene::world_from_object(object.transform);
        std::vector<Ray> tests;
        for (std::uint64_t i = 0; i < 20000; ++i) {
            const glm::vec3 start(10 * uniform(i, 0) - 5, 5 + 5 * uniform(i, 1), 10 * uniform(i, 2) - 5);
            const glm::dvec3 local(uniform(i, 3) - 0.5, uniform(i, 4) - 0.5, uniform(i, 5) - 0.5);
            const glm::dvec3 target(matrix * glm::dvec4(2.2 * object.radius * local, 1));
            tests.push_back({start, 0, glm::vec3(glm::normalize(target - glm::dvec3(start)))});
        }
        const std::vector<Hit> hits = object_hits(rays, tests);
        std::size_t hit_count = 0;
        for (std::size_t i = 0; i < tests.size(); ++i) {
            if (hits[i].primitive == kNoHit || hits[i].object != id) continue;
            ++hit_count;
            const glm::dvec3 at = glm::dvec3(tests[i].origin) +
                                  static_cast<double>(hits[i].distance) * glm::dvec3(tests[i].direction);
            const glm::dvec3 local = glm::dvec3(inverse(matrix) * glm::dvec4(at, 1)) / object.radius;
            // Only the rounding of the distance, 2^-24 * 14 m, in units of the smallest half-axis.
            EXPECT_NEAR(length(local), 1, 1e-6 / object.radius);
            const glm::dvec3 gradient = transpose(inverse(glm::dmat3(matrix))) * local;
            EXPECT_NEAR(dot(normalize(gradient), normalize(glm::dvec3(hits[i].normal))), 1, 1e-6);
            EXPECT_LT(dot(hits[i].normal, tests[i].direction), 1e-3f) << "the first crossing is the near one";
        }
        EXPECT_GT(hit_count, 5000u);
    }
}

TEST(RayScene, BoxIsHitFromOutsideWithOutwardNormalsAlsoWhenMirrored) {
    for (const double mirror : {1.0, -1.0}) {
        scene::FrameScene scene;
        scene::Object box = make(scene::Shape::box);
        box.size = {1, 2, 3};
        box.transform.scale = {mirror, 1, 1};
        scene.state.objects.push_back(box);
        const RayScene rays(scene);
        std::vector<Ray> tests;
        for (int axis = 0; axis < 3; ++axis) {
            for (const float side : {1.0f, -1.0f}) {
                glm::vec3 direction(0);
                direction[axis] = -side;
                tests.push_back({glm::vec3(0.1f, 0.2f, 0.3f) - 5.0f * direction, 0, direction});
            }
        }
        const std::vector<Hit> hits = object_hits(rays, tests);
        for (std::size_t i = 0; i < 6; ++i) {
            ASSERT_NE(hits[i].primitive, kNoHit);
            const auto axis = static_cast<int>(i / 2);
            const double offset = tests[i].origin[axis] + 5 * tests[i].direction[axis];
            const double half = 0.5 * box.size[axis];
            EXPECT_NEAR(hits[i].distance, 5 - half + (i % 2 == 0 ? 1 : -1) * offset, 1e-6);
            EXPECT_EQ(glm::normalize(hits[i].normal), -tests[i].direction);
            // In object space the faces keep their places in the list; a mirrored x swaps the first two.
            const std::size_t face = mirror < 0 && i < 2 ? 1 - i : i;
            EXPECT_EQ(hits[i].primitive / 2, face);
        }
    }
}

/// Rays at every vertex and many edges of a wavy sheet, from a point and in parallel: where a tracer leaks,
/// it leaks there. Both ways of splitting cells, and loose triangles.
class Watertight : public testing::TestWithParam<int> {};

TEST_P(Watertight, NoRayLeaksAndHitsLieOnTheTriangle) {
    constexpr int kCells = 500;
    scene::FrameScene scene;
    auto water = test::wavy_water(10, kCells, GetParam() == 1);
    if (GetParam() == 2) water->rows = water->columns = 0;
    scene.water = water;
    const RayScene rays(scene);
    const auto& mesh = water->mesh;
    std::vector<Ray> tests;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 corner = mesh.positions[t.x];
        if (std::abs(corner.x) > 4.6 || std::abs(corner.z) > 4.6) continue;
        const glm::dvec3 edge = 0.5 * (mesh.positions[t.y] + mesh.positions[t.z]);
        tests.push_back({glm::vec3(0, -2, 0), 0, glm::vec3(corner) - glm::vec3(0, -2, 0)});
        tests.push_back({glm::vec3(0.3f, 2, 0), 0, glm::vec3(edge) - glm::vec3(0.3f, 2, 0)});
        tests.push_back({glm::vec3(corner) + glm::vec3(0, 1, 0), 0, glm::vec3(0, -1, 0)});
    }
    ASSERT_GT(tests.size(), 1000000u);
    const std::vector<Hit> hits = water_hits(rays, tests);
    std::size_t leaks = 0;
    double worst = 0;
    for (std::size_t i = 0; i < tests.size(); ++i) {
        if (hits[i].primitive == kNoHit) {
            ++leaks;
            continue;
        }
        const glm::dvec3 at = glm::dvec3(tests[i].origin) +
                              static_cast<double>(hits[i].distance) * glm::dvec3(tests[i].direction);
        worst = std::max(worst, length(at - interpolated(mesh, hits[i])));
        ASSERT_GE(hits[i].barycentric.x, -1e-4f);
        ASSERT_GE(hits[i].barycentric.y, -1e-4f);
        ASSERT_LE(hits[i].barycentric.x + hits[i].barycentric.y, 1 + 1e-4f);
        ASSERT_GT(hits[i].normal.y, 0);
    }
    EXPECT_EQ(leaks, 0u);
    // A triangle's plane is found from float positions of up to 6 m, 2^-24 * 6 m each, and met at cosines
    // down to 0.2; rays that would slip through a vertex are moved by 2^-20 * 5 m.
    EXPECT_LT(worst, 1e-5);
}
INSTANTIATE_TEST_SUITE_P(Splits, Watertight, testing::Values(0, 1, 2));

TEST(RayScene, SameBitsOnOneAndTwoThreads) {
    scene::FrameScene scene;
    auto water = test::wavy_water(10, 300);
    scene.water = water;
    for (int i = 0; i < 200; ++i) {
        scene::Object box = make(i % 2 == 0 ? scene::Shape::box : scene::Shape::sphere);
        box.transform.position = {uniform(static_cast<std::uint64_t>(i), 0), -1,
                                  uniform(static_cast<std::uint64_t>(i), 1)};
        scene.state.objects.push_back(box);
    }
    std::vector<Ray> tests;
    for (const glm::dvec3& p : water->mesh.positions) {  // ties at every vertex
        tests.push_back({glm::vec3(p) + glm::vec3(0, 1, 0), 0, glm::vec3(0, -1, 0)});
    }
    std::vector<std::vector<Hit>> found;
    for (const int threads : {1, 2}) {
        set_thread_count(threads);
        const RayScene rays(scene);
        found.push_back(water_hits(rays, tests));
        found.push_back(object_hits(rays, tests));
    }
    set_thread_count(0);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(std::memcmp(found[i].data(), found[i + 2].data(), tests.size() * sizeof(Hit)), 0);
    }
}

TEST(RayScene, OcclusionLooksBetweenNearAndFarOnly) {
    scene::FrameScene scene;
    scene.state.objects.push_back(make(scene::Shape::sphere));
    scene.water = test::flat_water(10);
    const RayScene rays(scene);
    const glm::vec3 down(0, -1, 0);
    const std::vector<Ray> tests{{glm::vec3(0, 2, 0), 0, down},
                                 {glm::vec3(0, 2, 0), 0, down, 1.4f},
                                 {glm::vec3(0, 2, 0), 0, down, 1.6f},
                                 {glm::vec3(0, 2, 0), 2.6f, down},
                                 {glm::vec3(2, 2, 0), 0, down}};  // the water does not occlude
    std::vector<std::uint8_t> occluded(tests.size());
    rays.occluded_by_objects(tests, occluded);
    EXPECT_EQ(occluded, (std::vector<std::uint8_t>{1, 0, 1, 0, 0}));
}

TEST(RayScene, LanesHitWhatTheirRaysHitOneByOne) {
    scene::FrameScene scene;
    scene.state.objects.assign(2, make(scene::Shape::box));
    scene.state.objects[1].transform.scale = {-1, 1, 1};
    scene.state.objects[1].transform.position = {1.5, 0.3, 0};
    const RayScene rays(scene);
    constexpr std::size_t kLanes = lanes::kLanes<float>;
    std::size_t hit = 0, missed = 0;
    for (std::uint64_t packet = 0; packet < 200; ++packet) {
        std::vector<Ray> tests(kLanes);
        RayLanes eight;
        for (std::size_t k = 0; k < kLanes; ++k) {
            const auto number = [&](std::uint32_t dimension) {
                return static_cast<float>(4 * uniform(packet * kLanes + k, dimension) - 2);
            };
            tests[k] = {glm::vec3(number(0), 3, number(1)), 0, glm::vec3(number(2), -3, number(3)), 1};
            set_lane(eight.origin, k, tests[k].origin);
            set_lane(eight.direction, k, tests[k].direction);
            eight.far[k] = tests[k].far;
            eight.on[k] = (packet + k) % 3 > 0 ? -1 : 0;
        }
        const std::vector<Hit> hits = object_hits(rays, tests);
        std::vector<std::uint8_t> occluded(kLanes);
        rays.occluded_by_objects(tests, occluded);
        HitLanes found;
        rays.intersect_objects(eight, found);
        const lanes::Flags hidden = rays.occluded_by_objects(eight);
        for (std::size_t k = 0; k < kLanes; ++k) {
            const Hit expected = eight.on[k] != 0 ? hits[k] : Hit{};
            ASSERT_EQ(found.hit[k] != 0, expected.primitive != kNoHit);
            ASSERT_EQ(found.distance[k], expected.distance);
            ASSERT_EQ(lane(found.normal, k), expected.normal);
            ASSERT_EQ(hidden[k] != 0, eight.on[k] != 0 && occluded[k] != 0);
            ++(found.hit[k] != 0 ? hit : missed);
        }
    }
    EXPECT_GT(std::min(hit, missed), 100u);
}

TEST(RayScene, ScalesOfZeroAndBrokenVerticesAreLeftOut) {
    scene::FrameScene scene;
    scene::Object flat = make(scene::Shape::sphere);
    flat.transform.scale = {1, 0, 1};
    scene::Object mesh = make(scene::Shape::mesh);
    scene.state.objects = {flat, mesh, make(scene::Shape::mesh)};
    auto broken = std::make_shared<scene::TriangleMesh>();
    broken->positions = {{0, 0, 0}, {0, 0, 1}, {std::nan(""), 0, 0}, {1, 0, 0}};
    broken->triangles = {{0, 1, 2}, {0, 1, 3}};
    scene.object_meshes = {nullptr, broken, nullptr};
    const RayScene rays(scene);
    const auto hits = object_hits(rays, {{glm::vec3(0.2f, 1, 0.2f), 0, glm::vec3(0, -1, 0)}});
    EXPECT_EQ(hits[0].object, 1u);
    EXPECT_EQ(hits[0].primitive, 1u);
}

TEST(RayScene, ComponentsOfADirectionNearZeroOfAnySign) {
    // As refraction and back leave them of light straight down. A row of boxes on a floor: a tree with nodes.
    scene::FrameScene scene;
    scene.state.objects = {make(scene::Shape::plane)};
    scene.state.objects[0].size = {100, 1, 100};
    for (int i = -8; i <= 8; ++i) {
        scene.state.objects.push_back(make(scene::Shape::box));
        scene.state.objects.back().transform.position = {2 * i, 2 + 0.1 * i, 0};
    }
    const RayScene rays(scene);
    constexpr float tiny[] = {0, -0.0f, 3e-16f, -3e-16f, 5e-18f, -5e-18f, 4e-19f, -4e-19f, 1e-25f, -1e-25f};
    std::vector<Ray> tests;
    for (std::uint64_t i = 0; i < 4000; ++i) {
        const auto pick = [&](std::uint32_t dimension) {
            return tiny[static_cast<std::size_t>(uniform(i, dimension) * std::size(tiny))];
        };
        tests.push_back({glm::vec3(40 * uniform(i, 0) - 20, 5, 2 * uniform(i, 1) - 1), 0,
                         glm::vec3(pick(2), -1, pick(3))});
    }
    const std::vector<Hit> hits = object_hits(rays, tests);
    std::vector<std::uint8_t> occluded(tests.size());
    rays.occluded_by_objects(tests, occluded);
    std::size_t boxes = 0;
    for (std::size_t i = 0; i < tests.size(); ++i) {
        ASSERT_NE(hits[i].primitive, kNoHit) << i;
        ASSERT_EQ(occluded[i], 1) << i;
        const double x = static_cast<double>(tests[i].origin.x), z = static_cast<double>(tests[i].origin.z);
        const bool on_box =
            std::abs(z) < 0.5 && std::abs(x - 2 * std::round(0.5 * x)) < 0.5 && std::abs(x) < 17;
        ASSERT_EQ(hits[i].object != 0, on_box) << i;
        boxes += on_box ? 1 : 0;
    }
    EXPECT_GT(boxes, 400u);
}

}  // namespace
}  // namespace dapple::rays
