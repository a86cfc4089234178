#include "view/camera.h"

#include <gtest/gtest.h>

#include <set>

namespace dapple::view {
namespace {

scene::Camera camera_of(scene::Projection projection) {
    scene::Camera camera;
    camera.projection = projection;
    camera.position = {1, 2, 3};
    camera.target = {-2, 0.5, -4};
    camera.field_of_view = 0.9;
    camera.view_height = 3;
    return camera;
}

TEST(Camera, PixelsStartAtTheTopLeft) {
    scene::Camera camera;
    camera.projection = scene::Projection::orthographic;
    camera.position = {0, 0, 5};
    camera.target = {0, 0, 0};
    camera.view_height = 2;
    const Camera view(camera, 4, 2);
    glm::dvec3 origin;
    glm::dvec3 direction;
    view.ray({0, 0}, origin, direction);
    EXPECT_EQ(origin, glm::dvec3(-2, 1, 5));
    EXPECT_EQ(direction, glm::dvec3(0, 0, -1));
    view.ray({3.5, 0.5}, origin, direction);
    EXPECT_EQ(origin, glm::dvec3(1.5, 0.5, 5));
    EXPECT_EQ(view.project({1.5, 0.5, 4}), glm::dvec3(3.5, 0.5, 1));

    camera.projection = scene::Projection::perspective;
    camera.field_of_view = M_PI / 2;
    const Camera central(camera, 4, 2);
    central.ray({0, 0}, origin, direction);
    EXPECT_EQ(origin, glm::dvec3(0, 0, 5));
    EXPECT_LT(length(direction - normalize(glm::dvec3(-2, 1, -1))), 1e-15);
}

TEST(Camera, LookingStraightDownHasMinusZOnTop) {
    scene::Camera camera;
    camera.position = {0, 3, 0};
    camera.target = {0, 0, 0};
    const Camera view(camera, 2, 2);
    EXPECT_GT(view.project({0, 0, -1}).y, -100);
    EXPECT_LT(view.project({0, 0, -1}).y, 1);
    EXPECT_GT(view.project({1, 0, 0}).x, 1);
}

TEST(Camera, ProjectUndoesRay) {
    for (const auto projection : {scene::Projection::perspective, scene::Projection::orthographic}) {
        const Camera view(camera_of(projection), 320, 180);
        for (double y = 0; y <= 180; y += 45) {
            for (double x = 0; x <= 320; x += 40) {
                glm::dvec3 origin;
                glm::dvec3 direction;
                view.ray({x, y}, origin, direction);
                EXPECT_NEAR(length(direction), 1, 1e-15);
                const glm::dvec3 point = origin + 7.0 * direction;
                const glm::dvec3 pixel = view.project(point);
                EXPECT_NEAR(pixel.x, x, 1e-10);
                EXPECT_NEAR(pixel.y, y, 1e-10);
                EXPECT_NEAR(pixel.z, 7 * dot(direction, view.forward()), 1e-12);
                const glm::dvec4 in_camera = view.camera_from_world() * glm::dvec4(point, 1);
                EXPECT_NEAR(in_camera.z, -pixel.z, 1e-12);
            }
        }
    }
}

TEST(Camera, RayDifferentialsAreThoseOfTheRays) {
    constexpr double kStep = 1e-3;  // pixels: truncation some 1e-12, round-off 1e-13 of lengths below 10
    for (const auto projection : {scene::Projection::perspective, scene::Projection::orthographic}) {
        const Camera view(camera_of(projection), 320, 180);
        const glm::dvec2 pixel(37.25, 151.5);
        glm::dvec3 origin_du, origin_dv, direction_du, direction_dv;
        view.ray_differentials(pixel, origin_du, origin_dv, direction_du, direction_dv);
        for (int axis = 0; axis < 2; ++axis) {
            glm::dvec2 step(0);
            step[axis] = kStep;
            glm::dvec3 o0, d0, o1, d1;
            view.ray(pixel - step, o0, d0);
            view.ray(pixel + step, o1, d1);
            const glm::dvec3& origin = axis == 0 ? origin_du : origin_dv;
            const glm::dvec3& direction = axis == 0 ? direction_du : direction_dv;
            EXPECT_LT(length((o1 - o0) / (2 * kStep) - origin), 1e-11);
            EXPECT_LT(length((d1 - d0) / (2 * kStep) - direction), 1e-11);
        }
    }
}

TEST(Camera, SampleOffsetsAreSpreadAboutTheCentre) {
    EXPECT_EQ(Camera::sample_offset(0, 1), glm::dvec2(0.5, 0.5));
    for (const int samples : {2, 3, 4, 7, 16, 64}) {
        glm::dvec2 sum(0);
        std::set<double> rows;
        for (int s = 0; s < samples; ++s) {
            const glm::dvec2 offset = Camera::sample_offset(s, samples);
            EXPECT_TRUE(offset.x >= 0 && offset.x < 1 && offset.y >= 0 && offset.y < 1);
            rows.insert(offset.y);
            sum += offset;
        }
        EXPECT_EQ(rows.size(), static_cast<std::size_t>(samples)) << "one sample a row";
        EXPECT_NEAR(sum.x / samples, 0.5, 1e-15);
        EXPECT_NEAR(sum.y / samples, 0.5, 1e-15);
    }
    // Four samples: one in each quarter of the pixel.
    std::set<std::pair<bool, bool>> quarters;
    for (int s = 0; s < 4; ++s) {
        const glm::dvec2 offset = Camera::sample_offset(s, 4);
        quarters.emplace(offset.x < 0.5, offset.y < 0.5);
    }
    EXPECT_EQ(quarters.size(), 4u);
}

TEST(Camera, SampleCellsTileThePixelAndHoldTheirSamples) {
    for (const int samples : {1, 2, 3, 4, 7, 8, 16, 64}) {
        std::set<std::pair<double, double>> corners;
        double area = 0;
        for (int s = 0; s < samples; ++s) {
            const Camera::SampleCell cell = Camera::sample_cell(s, samples);
            const glm::dvec2 inside = (Camera::sample_offset(s, samples) - cell.corner) / cell.size;
            EXPECT_TRUE(inside.x >= 0 && inside.x < 1 && inside.y >= 0 && inside.y < 1);
            corners.emplace(cell.corner.x, cell.corner.y);
            area += cell.size.x * cell.size.y;
        }
        EXPECT_EQ(corners.size(), static_cast<std::size_t>(samples)) << "each sample a cell of its own";
        EXPECT_NEAR(area, 1, 1e-15);
    }
}

}  // namespace
}  // namespace dapple::view
