// The smaller pictures that E is found in.
#include "render/buffer_scale.h"

#include <gtest/gtest.h>

#include "render/irradiance_pass.h"
#include "view/camera.h"

namespace dapple {
namespace {

scene::FrameScene picture(int width, int height, scene::Projection projection) {
    scene::FrameScene scene;
    scene.state.clip.width = width;
    scene.state.clip.height = height;
    scene.state.camera.projection = projection;
    scene.state.camera.position = {1, 2, 3};
    scene.state.camera.target = {0, -1, -2};
    return scene;
}

/// A place of the coarse picture is the one that the grid says in the fine one, also where the sizes do not
/// divide.
TEST(BufferScale, RaysAreThoseOfTheFinePicture) {
    for (const scene::Projection projection :
         {scene::Projection::perspective, scene::Projection::orthographic}) {
        for (const int scale : {2, 4}) {
            const scene::FrameScene fine = picture(33, 22, projection);
            const scene::FrameScene coarse = render::at_scale(fine, scale);
            const denoise::CoarseGrid grid = render::coarse_grid(fine, scale, 0);
            const scene::Clip& clip = coarse.state.clip;
            EXPECT_EQ(clip.width, scale == 2 ? 17 : 9);
            EXPECT_EQ(clip.height, scale == 2 ? 11 : 6);
            EXPECT_EQ(grid.margin, scale == 2 ? glm::dvec2(0.5, 0) : glm::dvec2(1.5, 1));
            const view::Camera a(fine.state.camera, 33, 22);
            const view::Camera b(coarse.state.camera, clip.width, clip.height);
            for (const glm::dvec2 place : {glm::dvec2(0, 0), glm::dvec2(4.25, 3.5), glm::dvec2(9, 6)}) {
                glm::dvec3 origin, direction, coarse_origin, coarse_direction;
                b.ray(place, coarse_origin, coarse_direction);
                a.ray(static_cast<double>(scale) * place - grid.margin, origin, direction);
                // Doubles of a tangent and its arc tangent.
                EXPECT_LT(length(origin - coarse_origin), 1e-14);
                EXPECT_LT(length(direction - coarse_direction), 1e-14);
            }
        }
    }
}

TEST(BufferScale, ValuesStandInTheMiddleOfTheirSamplesCell) {
    scene::FrameScene scene = picture(16, 16, scene::Projection::perspective);
    scene.state.clip.samples = 4;
    glm::dvec2 sum(0);
    for (int sample = 0; sample < 4; ++sample) {
        const denoise::CoarseGrid grid = render::coarse_grid(scene, 2, sample);
        EXPECT_LT(length(grid.place - view::Camera::sample_offset(sample, 4)), 0.25);
        sum += grid.place;
    }
    EXPECT_EQ(sum, glm::dvec2(2));  // the cells tile the pixel
}

TEST(BufferScale, HasItsPixels) {
    EXPECT_EQ(render::pixels_a_side(scene::BufferScale::full), 1);
    EXPECT_EQ(render::pixels_a_side(scene::BufferScale::half), 2);
    EXPECT_EQ(render::pixels_a_side(scene::BufferScale::quarter), 4);
}

TEST(WeakestLight, IsComparedWhereItMeetsTheWater) {
    scene::FrameState state;
    EXPECT_EQ(render::weakest_light(state), 0);
    scene::Light sun;
    sun.type = scene::LightType::sun;
    sun.irradiance = glm::dvec3(3);
    state.lights = {sun};
    EXPECT_FLOAT_EQ(render::weakest_light(state), 3);
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {5, -2, 1};
    lamp.intensity = glm::dvec3(8);
    state.lights.push_back(lamp);
    EXPECT_FLOAT_EQ(render::weakest_light(state), 2);  // 8 / 2^2
    state.lights[1].position.y = 0;
    state.lights.push_back(lamp);
    state.lights[2].intensity = glm::dvec3(0);
    EXPECT_FLOAT_EQ(render::weakest_light(state), 3);
}

}  // namespace
}  // namespace dapple
