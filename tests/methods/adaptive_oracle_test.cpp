#include "methods/adaptive_beams/oracle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>

#include "adaptive_scene.h"
#include "base/hash.h"
#include "light/gobo.h"
#include "methods/adaptive_beams/oracle_judge.h"
#include "methods/adaptive_beams/refinement.h"

namespace dapple::methods::adaptive_beams {
namespace {

using namespace oracle_rules;

/// Refined grids of the first light on a body, and what was met.
class Refined {
public:
    Refined(const scene::FrameScene& scene, int body, int levels, OraclePass* pass = nullptr)
        : rays_(scene),
          media_(scene),
          view_(LightViews(scene).of(0, scene.state.lights[0].direction, 1, body).at(0)),
          tracer_(scene, rays_, media_, view_, body, 3),
          refined_(refine(scene, tracer_, body, 16, levels, pass, stats_)) {}

    const ProjectedGrid& grid() const { return refined_.grid; }
    const VertexPaths& ray(std::uint32_t vertex) const { return refined_.rays.paths[vertex]; }
    const LightView& view() const { return view_; }
    std::size_t triangles() const { return grid().triangles().size(); }
    /// Of a triangle, in cells of the coarse grid: 1 is as it was.
    double size(const ProjectedGrid::Triangle& t) const {
        return 16 * glm::distance(grid().uv(t.vertices[1]), grid().uv(t.vertices[2]));
    }

private:
    rays::RayScene rays_;
    media::Media media_;
    LightView view_;
    PathTracer tracer_;
    FrameStats stats_;
    RefinedGrid refined_;
};

std::unique_ptr<scene::FrameScene> pool(double amplitude) {
    auto scene = std::make_unique<scene::FrameScene>();
    test::add_water(*scene, amplitude);
    scene->state.objects.push_back(test::floor_at(-2, 40));
    scene->state.lights.push_back(test::sun_at(70));
    return scene;
}

TEST(AdaptiveOracle, ShaderAndCodeSayTheSame) {
    gpu::Device device{gpu::DeviceOptions{}};
    OraclePass pass(device);
    // Random rays a metre or two long, near each other, so that every rule speaks.
    OracleTask task;
    std::uint64_t drawn = 0;
    const auto random = [&] { return static_cast<float>(hash_uniform(3, 1, ++drawn, 0)); };
    const auto point = [&] { return glm::vec3(random(), random(), random()); };
    constexpr std::uint32_t kVertices = 400;
    for (std::uint32_t i = 0; i < kVertices; ++i) {
        layout::OracleVertex v{};
        v.position = point();
        v.normal = glm::normalize(glm::vec3(-0.3F, 0.8F, -0.3F) + point());
        v.uv = 64.0F * glm::vec2(random(), random());
        v.depth = 3 + random();
        v.falloff = i % 7 == 0 ? random() : 1.0F;
        v.on_body = i % 11 != 0 ? 1 : 0;
        v.ends = i % 13 == 0 ? 2 : 1;
        task.vertices.push_back(v);
        for (std::uint32_t w = 0; w < kOracleWays; ++w)
            task.ways.push_back({point(), glm::normalize(glm::vec3(0, -9, 0) + point()), 2 * random(),
                                 random(), (i + w) % 5 == 0 ? 0u : 1u, 1u});
    }
    const auto any = [&] { return static_cast<std::uint32_t>(random() * kVertices); };
    for (int i = 0; i < 6000; ++i) task.edges.push_back({any(), any(), any()});
    for (int i = 0; i < 2000; ++i) {
        const auto e = static_cast<std::uint32_t>(3 * i);
        task.triangles.push_back({{any(), any(), any()}, {e, e + 1, e + 2}});
    }
    task.settings.camera = {0, 1, 20};
    task.settings.right = {1, 0, 0};
    task.settings.up = {0, 1, 0};
    task.settings.forward = {0, 0, -1};
    task.settings.half_tangent = {0.1F, 0.1F};
    task.settings.pixel_angle = 0.03F;
    task.settings.extinction = 0.02F;
    task.settings.tolerance = 1;
    task.settings.least_outline = 0.5F;
    task.settings.texel_size = 0.02F;
    task.settings.transmission = 0.25F;
    task.settings.reflection = 2;
    task.settings.texels = 64;
    std::vector<layout::OracleTexel> texels;
    for (int i = 0; i < 64 * 64; ++i)
        texels.push_back({glm::normalize(glm::vec3(0, 2, 0) + point()), i % 500 == 0 ? 0u : 1u,
                          i % 400 == 0 ? 0.5F : 1.0F});

    FrameStats stats;
    const Verdicts code = judge(task, texels), shader = pass.judge(task, texels, stats);
    const auto count = [](const std::vector<std::uint32_t>& verdicts, std::uint32_t verdict) {
        return std::count(verdicts.begin(), verdicts.end(), verdict);
    };
    for (const std::uint32_t verdict : {kKept, kSilhouette, kPaths, kNormals, kSpotEdge, kLanding})
        EXPECT_GT(count(code.edges, verdict), 10) << verdict;
    for (const std::uint32_t verdict : {kKept, kHidden}) EXPECT_GT(count(code.triangles, verdict), 10);
    const auto differing = [](const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
        return std::inner_product(a.begin(), a.end(), b.begin(), 0, std::plus<>(), std::not_equal_to<>());
    };
    // One in a thousand may lie within the rounding of a threshold; a triangle holds hundreds of texels, any
    // of which may.
    EXPECT_LE(differing(code.edges, shader.edges), 6);
    EXPECT_LE(differing(code.triangles, shader.triangles), 10);
    EXPECT_THAT(device.validation_messages(), testing::IsEmpty());

    // With a picture, whose texels differ from what the corners say.
    task.settings.textured = 1;
    const Verdicts of_picture = judge(task, texels);
    EXPECT_GT(count(of_picture.triangles, kHidden), count(code.triangles, kHidden) + 10);
    EXPECT_LE(differing(of_picture.triangles, pass.judge(task, texels, stats).triangles), 10);

    // And so for the grid of a frame.
    const auto scene = pool(0.01);
    const std::size_t by_code = Refined(*scene, light::kWater, 3).triangles();
    const std::size_t by_shader = Refined(*scene, light::kWater, 3, &pass).triangles();
    EXPECT_NEAR(static_cast<double>(by_shader) / static_cast<double>(by_code), 1, 0.002);
}

/// Two rays a metre long whose edge is 0.1 m wide at first and `width` at the end, where the ray between them
/// is off by `error`.
bool splits(float width, float error, float camera, float share) {
    const auto way = [&](float x, float end) {
        const glm::vec3 d = glm::normalize(glm::vec3(end - x, -1, 0));
        return layout::OracleWay{{x, 0, 0}, d, 1, share, 1, 0};
    };
    layout::OraclePush push{};
    push.camera = {0, -1, camera};
    push.pixel_angle = 1e-3F;
    push.tolerance = 0.05F;
    return way_bends(way(-0.05F, -0.5F * width), way(0.05F, 0.5F * width), way(0, error), push);
}

TEST(AdaptiveOracle, SplitsWhatConvergesIsStrongOrIsNear) {
    // 10 cm wide, and off by less than a twentieth of half of it.
    EXPECT_TRUE(splits(0.1F, 0.003F, 4, 1));
    EXPECT_FALSE(splits(0.1F, 0.002F, 4, 1));
    EXPECT_TRUE(splits(0.05F, 0.002F, 4, 1));     // converges
    EXPECT_FALSE(splits(0.4F, 0.003F, 4, 1));     // diverges
    EXPECT_FALSE(splits(0.1F, 0.003F, 4, 0.5F));  // is weaker
    // A pixel is 4 mm at 4 m, and 2 mm at 2 m.
    EXPECT_FALSE(splits(0.002F, 0.00015F, 4, 1));
    EXPECT_TRUE(splits(0.002F, 0.00015F, 2, 1));
}

TEST(AdaptiveOracle, LeavesWhatTheCameraDoesNotSee) {
    // A leg of 2 m along -z before an eye that looks along -z with 45 degrees to all sides.
    layout::OracleWay way{{0, 0, -1}, {0, 0, -1}, 2, 1, 1, 1};
    layout::OraclePush push{};
    push.right = {1, 0, 0};
    push.up = {0, 1, 0};
    push.forward = {0, 0, -1};
    push.half_tangent = {1, 1};
    push.pixel_angle = 0.01F;
    EXPECT_TRUE(in_view(way, 0.1F, push));
    for (const glm::vec3 start : {glm::vec3(4, 0, -1), {-4, 0, -1}, {0, 4, -1}, {0, 0, 3}}) {
        way.start = start;
        EXPECT_FALSE(in_view(way, 0.1F, push));
        EXPECT_TRUE(in_view(way, 4, push));
    }
    // From one side to the other, through the view.
    way = {{-4, 0, -2}, {1, 0, 0}, 8, 1, 1, 1};
    EXPECT_TRUE(in_view(way, 0.1F, push));
    // Water between dims what is there, and so makes pixels wide: at 5 m two optical depths of 0.4 / m.
    push.extinction = 0.4F;
    EXPECT_NEAR(pixel_at({0, 0, -5}, 0, 1, push), 0.05F * std::exp(2.0F), 1e-5);
    EXPECT_NEAR(pixel_at({0, 0, -5}, 0, 0, push), 0.05F, 1e-6);
    // A wide cell there may reach the camera.
    EXPECT_NEAR(pixel_at({0, 0, -5}, 6, 1, push), 0.01F * kNearestToCamera, 1e-6);
}

TEST(AdaptiveOracle, NearCamerasAskForMoreBeams) {
    const auto scene = pool(0.002);
    scene->state.clip.height = 270;
    std::vector<std::size_t> triangles;
    for (const double distance : {30.0, 9.0, 3.0}) {
        scene->state.camera.position = {0, -1, distance};
        triangles.push_back(Refined(*scene, light::kWater, 4).triangles());
    }
    EXPECT_LT(triangles[0], triangles[1]);
    EXPECT_LT(triangles[1], triangles[2]);
}

TEST(AdaptiveOracle, FindsWhatTheCoarseGridMisses) {
    // A lamp shade of 3 cm radius over flat water, whose coarse grid has rays 25 cm apart, 12.5 cm with those
    // in the middle of edges, and texels of 1.6 cm.
    const auto scene = pool(0);
    const glm::dvec3 center(0.31, 1, 0.33);
    scene->state.lights[0] = test::sun_at(90);
    scene::Object shade = test::glass_ball(center, 0.03, 1);
    shade.material.glass = false;
    scene->state.objects.push_back(shade);
    const Refined refined(*scene, light::kWater, 3);
    bool found = false;
    for (const ProjectedGrid::Triangle& t : refined.grid().triangles()) {
        const bool shaded = std::any_of(t.vertices.begin(), t.vertices.end(),
                                        [&](std::uint32_t v) { return !refined.ray(v).on_body; });
        found = found || shaded;
        // The finest triangles are an eighth of a cell; there are none away from the shade.
        const glm::dvec2 uv = refined.grid().uv(t.vertices[2]);
        const glm::dvec2 place = 4.0 * (uv - 0.5);
        const double distance = glm::distance(place, glm::dvec2(center.x, center.z));
        const bool finest = refined.size(t) < 0.13;
        EXPECT_TRUE(!finest || distance < 0.3);
        EXPECT_TRUE(!shaded || finest);
    }
    EXPECT_TRUE(found);
}

TEST(AdaptiveOracle, RefinesTheEdgeOfASpot) {
    const auto scene = pool(0);
    scene::Light spot;
    spot.type = scene::LightType::spot;
    spot.position = {0, 3, 0};
    spot.direction = {0, -1, 0};
    spot.cone_angle = 25 * scene::kDegree;
    spot.falloff_angle = 3 * scene::kDegree;
    scene->state.lights = {spot};
    const Refined refined(*scene, light::kWater, 3);
    const double cos_outer = std::cos(spot.cone_angle);
    const double cos_inner = std::cos(spot.cone_angle - spot.falloff_angle);
    double power = 0;
    std::size_t fine_inside = 0, ring = 0;
    for (const ProjectedGrid::Triangle& t : refined.grid().triangles()) {
        std::array<double, 3> falloff{};
        double least = 1, most = -1;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec2 uv = refined.grid().uv(t.vertices[i]);
            falloff[i] = refined.view().falloff(uv);
            const double cosine = glm::dot(refined.view().ray(uv).direction, spot.direction);
            least = std::min(least, cosine);
            most = std::max(most, cosine);
        }
        power += refined.view().extent(refined.grid().uv(t.vertices[0]), refined.grid().uv(t.vertices[1]),
                                       refined.grid().uv(t.vertices[2])) *
                 (falloff[0] + falloff[1] + falloff[2]) / 3;
        const bool in_ring = least < cos_inner && most > cos_outer;
        ring += in_ring && refined.size(t) < 0.3 ? 1 : 0;
        fine_inside += least > std::cos(15 * scene::kDegree) && refined.size(t) < 0.9 ? 1 : 0;
    }
    EXPECT_GT(ring, 500U);
    EXPECT_EQ(fine_inside, 0U);
    // Against the integral of the falloff over the cone. Within the inner cone it is 1, and linear
    // interpolation elsewhere is good to kFalloffError of the ring's share, a quarter of all.
    double expected = 2 * std::numbers::pi * (1 - cos_inner);
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
        const double cosine = cos_outer + (cos_inner - cos_outer) * (i + 0.5) / kSteps;
        expected += 2 * std::numbers::pi * (cos_inner - cos_outer) / kSteps *
                    optics::f64::spot_light_falloff(cosine, cos_outer, cos_inner);
    }
    EXPECT_NEAR(power / expected, 1, 2.5e-3);
}

