#include "light/caustic_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "gpu/validated_device.h"
#include "light/landing.h"
#include "light/map_plan.h"
#include "light/water_grids.h"
#include "optics/optics.h"

namespace dapple {
namespace {

using light::BeamMesh;
using light::Event;

double total_flux(const BeamMesh& mesh) {
    return std::accumulate(mesh.flux.begin(), mesh.flux.end(), 0.0);
}

std::vector<BeamMesh> trace(const scene::FrameScene& scene, int resolution,
                            const std::vector<Event>& events = {Event::transmission, Event::reflection}) {
    light::CausticMapper mapper(test::validated_device());
    const rays::RayScene rays(scene);
    FrameStats stats;
    scene::CausticMapParameters map;
    map.map_resolution = resolution;
    return mapper.trace(scene, rays, 0, events, map, stats);
}

/// Reflectance by angles, written apart from the program's vector forms.
double reflectance(double zenith, double n) {
    if (zenith == 0) return std::pow((n - 1) / (n + 1), 2);
    const double t = std::asin(std::sin(zenith) / n);
    const double s = std::sin(zenith - t) / std::sin(zenith + t),
                 p = std::tan(zenith - t) / std::tan(zenith + t);
    return 0.5 * (s * s + p * p);
}

TEST(CausticMap, FlatWaterFillsWholeTexelsEqually) {
    for (const double zenith : {0.0, 30.0, 60.0, 80.0, 89.0}) {
        SCOPED_TRACE(zenith);
        scene::FrameScene scene = test::water_scene({7, 3}, {1.3, -2.1});
        scene.origin = {2, -3, 5};
        scene.state.lights = {test::sun(zenith)};
        test::add_water(scene, {}, 40, 20);
        const std::vector<BeamMesh> meshes = trace(scene, 210);
        const double n = 1.333, i = glm::radians(zenith);
        const double met = 21 * std::cos(i), r = reflectance(i, n);
        for (const BeamMesh& mesh : meshes) {
            const bool transmission = mesh.event == Event::transmission;
            ASSERT_EQ(mesh.columns, 210);  // no border: the map is the extent
            ASSERT_EQ(mesh.rows, 90);
            for (std::size_t k = 0; k < mesh.vertices(); ++k) {
                ASSERT_EQ(mesh.flux[k], mesh.flux[0]);
                ASSERT_EQ(mesh.slope[k], mesh.slope[0]);
                ASSERT_EQ(mesh.valid[k], 1);
            }
            // A float's round-off of direction, cosines and product; at 89 deg cos(i) = 0.017 itself is a
            // float's component of the direction, good to 6e-8 / 0.017.
            EXPECT_NEAR(total_flux(mesh) / (met * (transmission ? 1 - r : r)), 1, zenith < 85 ? 1e-6 : 1e-5);
            EXPECT_NEAR(glm::length(glm::dvec3(mesh.slope[0]) - mesh.axis), 0, 1e-6);
            // The ray of texel (0, 0) leaves the surface at its centre.
            const glm::dvec3 p = glm::dvec3(mesh.origin[0] + mesh.start[0] * mesh.slope[0]) + scene.origin;
            EXPECT_NEAR(p.x, 1.3 - 3.5 + 0.5 * 7 / 210, 5e-5);
            EXPECT_NEAR(p.y, 0, 5e-5);
            EXPECT_NEAR(p.z, -2.1 - 1.5 + 0.5 * 3 / 90, 5e-5);
        }
    }
}

/// Flux through the mesh, summed over its triangles in double with Gauss points and interpolated normals.
double mesh_flux(const scene::FrameScene& scene, Event event) {
    const scene::TriangleMesh& mesh = scene.water->mesh;
    const glm::dvec3 d = scene.state.lights[0].direction;
    const double n = 1.333;
    double sum = 0;
    for (const glm::uvec3 t : mesh.triangles) {
        const glm::dvec3 area = 0.5 * glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                                 mesh.positions[t.z] - mesh.positions[t.x]);
        for (int k = 0; k < 3; ++k) {
            glm::dvec3 weight(1.0 / 6);
            weight[k] = 2.0 / 3;
            const glm::dvec3 normal = glm::normalize(
                weight.x * mesh.normals[t.x] + weight.y * mesh.normals[t.y] + weight.z * mesh.normals[t.z]);
            const double r = reflectance(std::acos(-glm::dot(normal, d)), n);
            sum += -glm::dot(area, d) / 3 * (event == Event::transmission ? 1 - r : r);
        }
    }
    return sum;
}

TEST(CausticMap, FluxOfAGentleSeaIsThatThroughItsTriangles) {
    for (const double zenith : {0.0, 30.0}) {
        SCOPED_TRACE(zenith);
        scene::FrameScene scene = test::water_scene({12, 12});
        scene.state.lights = {test::sun(zenith)};
        test::add_water(scene, test::gentle_sea(), 400, 400);
        for (const BeamMesh& mesh : trace(scene, 1024)) {
            // Overhead nothing but round-off and the quadrature differ. Obliquely the waves make the patch's
            // edges ragged on the map, and texels sample them as in or out: half a texel on 4096 of them,
            // partly averaged.
            EXPECT_NEAR(total_flux(mesh) / mesh_flux(scene, mesh.event), 1, zenith > 0 ? 1e-4 : 1e-6)
                << mesh.name;
            EXPECT_EQ(mesh.lost_flux, 0);
        }
    }
}

TEST(CausticMap, ALowSunsLightThatCrestsThrowFarOffIsAllHeld) {
    for (const double elevation : {5.0, 0.5, 0.1, 0.02}) {
        SCOPED_TRACE(elevation);
        scene::FrameScene scene = test::water_scene({12, 2});
        scene.state.lights = {test::sun(90 - elevation, 0)};
        test::add_water(scene, {{0.03, {glm::two_pi<double>(), 0}, glm::pi<double>()}}, 2400, 4);
        // The water is one sheet: all light meets it between the lowest and the highest place across the
        // light.
        const glm::dvec3 d = scene.state.lights[0].direction, across(-d.y, d.x, 0);
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (const glm::dvec3 p : scene.water->mesh.positions) {
            low = std::min(low, glm::dot(p, across));
            high = std::max(high, glm::dot(p, across));
        }
        double flux = 0;
        for (const BeamMesh& mesh : trace(scene, 512)) {
            flux += total_flux(mesh);
            EXPECT_EQ(mesh.lost_flux, 0);
        }
        // Texels at the ends of the sheet are in or out: one on 512 at most.
        EXPECT_NEAR(flux / (2 * (high - low)), 1, 2e-3);
    }
}

TEST(CausticMap, BeamsOfASinusoidFirstFoldWhereTheExactMapDoes) {
    const double amplitude = 0.01, length = 0.5, n = 1.333, k = glm::two_pi<double>() / length;
    scene::FrameScene scene = test::water_scene({2, 0.25});
    scene.state.lights = {test::sun(0)};
    test::add_water(scene, {{amplitude, {k, 0}, 0}}, 800, 10);
    const std::vector<BeamMesh> meshes = trace(scene, 2048, {Event::transmission});
    const BeamMesh& mesh = meshes[0];
    // Depth below the rest plane at which two neighbours' rays first cross, of those away from the edges.
    double first = 1e9;
    const int row = mesh.rows / 2;
    for (int c = 100; c + 101 < mesh.columns; ++c) {
        const std::size_t i = static_cast<std::size_t>(row * mesh.columns + c);
        const double spread =
            static_cast<double>(mesh.origin[i + 1].x) - static_cast<double>(mesh.origin[i].x);
        const double rate = static_cast<double>(mesh.slope[i + 1].x) - static_cast<double>(mesh.slope[i].x);
        if (rate < 0) first = std::min(first, -spread / rate);
    }
    // methods: curvature a k^2 at the crest, focal length n / ((n - 1) a k^2) below the crest, which is a
    // above.
    const double focus = n / ((n - 1) * amplitude * k * k) - amplitude;
    EXPECT_NEAR(first / focus, 1, 0.01);
}

TEST(CausticMap, PointLightSendsTheSolidAngleOfTheWater) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = {0, 2, 0};
    scene.state.lights = {lamp};
    test::add_water(scene, {}, 16, 16);
    const std::vector<BeamMesh> meshes = trace(scene, 256);
    EXPECT_EQ(meshes[0].name, "lamp > water:T");
    scene.state.lights[0].name = "";
    EXPECT_EQ(trace(scene, 16)[1].name, "lights[0] > water:R");
    // Solid angle of a square of half-width 2 seen from 2 above its centre: a face of a cube, 4 pi / 6.
    EXPECT_NEAR(total_flux(meshes[0]) + total_flux(meshes[1]), 4 * glm::pi<double>() / 6, 1e-5);
}

