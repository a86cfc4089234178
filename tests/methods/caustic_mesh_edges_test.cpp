// Caustic meshes at edges of objects, on walls, and how pixels and layers are filtered.
#include <gtest/gtest.h>

#include "methods/flat_water_light.h"

namespace dapple {
namespace {

using light::Event;
using test::flat_pool;
using test::kPoolFloor;

/// A box that stands on the floor.
const glm::dvec3 kLow{-0.4, -1.5, -0.3}, kHigh{0.3, -1.1, 0.5};

scene::Object box() {
    scene::Object box;
    box.shape = scene::Shape::box;
    box.size = kHigh - kLow;
    box.transform.position = 0.5 * (kLow + kHigh);
    return box;
}

/// Whether the box keeps light on its way off a point of the floor, or stands on it.
bool in_shadow(glm::dvec3 point, glm::dvec3 way) {
    double enter = 0, leave = HUGE_VAL;
    for (int c = 0; c < 3; ++c) {
        const double a = (kLow[c] - point[c]) / -way[c], b = (kHigh[c] - point[c]) / -way[c];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter < leave;
}

/// Of what lies within `reach` of a pixel, along x and z: 1 if all of it is lit, 0 if none is.
enum class Light { none, some, all };
Light light_about(glm::dvec3 point, glm::dvec3 way, double reach) {
    int lit = 0;
    constexpr int kSide = 9;
    for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < kSide; ++column)
            lit += in_shadow({point.x + reach * (column / 4.0 - 1), -1.5, point.z + reach * (row / 4.0 - 1)},
                             way)
                       ? 0
                       : 1;
    return lit == 0 ? Light::none : lit == kSide * kSide ? Light::all : Light::some;
}

struct Around {
    double worst_lit = 0;   // error of pixels that are lit all over
    double worst_dark = 0;  // E over the lit floor's of pixels that are not lit at all
    int black_by_box =
        0;  // pixels that are lit all over and have less than half of it, within a cell of the edge
    int black_elsewhere = 0;  // farther off
    int lit = 0, dark = 0;
};

constexpr int kPixels = 128, kResolution = 200;
constexpr double kPixel = 2.0 / kPixels, kCell = 6.0 / kResolution;

Around around_box(bool paper) {
    scene::FrameScene scene = flat_pool(50, kResolution, kPixels);
    scene.state.water->absorption = {0, 0, 0};
    scene.state.objects.push_back(box());
    scene.state.caustics.map.paper_faithful = paper;
    const view::ReceiverLayer layer = test::receivers_on(scene, kPoolFloor, true);
    const methods::LayerResult result = test::draw_mesh(scene, layer);
    const glm::dvec3 way = test::refracted(scene);
    Around found;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        const glm::dvec3 point = glm::dvec3(layer.position[i]) + scene.origin;
        // Floor under the box, which nothing sees.
        if (point.x > kLow.x && point.x < kHigh.x && point.z > kLow.z && point.z < kHigh.z) continue;
        // Cells at edges are cut into eighths; light fades over one, across it at most.
        const Light light = light_about(point, way, 0.5 * kPixel + 1.5 * kCell / 8);
        const double expected = under_flat_water(scene, kPoolFloor, point).g;
        const double e = static_cast<double>(result.irradiance[i].g) / expected;
        if (light == Light::all) {
            ++found.lit;
            found.worst_lit = std::max(found.worst_lit, std::abs(e - 1));
            if (e < 0.5)
                ++(light_about(point, way, 0.5 * kPixel + 1.5 * kCell) == Light::some
                       ? found.black_by_box
                       : found.black_elsewhere);
        } else if (light == Light::none) {
            ++found.dark;
            found.worst_dark = std::max(found.worst_dark, e);
        }
    }
    return found;
}

TEST(CausticMeshEdges, NoBlackEdgeAboutABoxButInThePapersMesh) {
    const Around cured = around_box(false), paper = around_box(true);
    EXPECT_GT(cured.lit, 10000);
    EXPECT_GT(cured.dark, 500);
    // Receivers right beside the box and up to its shadow have all their light, those in it none.
    EXPECT_LT(cured.worst_lit, 1e-4);
    EXPECT_LT(cured.worst_dark, 1e-3);
    EXPECT_EQ(cured.black_by_box, 0);
    // Triangles that span the edge are missing: a band as wide as they are, and nothing else.
    EXPECT_GT(paper.black_by_box, 30);
    EXPECT_EQ(paper.black_elsewhere, 0);
    EXPECT_LT(paper.worst_dark, 1e-3);
}

TEST(CausticMeshEdges, TheEdgeOfASurfaceHasAllItsLight) {
    // The top of a box: pixels on it see past its edge, where cells land on the floor.
    scene::FrameScene scene = flat_pool(50, kResolution, kPixels);
    scene.state.objects.push_back(box());
    const test::Plane top{{0, kHigh.y, 0}};
    const view::ReceiverLayer layer = test::receivers_on(scene, top, true);
    const methods::LayerResult result = test::draw_mesh(scene, layer);
    double worst = 0;
    int seen = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        const glm::dvec3 point = glm::dvec3(layer.position[i]) + scene.origin;
        if (point.x < kLow.x || point.x > kHigh.x || point.z < kLow.z || point.z > kHigh.z) continue;
        const double expected = under_flat_water(scene, top, point).g;
        worst = std::max(worst, std::abs(static_cast<double>(result.irradiance[i].g) / expected - 1));
        ++seen;
    }
    EXPECT_GT(seen, 1000);
    EXPECT_LT(worst, 1e-4);
}