TEST(AdaptiveOracle, RefinesTheEdgesOfAPicture) {
    const auto scene = pool(0);
    scene->state.lights = {test::spot({0, 3, 0}, {0, 0, 0}, 25)};
    // An edge at u = 0.6, and a line that no ray of the coarse grid meets, nor one half way between two.
    scene->light_textures = {test::picture(256, 256, [](float u, float) {
        return glm::vec3(u > 0.6F || (u > 0.318F && u < 0.324F) ? 0.2F : 1.0F);
    })};
    const Refined refined(*scene, light::kWater, 3);
    const double radius = std::tan(25 * scene::kDegree);
    std::size_t at_edge = 0, at_line = 0, coarse = 0;
    for (const ProjectedGrid::Triangle& t : refined.grid().triangles()) {
        double low = 1, high = 0, farthest = 0;
        for (const std::uint32_t vertex : t.vertices) {
            const glm::dvec3 way = refined.view().ray(refined.grid().uv(vertex)).direction;
            const double u = 0.5 + 0.5 * way.x / -way.y / radius;
            low = std::min(low, u);
            high = std::max(high, u);
            farthest = std::max(farthest, std::hypot(way.x, way.z) / -way.y / radius);
        }
        if (farthest > 0.85) continue;  // the edge of the cone is refined too
        const bool finest = refined.size(t) < 0.13;
        if (low < 0.6 && high > 0.6) {
            ++at_edge;
            EXPECT_TRUE(finest);
        } else if (low < 0.321 && high > 0.32) {
            ++at_line;
            EXPECT_TRUE(finest);
        } else if (low > 0.7 || (low > 0.42 && high < 0.5)) {
            EXPECT_FALSE(finest);
            ++coarse;
        }
    }
    EXPECT_GT(at_edge, 50U);
    EXPECT_GT(at_line, 20U);
    EXPECT_GT(coarse, 20U);
}

TEST(AdaptiveOracle, FewerBeamsThanARegularGridAsFine) {
    // A ball over the floor: most of its inside bends little, its outline much.
    auto scene = std::make_unique<scene::FrameScene>();
    scene->state.objects = {test::glass_ball({0, 1, 0}, 0.4, 1.5), test::floor_at(0, 10)};
    scene->state.lights.push_back(test::sun_at(90));
    scene->state.camera.position = {0, 2, 8};
    scene->state.clip.height = 270;
    const std::size_t adaptive = Refined(*scene, 0, 3).triangles();
    EXPECT_GT(adaptive, 2U * 32 * 32);
    EXPECT_LT(adaptive, 2U * 128 * 128 / 2);
}

}  // namespace
}  // namespace dapple::methods::adaptive_beams