TEST(CausticMap, ASpotIsAPointLightInsideItsConeAndNothingOutside) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = {0, 2, 0};
    scene.state.lights = {lamp};
    test::add_water(scene, {}, 16, 16);
    const BeamMesh point = trace(scene, 128, {Event::transmission})[0];
    scene.state.lights[0].type = scene::LightType::spot;
    scene.state.lights[0].cone_angle = 0.5;
    scene.state.lights[0].falloff_angle = 0.1;
    const BeamMesh spot = trace(scene, 128, {Event::transmission})[0];
    for (std::size_t i = 0; i < spot.vertices(); ++i) {
        const glm::dvec3 p = glm::dvec3(spot.origin[i] + spot.start[i] * spot.slope[i]);
        const double angle = std::atan(std::hypot(p.x, p.z) / 2);
        if (angle < 0.399) {
            ASSERT_EQ(spot.flux[i], point.flux[i]);
        } else if (angle > 0.501) {
            ASSERT_EQ(spot.flux[i], 0);
        } else {
            ASSERT_LE(spot.flux[i], point.flux[i]);
        }
    }
}

TEST(CausticMap, ALightUnderWaterIsReflectedTotallyBeyondTheCriticalAngle) {
    scene::FrameScene scene = test::water_scene({8, 8});
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = {0, -1, 0};
    scene.state.lights = {lamp};
    test::add_water(scene, {}, 16, 16);
    const std::vector<BeamMesh> meshes = trace(scene, 256);
    const double critical = std::tan(std::asin(1 / 1.333));
    // Where the refracted light leaves the cone about the mesh's axis: cos(t) = 0.1.
    const double nearly_level = std::tan(std::asin(std::sqrt(0.99) / 1.333));
    for (std::size_t i = 0; i < meshes[0].vertices(); ++i) {
        const glm::dvec3 p = glm::dvec3(meshes[0].origin[i] + meshes[0].start[i] * meshes[0].slope[i]);
        const double radius = std::hypot(p.x, p.z);
        if (radius < nearly_level - 0.01) {
            ASSERT_GT(meshes[0].slope[i].y, 0);  // T goes up into the air, R down into the water
            ASSERT_EQ(meshes[0].valid[i], 1);
        }
        if (radius > critical + 0.01) {
            ASSERT_EQ(meshes[0].flux[i], 0);
        }
        ASSERT_LT(meshes[1].slope[i].y, 0);
    }
    EXPECT_FALSE(meshes[0].in_water());
    EXPECT_TRUE(meshes[1].in_water());
    // All light that meets the water is in one of the meshes or counted as lost (T nearly level).
    const double square = 4 * std::asin(16.0 / 17.0);  // solid angle: 4 asin(a^2 / (a^2 + h^2)), a = 4, h = 1
    EXPECT_NEAR(total_flux(meshes[0]) + total_flux(meshes[1]) + meshes[0].lost_flux + meshes[1].lost_flux,
                square, 1e-3 * square);
}