TEST(CausticMeshEdges, AWallIsLitUpToTheWater) {
    // A box that pierces the surface keeps the light off the water within it: cells of 3 cm reach over the
    // waterline, by which the light would fade over the topmost 5 cm of the wall.
    scene::FrameScene scene = flat_pool(50, kResolution, 0);
    scene.state.lights[0] = test::sun(50, 0);  // travels along -x
    scene.origin = glm::dvec3(0);
    scene::Object pillar;
    pillar.shape = scene::Shape::box;
    pillar.size = {1, 4, 8};
    pillar.transform.position = {-0.712, 0, 0};  // between rays
    scene.state.objects.push_back(pillar);
    const test::Plane wall{{-0.212, 0, 0}, {1, 0, 0}};
    test::look(scene, {16, 50}, 0.5, {1, -0.26, 0}, {-1, -0.26, 0}, {0, 1, 0});
    const view::ReceiverLayer layer = test::receivers_on(scene, wall, true);
    const methods::LayerResult result = test::draw_mesh(scene, layer);
    const double t = std::asin(std::sin(glm::radians(50.0)) / test::kMeshIndex);
    const double lit = std::cos(glm::radians(50.0)) * test::transmittance(glm::radians(50.0)) * std::tan(t) *
                       scene.state.lights[0].irradiance.g;
    double worst = 0;
    int seen = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        const double depth = -static_cast<double>(layer.position[i].y);
        // Rays between those of the map find the waterline to an eighth of a cell.
        if (depth < 0.005 + 1.5 * kCell / 8 / std::tan(t)) continue;
        const double expected = lit * std::exp(-scene.state.water->extinction().g * depth / std::cos(t));
        worst = std::max(worst, std::abs(static_cast<double>(result.irradiance[i].g) / expected - 1));
        ++seen;
    }
    EXPECT_GT(seen, 45 * 16);
    EXPECT_LT(worst, 1e-4);
}

