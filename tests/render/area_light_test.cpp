// Light of quads and discs that meets no water, against Lambert's closed forms.
#include <gtest/gtest.h>

#include <array>

#include "closed_form/flat_scene.h"
#include "light/emitters.h"
#include "render/flat_water.h"
#include "render/shading.h"

namespace dapple {
namespace {

/// E on a level floor at the origin, of the mean over a pixel's camera samples, by a panel cut into parts.
double found(const scene::Light& panel, int camera_samples, const std::vector<scene::Object>& objects = {}) {
    scene::FrameScene scene;
    scene.state.lights = {panel};
    scene.state = scene::with_emitter_parts(scene.state);
    scene.state.clip.samples = camera_samples;
    scene.state.objects = objects;
    scene.object_meshes.resize(objects.size());
    const rays::RayScene rays(scene);
    double sum = 0;
    for (int sample = 0; sample < camera_samples; ++sample) {
        view::ReceiverLayer layer;
        layer.width = layer.height = 1;
        layer.sample = sample;
        layer.flags = {view::kReceiver};
        layer.object = {0};
        layer.position = {glm::vec3(0)};
        layer.geometric_normal = layer.shading_normal = {glm::vec3(0, 1, 0)};
        sum += static_cast<double>(render::direct_irradiance(scene, media::Media(scene), rays, layer)[0].x);
    }
    return sum / camera_samples;
}

/// Lambert's formula for E by a polygon of radiance 1, seen from the origin on a level plane that faces up:
/// half the sum of the angles of its edges times the cosine of their planes' normals.
double of_polygon(const std::vector<glm::dvec3>& corners) {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = glm::normalize(corners[i]),
                         b = glm::normalize(corners[(i + 1) % corners.size()]);
        sum += std::acos(glm::dot(a, b)) * glm::normalize(glm::cross(a, b)).y;
    }
    return 0.5 * std::abs(sum);
}

TEST(AreaLight, OfADiscOverItsAxis) {
    // pi L R^2 / (R^2 + h^2)
    const double expected = std::numbers::pi * 3 * 0.36 / (0.36 + 1);
    double last = 1;
    for (const int samples : {4, 16, 64, 256}) {
        const double error = std::abs(found(test::disc_panel({0, 1, 0}, 0.6, samples), 1) / expected - 1);
        EXPECT_LT(error, 0.3 * last) << "falls with the size of the parts squared";
        last = error;
    }
    EXPECT_LT(last, 1e-3);
    // The points of 16 camera samples are other ones.
    EXPECT_NEAR(found(test::disc_panel({0, 1, 0}, 0.6, 16), 16) / expected, 1, 2e-3);
}

TEST(AreaLight, OfAQuadFromAside) {
    scene::Light panel = test::quad_panel({0.7, 1, -0.4}, {1, 0.6}, 256);
    std::vector<glm::dvec3> corners;
    for (const glm::dvec2 c : {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)})
        corners.push_back(panel.position + 0.5 * glm::dvec3(c.x * panel.size.x, 0, c.y * panel.size.y));
    EXPECT_NEAR(found(panel, 1) / (3 * of_polygon(corners)), 1, 1e-4);
    // Tilted about z, so that some of its light leaves beside the floor.
    const double lean = 40 * scene::kDegree;
    panel.direction = {-std::sin(lean), -std::cos(lean), 0};
    const scene::LightFrame frame = scene::light_frame(panel);
    corners.clear();
    for (const glm::dvec2 c : {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)})
        corners.push_back(panel.position +
                          0.5 * (c.x * panel.size.x * frame.right + c.y * panel.size.y * frame.up));
    EXPECT_NEAR(found(panel, 1) / (3 * of_polygon(corners)), 1, 5e-4);
}

TEST(AreaLight, ShinesToOneSide) {
    scene::Light panel = test::quad_panel({0, 1, 0}, {1, 1}, 4);
    panel.direction = {0, 1, 0};
    EXPECT_EQ(found(panel, 1), 0);
}

TEST(AreaLight, IsHalfHiddenByAnEdgeBelowItsMiddle) {
    // A plate that hides one half of the disc from the origin, 3 x 3 cm of whose light would pass no more.
    scene::Object plate = test::level_plane("plate", 0.5, 4);
    plate.transform.position.x = 2;
    const scene::Light panel = test::disc_panel({0, 1, 0}, 0.6, 64);
    EXPECT_NEAR(found(panel, 4, {plate}) / found(panel, 4), 0.5, 0.01);
    // 7 in 8 of the disc's width.
    plate.transform.position.x = 2 - 0.225;
    const auto light_of = [&](double edge) {
        return test::over_panel(panel, [&](glm::dvec3 from) {
            return from.x < edge ? 1 / std::pow(glm::dot(from, from), 2) : 0.0;
        });
    };
    EXPECT_NEAR(found(panel, 16, {plate}) / found(panel, 16), light_of(-0.45) / light_of(1), 0.01);
}

TEST(AreaLight, ThroughFlatWaterIsThatOfItsPoints) {
    scene::Light panel = test::disc_panel({0, 2, 0}, 0.5, 16);
    scene::FrameState state;
    state.lights = {panel};
    double sum = 0, expected = 0;
    for (const scene::Light& part : scene::with_emitter_parts(state).lights) {
        const auto flat = render::through_flat_water(part, {0.3, -1, 0.2}, 1.333);
        sum += flat->transport;
        scene::Light lamp = part;
        lamp.type = scene::LightType::point;
        const auto point = render::through_flat_water(lamp, {0.3, -1, 0.2}, 1.333);
        expected += -point->from.y * point->transport;
    }
    EXPECT_NEAR(sum, expected, 1e-14);
}

}  // namespace
}  // namespace dapple