TEST(CausticMap, ASetSunLightsNothing) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::sun(91)};
    test::add_water(scene, {}, 4, 4);
    for (const BeamMesh& mesh : trace(scene, 64)) EXPECT_EQ(mesh.vertices(), 0u);
}

TEST(CausticMap, AnObjectShadowsTheWaterBehindIt) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::sun(45, 0)};  // travels along -x and down
    scene::Object plate;
    plate.size = {1, 1, 1};
    plate.transform.position = {0.5, 1, 0};
    scene.state.objects = {plate};
    test::add_water(scene, {}, 4, 4);
    for (const BeamMesh& mesh : trace(scene, 64))
        for (std::size_t i = 0; i < mesh.vertices(); ++i) {
            const glm::dvec3 p = glm::dvec3(mesh.origin[i] + mesh.start[i] * mesh.slope[i]);
            const bool shadowed = std::abs(p.x + 0.5) < 0.5 && std::abs(p.z) < 0.5;
            ASSERT_EQ(mesh.flux[i] == 0, shadowed) << p.x << ' ' << p.z;
            ASSERT_EQ(mesh.valid[i], shadowed ? BeamMesh::kShadowed : 1);
        }
}

TEST(CausticMap, MapsOfAnySizeAreShadowedAndLandAsTheirRaysDoOneByOne) {
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::sun(45, 0)};
    scene::Object plate, floor;
    plate.size = {1, 1, 1};
    plate.transform.position = {0.5, 1, 0};
    floor.size = {3, 1, 3};
    floor.transform.position = {0, -2, 0};
    scene.state.objects = {plate, floor};
    test::add_water(scene, test::gentle_sea(), 60, 60);
    const rays::RayScene rays(scene);
    const auto hit = [&](glm::vec3 origin, glm::vec3 direction) {
        const rays::Ray ray{origin, 0, direction};
        rays::Hit found;
        rays.intersect_objects({&ray, 1}, {&found, 1});
        return found;
    };
    std::size_t shadowed = 0, landed = 0, missed = 0;
    for (const int side : {1, 2, 3, 5, 8, 13, 70}) {
        SCOPED_TRACE(side);
        for (const BeamMesh& mesh : trace(scene, side)) {
            const light::Landings landings = light::land(mesh, rays);
            std::size_t count = 0;
            for (std::size_t i = 0; i < mesh.vertices(); ++i) {
                const glm::vec3 start = mesh.origin[i] + mesh.start[i] * mesh.slope[i];
                const bool hidden =
                    hit(start, -glm::vec3(scene.state.lights[0].direction)).primitive != rays::kNoHit;
                if (mesh.valid[i] != 0) {
                    ASSERT_EQ(mesh.valid[i] == BeamMesh::kShadowed, hidden);
                    ASSERT_EQ(mesh.flux[i] == 0, hidden);
                }
                const rays::Hit lands = mesh.flux[i] > 0 ? hit(start, mesh.slope[i]) : rays::Hit{};
                ASSERT_EQ(landings.depth[i],
                          lands.primitive != rays::kNoHit ? mesh.start[i] + lands.distance : lands.distance);
                ASSERT_EQ(landings.normal[i].y,
                          lands.primitive != rays::kNoHit && mesh.slope[i].y > 0 ? -1 : 1);
                count += lands.primitive != rays::kNoHit ? 1 : 0;
                shadowed += mesh.valid[i] == BeamMesh::kShadowed ? 1 : 0;
                missed += lands.primitive != rays::kNoHit ? 0 : 1;
            }
            ASSERT_EQ(landings.count, count);
            landed += count;
        }
    }
    EXPECT_GT(std::min({shadowed, landed, missed}), 100u);
}

}  // namespace
}  // namespace dapple