TEST(CausticMeshEdges, FlatWaterReflectsOntoAWall) {
    for (const double zenith : {60.0, 80.0}) {
        SCOPED_TRACE(zenith);
        scene::FrameScene scene = test::water_scene({6, 6});
        scene.origin = {1, 0, -2};
        scene.state.lights = {test::sun(zenith, 0)};  // travels along -x
        scene.state.caustics.map.map_resolution = 300;
        // Faces +x and begins above the water.
        const test::Plane wall{{-3, 0.9, 0}, {1, 0, 0}};
        scene.state.objects = {test::plane_object(wall.point, 1.6, {0, 0, -glm::half_pi<double>()})};
        test::add_water(scene, {}, 8, 8);
        test::look(scene, {64, 48}, 0.9, {0, 0.6, 0}, {-1, 0.6, 0}, {0, 1, 0});
        const view::ReceiverLayer layer = test::receivers_on(scene, wall, false);
        const methods::LayerResult result = test::draw_mesh(scene, layer, Event::reflection);
        const double i = glm::radians(zenith);
        const glm::dvec3 expected =
            scene.state.lights[0].irradiance * (1 - test::transmittance(i)) * std::sin(i);
        double worst = 0;
        for (const glm::vec3& e : result.irradiance)
            for (int c = 0; c < 3; ++c)
                worst = std::max(worst, std::abs(static_cast<double>(e[c]) / expected[c] - 1));
        EXPECT_LT(worst, 1e-4);
    }
}

/// A sea that folds over its floor.
scene::FrameScene folded(int pixels) {
    scene::FrameScene scene = flat_pool(20, 300, pixels);
    test::add_water(scene, test::gentle_sea(), 200, 200);
    return scene;
}

TEST(CausticMeshEdges, SamplesOfAPixelAreMeansOverItsParts) {
    scene::FrameScene scene = folded(64);
    const methods::LayerResult one = test::draw_mesh(scene, test::receivers_on(scene, kPoolFloor, true));
    scene.state.clip.samples = 4;
    std::vector<view::ReceiverLayer> layers;
    for (int sample = 0; sample < 4; ++sample)
        layers.push_back(test::receivers_on(scene, kPoolFloor, true, sample));
    FrameStats stats;
    const auto four = test::draw_mesh(scene, Event::transmission, layers, stats);
    double difference = 0, sum = 0, apart = 0;
    for (std::size_t i = 0; i < one.irradiance.size(); ++i) {
        double mean = 0;
        for (const methods::LayerResult& part : four)
            mean += 0.25 * static_cast<double>(part.irradiance[i].g);
        const double whole = static_cast<double>(one.irradiance[i].g);
        difference += std::abs(mean - whole);
        apart += std::abs(static_cast<double>(four[0].irradiance[i].g) - whole);
        sum += whole;
    }
    // Both are exact means over the same cells but for round-off.
    EXPECT_LT(difference, 1e-4 * sum);
    EXPECT_GT(apart, 0.02 * sum);
}

TEST(CausticMeshEdges, LayersHaveTheSameBitsInAnyBatch) {
    scene::FrameScene scene = folded(48);
    scene.state.clip.samples = 5;
    std::vector<view::ReceiverLayer> layers;
    for (int sample = 0; sample < 5; ++sample)
        layers.push_back(test::receivers_on(scene, kPoolFloor, true, sample));
    FrameStats stats;
    const auto together = test::draw_mesh(scene, Event::transmission, layers, stats);
    for (std::size_t i = 0; i < layers.size(); ++i)
        EXPECT_EQ(test::draw_mesh(scene, layers[i]).irradiance, together[i].irradiance) << i;
}

