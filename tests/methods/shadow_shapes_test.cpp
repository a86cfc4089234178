// Shadows of planes, boxes and spheres by formulas, against rays.
#include "methods/sliced_beams/shadow_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "scene/transform.h"

namespace dapple {
namespace {

using namespace methods::sliced_beams;

/// Whether a ray starts in a box or sphere that it does not leave.
bool starts_inside(const std::vector<scene::Object>& objects, const rays::Ray& ray) {
    return std::any_of(objects.begin(), objects.end(), [&](const scene::Object& object) {
        const glm::dmat4 from_world = glm::inverse(scene::world_from_object(object.transform));
        const auto holds = [&](glm::dvec3 world) {
            const glm::dvec3 p(from_world * glm::dvec4(world, 1));
            if (object.shape == scene::Shape::sphere) return glm::length(p) < object.radius;
            return object.shape == scene::Shape::box &&
                   glm::all(glm::lessThan(glm::abs(p), 0.5 * object.size));
        };
        return holds(glm::dvec3(ray.origin)) && holds(glm::dvec3(ray.origin + ray.direction));
    });
}

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
    const rays::RayScene traced(scene);
    light::BeamSheet<float> sheet;
    sheet.world_from_mesh = glm::dmat3(glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, 2, 3)));
    const ShadowShapes<float> shapes(scene, sheet);
    ObjectSet all = 0;
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) all |= object_bit(i);
    EXPECT_EQ(shapes.known() & all, all);
    EXPECT_EQ(shapes.known() & object_bit(100), 0u);
    constexpr int kRounds = 3000, kPlaces = 16;
    int blocked = 0, parted = 0, wrong = 0, within = 0, near = 0;
    for (int round = 0; round < kRounds; ++round) {
        // Both ends of the ways move by up to 10 cm on straight lines.
        WayLanes<float> ways;
        glm::dvec3 ends[8][2][2];
        for (int lane = 0; lane < 8; ++lane) {
            for (int end = 0; end < 2; ++end) {
                ends[lane][end][0] = point(2);
                ends[lane][end][1] = ends[lane][end][0] + point(0.1);
                for (int i = 0; i < 3; ++i) {
                    const glm::dvec3 v =
                        glm::mix(ends[lane][end][0], ends[lane][end][1], 0.5 * i) * sheet.world_from_mesh;
                    PointLanes<float>& lanes = end == 0 ? ways.from[i] : ways.to[i];
                    lanes.a[lane] = static_cast<float>(v.x);
                    lanes.b[lane] = static_cast<float>(v.y);
                    lanes.depth[lane] = static_cast<float>(v.z);
                }
            }
        }
        LitParts<float> lit(Mask<float>{} == 0);
        shapes.darken(all, ways, lit);
        std::vector<std::pair<float, float>> parts[8];
        lit.visit([&](const Lanes<float>& from, const Lanes<float>& to, const Mask<float>& lanes) {
            for (int lane = 0; lane < 8; ++lane)
                if (lanes[lane]) parts[lane].emplace_back(from[lane], to[lane]);
        });
        std::vector<rays::Ray> rays;
        for (const auto& way : ends) {
            for (int i = 0; i < kPlaces; ++i) {
                const double t = (i + 0.5) / kPlaces;
                const glm::dvec3 p = glm::mix(way[0][0], way[0][1], t), q = glm::mix(way[1][0], way[1][1], t);
                rays.push_back({glm::vec3(p), 0, glm::vec3(q - p), 1});
            }
        }
        std::vector<std::uint8_t> hidden(rays.size(), 0);
        traced.occluded_by_objects(rays, hidden);
        for (int lane = 0; lane < 8; ++lane) {
            parted += !parts[lane].empty() && parts[lane].front() != std::pair(-1.0f, 1.0f);
            for (int i = 0; i < kPlaces; ++i) {
                const float t = 2 * (static_cast<float>(i) + 0.5f) / kPlaces - 1;
                bool lights = false, close = false;
                for (const auto& [from, to] : parts[lane]) {
                    lights |= t > from && t < to;
                    // A thousandth of the interval: 0.1 mm.
                    close |=
                        (from > -1 && std::abs(t - from) < 2e-3f) || (to < 1 && std::abs(t - to) < 2e-3f);
                }
                const std::size_t ray = static_cast<std::size_t>(lane * kPlaces + i);
                blocked += hidden[ray];
                if (lights != (hidden[ray] != 0)) continue;
                if (close) {
                    ++near;
                    continue;
                }
                // Ways that do not leave the solid that they start in meet no surface.
                const bool inside = !lights && starts_inside(scene.state.objects, rays[ray]);
                (inside ? within : wrong) += 1;
            }
        }
    }
    printf("shapes: %d of %d ways blocked, %d intervals parted, %d wrong, %d within solids, %d near an end\n",
           blocked, 8 * kRounds * kPlaces, parted, wrong, within, near);
    // Margins are quadratics but for spheres, and where a way passes the direction of a box's face.
    EXPECT_LT(wrong, 8 * kRounds * kPlaces / 30000);
    EXPECT_LT(within, 8 * kRounds * kPlaces / 2000);
    EXPECT_GT(blocked, kRounds * kPlaces);
    EXPECT_GT(parted, kRounds / 10);
    EXPECT_LT(near, 8 * kRounds * kPlaces / 20000);
}

TEST(LitParts, AreWhatShadowsLeave) {
    // As many as there may be: lanes are parted in different order, and yet there is room for all of them.
    constexpr std::size_t kMost = LitParts<float>::kMostShadows;
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(-1.5f, 1.5f);
    for (const std::size_t count : {std::size_t{5}, std::size_t{63}, kMost}) {
        const float longest = 1.5f / static_cast<float>(count);
        for (int round = 0; round < 40; ++round) {
            LitParts<float> lit(Mask<float>{} == 0);
            std::array<Lanes<float>, kMost> first{}, last{};
            for (std::size_t i = 0; i < count; ++i) {
                for (int lane = 0; lane < 8; ++lane) {
                    first[i][lane] = uniform(random);
                    last[i][lane] = first[i][lane] + longest * uniform(random);  // half of them: nothing
                }
                lit.darken(first[i], last[i]);
            }
            std::size_t visited = 0;
            lit.visit([&](const auto&...) { ++visited; });
            ASSERT_LE(visited, count + 1);
            for (int lane = 0; lane < 8; ++lane) {
                for (float t = -0.999f; t < 1; t += 0.0137f) {
                    int parts = 0, shadows = 0;
                    lit.visit(
                        [&](const Lanes<float>& from, const Lanes<float>& to, const Mask<float>& lanes) {
                            parts += lanes[lane] && t > from[lane] && t < to[lane];
                        });
                    for (std::size_t i = 0; i < count; ++i)
                        shadows += t > first[i][lane] && t < last[i][lane];
                    ASSERT_EQ(parts, shadows == 0 ? 1 : 0) << round << " " << lane << " " << t;
                }
            }
        }
    }
}

}  // namespace
}  // namespace dapple
