// Ways through planes, boxes and spheres by formulas, against rays.
#include "methods/sliced_beams/shadow_shapes.h"

#include <gtest/gtest.h>

#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"

namespace dapple {
namespace {

using namespace methods::sliced_beams;

TEST(ShadowShapes, AgreeWithRays) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto point = [&](double size) {
        return size * glm::dvec3(uniform(random), uniform(random), uniform(random));
    };
    scene::FrameScene scene = test::scene_of_flat_water({4, 4}, 4, 4);
    scene.state.lights = {test::sun_from_zenith(30)};
    for (const scene::Shape shape : {scene::Shape::box, scene::Shape::sphere, scene::Shape::plane}) {
        for (int i = 0; i < 5; ++i) {
            scene::Object& object = scene.state.objects.emplace_back();
            object.shape = shape;
            object.size = 0.6 + 0.5 * point(1);
            object.radius = 0.4;
            object.transform.position = point(1.5);
            object.transform.rotation = point(3);
            object.transform.scale = 1.0 + 0.5 * point(1);
        }
    }
    const rays::RayScene rays(scene);
    light::BeamSheet<float> sheet;
    sheet.world_from_mesh = glm::dmat3(glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, 2, 3)));
    const ShadowShapes<float> shapes(scene, sheet);
    constexpr int kRounds = 5000;
    ObjectSet all = 0;
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) all |= object_bit(i);
    EXPECT_TRUE(shapes.knows(all));
    EXPECT_FALSE(shapes.knows(object_bit(100)));
    int blocked = 0, wrong = 0, within = 0, near = 0;
    for (int round = 0; round < kRounds; ++round) {
        PointLanes<float> from, to, near_from;
        std::vector<rays::Ray> ways;
        for (int lane = 0; lane < 8; ++lane) {
            const glm::dvec3 p = point(2), q = point(2);
            const auto put = [&](PointLanes<float>& lanes, glm::dvec3 world) {
                const glm::dvec3 v = world * sheet.world_from_mesh;
                lanes.a[lane] = static_cast<float>(v.x);
                lanes.b[lane] = static_cast<float>(v.y);
                lanes.depth[lane] = static_cast<float>(v.z);
            };
            put(from, p);
            put(near_from, glm::mix(p, q, 1e-3));
            put(to, q);
            ways.push_back({glm::vec3(p), 0, glm::vec3(q - p), 1});
        }
        std::vector<std::uint8_t> hidden(8, 0);
        rays.occluded_by_objects(ways, hidden);
        const Lanes<float> depth = shapes.depth(all, from, to), start = shapes.depth(all, from, near_from);
        for (int lane = 0; lane < 8; ++lane) {
            if (std::abs(depth[lane]) < 1e-5f) {
                ++near;
                continue;
            }
            blocked += hidden[static_cast<std::size_t>(lane)];
            if ((depth[lane] > 0) == (hidden[static_cast<std::size_t>(lane)] != 0)) continue;
            // Ways that do not leave the solid that they start in meet no surface.
            (start[lane] > 0 && depth[lane] > 0 ? within : wrong) += 1;
        }
    }
    printf("shapes: %d of %d ways blocked, %d wrong, %d within solids, %d too near to tell\n", blocked,
           8 * kRounds, wrong, within, near);
    EXPECT_EQ(wrong, 0);
    EXPECT_LT(within, kRounds / 100);
    EXPECT_GT(blocked, kRounds);
    EXPECT_LT(near, kRounds / 50);
}

}  // namespace
}  // namespace dapple