TEST(CausticMeshEdges, TheSunsDiscWidensPixelsByItsVariance) {
    // Half the water is hidden from the sun: E on the floor is a step, seen through the box that stands for
    // the disc: a ramp of width w, w^2 / 12 = R^2 / 4, R = (angle / 2) depth / n.
    scene::FrameScene scene = flat_pool(0, 600, 100);
    scene.state.water->absorption = {0, 0, 0};
    scene.state.lights[0].angular_diameter = glm::radians(20.0);
    scene.state.objects.push_back(test::plane_object({-5, 0.5, 0}, 10));
    const view::ReceiverLayer layer = test::receivers_on(scene, kPoolFloor, true);
    const methods::LayerResult result = test::draw_mesh(scene, layer);
    const double width = std::sqrt(3.0) * 0.5 * glm::radians(20.0) * 1.5 / test::kMeshIndex;
    double worst = 0;
    for (std::size_t x = 0; x < 100; ++x) {
        const std::size_t i = 50 * 100 + x;
        const double at = static_cast<double>(layer.position[i].x) + scene.origin.x;
        const double expected = std::clamp(at / width + 0.5, 0.0, 1.0);
        const double lit =
            under_flat_water(scene, kPoolFloor, glm::dvec3(layer.position[i]) + scene.origin).g;
        worst = std::max(worst, std::abs(static_cast<double>(result.irradiance[i].g) / lit - expected));
    }
    // The pixel's own box and the texel that the shadow's edge fades over: 2 cm against 34 cm.
    EXPECT_LT(worst, 0.03);
}

TEST(CausticMeshEdges, HardCasesAreFinite) {
    struct Case {
        const char* name;
        double zenith, depth;
        int resolution;
        double amplitude;  // m, of waves half a metre long, which focus at 2.5 m with 1 cm
    };
    double most = 0;
    for (const Case& hard :
         {Case{"focus", 0, 2.54, 300, 0.01}, Case{"at the surface", 30, 1e-6, 200, 0},
          Case{"sun at the horizon", 89.99, 1.5, 100, 0.01}, Case{"one ray", 20, 1.5, 1, 0.01},
          Case{"two rays", 20, 1.5, 2, 0.01}, Case{"steep waves", 20, 1.5, 150, 0.2}})
        for (const bool paper : {false, true}) {
            SCOPED_TRACE(hard.name);
            scene::FrameScene scene = flat_pool(hard.zenith, hard.resolution, 48);
            const double wave = glm::two_pi<double>() / 0.5;
            test::add_water(scene, {{hard.amplitude, {wave, 0}, 0}}, 200, 8);
            const test::Plane floor{{0, -hard.depth, 0}};
            scene.state.objects = {test::plane_object(floor.point, 60)};
            scene.state.caustics.map.paper_faithful = paper;
            const methods::LayerResult result =
                test::draw_mesh(scene, test::receivers_on(scene, floor, true));
            for (const glm::vec3& e : result.irradiance)
                for (int c = 0; c < 3; ++c) {
                    ASSERT_TRUE(std::isfinite(e[c]));
                    ASSERT_GE(e[c], 0);
                    most = std::max(most, static_cast<double>(e[c]));
                }
        }
    EXPECT_GT(most, 5 * flat_pool(0, 1, 1).state.lights[0].irradiance.r);
}

TEST(CausticMeshEdges, LightsOnlyReceiversInItsMediumThatFaceItOnItsPlane) {
    scene::FrameScene scene = flat_pool(0, 200, 8);
    scene.state.camera.view_height = 0.5;
    FrameStats stats;
    std::vector<view::ReceiverLayer> layers(8, test::receivers_on(scene, kPoolFloor, true));
    for (std::size_t i = 0; i < layers[0].pixels(); ++i) {
        layers[1].flags[i] = view::kReceiver;  // in the air
        layers[2].flags[i] |= view::kBehindSpecular;
        layers[3].shading_normal[i] = {0, -1, 0};
        layers[4].position[i].y += 0.1f;  // a shelf above the floor
        layers[5].shading_normal[i] = {1, 0, 0};
        layers[6].flags[i] = view::kEnvironment;
        layers[7].flags[i] = view::kReceiver | view::kInGlass;
    }
    const auto results = test::draw_mesh(scene, Event::transmission, layers, stats);
    for (std::size_t k = 0; k < layers.size(); ++k)
        for (std::size_t i = 0; i < layers[k].pixels(); ++i) {
            EXPECT_EQ(results[k].irradiance[i].g > 0, k == 0) << k;
            EXPECT_EQ(results[k].covered[i], k == 2 || k >= 6 ? 0 : 1) << k;
        }
}

}  // namespace
}  // namespace dapple
