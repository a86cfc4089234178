#include "render/frame_scene_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include "base/error.h"
#include "grids/density_grid.h"
#include "image/exr.h"
#include "image/temporary_folder.h"
#include "render/texture_files.h"
#include "source_dir.h"

namespace dapple::render {
namespace {

/// Smoke, a box of fog, and the empty grid of the smoke's files.
scene::FrameState smoky(std::int64_t frame) {
    scene::FrameState state;
    state.clip.first_frame = 10;
    state.frame = frame;
    state.media.resize(3);
    state.media[0].file = DAPPLE_SOURCE_DIR "/sequences/assets/smoke/smoke.%04d.vdb";
    state.media[0].last_file = 24;
    state.media[1].type = scene::MediumType::box;
    state.media[2] = state.media[0];
    state.media[2].grid = "flame";
    return state;
}

TEST(FrameSceneBuilder, LoadsTheGridsOfTheFrame) {
    FrameSceneBuilder builder;
    const scene::FrameScene first = builder.build(smoky(10));
    ASSERT_EQ(first.medium_grids.size(), 3U);
    ASSERT_NE(first.medium_grids[0], nullptr);
    EXPECT_EQ(first.medium_grids[1], nullptr);
    EXPECT_EQ(first.medium_grids[2], nullptr);
    const scene::FrameScene last = builder.build(smoky(33));
    EXPECT_GT(last.medium_grids[0]->active_voxels(), 2 * first.medium_grids[0]->active_voxels());
}

TEST(FrameSceneBuilder, KeepsGridsOfTheFrameBefore) {
    FrameSceneBuilder builder;
    scene::FrameState state = smoky(10);
    state.media[0].step = 0.5;
    const auto first = builder.build(state).medium_grids[0];
    state.frame = 11;  // of the same file
    EXPECT_EQ(builder.build(state).medium_grids[0], first);
    state.frame = 12;
    EXPECT_NE(builder.build(state).medium_grids[0], first);
    state.frame = 10;  // gone meanwhile
    const auto again = builder.build(state).medium_grids[0];
    EXPECT_NE(again, first);
    EXPECT_EQ(again->active_voxels(), first->active_voxels());
}

TEST(FrameSceneBuilder, OneFileForTwoMediaIsLoadedOnce) {
    FrameSceneBuilder builder;
    scene::FrameState state = smoky(10);
    state.media[2] = state.media[0];
    const scene::FrameScene scene = builder.build(state);
    EXPECT_EQ(scene.medium_grids[0], scene.medium_grids[2]);
    const std::uint64_t once = builder.grid_bytes(smoky(10));
    EXPECT_EQ(builder.grid_bytes(state), once - 2 * 1304);  // the empty tree of "flame"
}

TEST(FrameSceneBuilder, FilesThatAreNotThere) {
    FrameSceneBuilder builder;
    scene::FrameState state = smoky(34);
    state.media[0].last_file = 99;
    EXPECT_THROW(builder.build(state), Error);
    EXPECT_THROW(builder.grid_bytes(state), Error);
    state.media[0].missing = scene::MissingGrid::empty;
    EXPECT_EQ(builder.build(state).medium_grids[0], nullptr);
    state.media[0].missing = scene::MissingGrid::hold;
    EXPECT_NE(builder.build(state).medium_grids[0], nullptr);
}

TEST(FrameSceneBuilder, GridsStayWithinTheirMemory) {
    FrameSceneBuilder builder;
    const scene::FrameState state = smoky(33);
    const std::uint64_t bytes = builder.grid_bytes(state);
    // The last file: two trees of 485 552 bytes, and the two of the empty grid.
    EXPECT_EQ(bytes, 2U * (485552 + 1304));
    builder.limit_grids(bytes / 2);
    try {
        builder.build(state);
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::out_of_memory_budget);
        EXPECT_THAT(error.what(), testing::HasSubstr("smoke.0024.vdb"));
    }
    builder.limit_grids(bytes);
    EXPECT_NE(builder.build(state).medium_grids[0], nullptr);
    scene::FrameState with_bricks = state;
    with_bricks.caustics.method = "adaptive_beams";
    // A texel of two bytes a voxel at least, in the texture and in what it is uploaded from.
    const auto voxels = builder.build(state).medium_grids[0]->active_voxels();
    EXPECT_GT(builder.grid_bytes(with_bricks), bytes + 4 * voxels);
}

TEST(FrameSceneBuilder, GlassIsMadeOfClosedMeshes) {
    FrameSceneBuilder builder;
    scene::FrameState state;
    state.objects.resize(1);
    state.objects[0].shape = scene::Shape::mesh;
    state.objects[0].file = DAPPLE_SOURCE_DIR "/tests/end_to_end/roof.obj";
    EXPECT_NE(builder.build(state).object_meshes[0], nullptr);
    state.objects[0].material.glass = true;
    for (int attempt = 0; attempt < 2; ++attempt) {
        try {
            builder.build(state);
            ADD_FAILURE();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::input_unreadable);
            EXPECT_THAT(error.what(), testing::HasSubstr("roof.obj: glass needs a closed mesh"));
        }
    }
}

std::string text_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// A spot 2 m above a pool of 8 m by 4 m, whose picture is 2 m wide on it.
scene::FrameState with_picture(const std::string& file) {
    scene::FrameState state;
    state.water.emplace().extent.size = {8, 4};
    scene::Light& light = state.lights.emplace_back();
    light.type = scene::LightType::spot;
    light.position = {0, 2, 0};
    light.cone_angle = std::atan(0.5);
    light.texture = file;
    return state;
}

TEST(FrameSceneBuilder, LoadsWhatSpotsThrow) {
    const test::TemporaryFolder folder;
    image::Image picture;
    picture.width = 2;
    picture.height = 1;
    picture.add("Y").values = {0.25f, 3.0f};
    image::write_exr_verified(folder / "a.exr", picture);
    scene::FrameState state = with_picture(folder / "a.exr");
    state.lights.emplace_back();
    FrameSceneBuilder builder;
    const scene::FrameScene scene = builder.build(state);
    ASSERT_EQ(scene.light_textures.size(), 2U);
    EXPECT_EQ(scene.light_textures[0]->rgb()[3], 3.0f);
    EXPECT_EQ(scene.light_textures[1], nullptr);
    EXPECT_EQ(builder.build(state).light_textures[0], scene.light_textures[0]) << "read twice";

    const auto message = [&](const std::string& file) -> std::string {
        try {
            check_light_textures(with_picture(file));
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::input_unreadable);
            return error.what();
        }
        return "no error";
    };
    EXPECT_EQ(message(folder / "a.exr"), "no error");
    EXPECT_THAT(message(folder / "none.exr"), testing::HasSubstr("none.exr: cannot be read"));
    picture.find("Y")->values[1] = -1;
    image::write_exr_verified(folder / "b.exr", picture);
    EXPECT_THAT(message(folder / "b.exr"),
                testing::HasSubstr("b.exr: light is not negative, which the texture is in 3 values, first at "
                                   "pixel 1,0"));
    // Our own writer lets no NaN pass: it is put where -1 was, in a row too short to be packed.
    std::string bytes = text_of(folder / "b.exr");
    const std::size_t place = bytes.rfind(std::string("\0\0\x80\xbf", 4));
    ASSERT_NE(place, std::string::npos);
    std::ofstream(folder / "c.exr", std::ios::binary)
        << bytes.replace(place, 4, std::string("\0\0\xc0\x7f", 4));
    EXPECT_THAT(message(folder / "c.exr"), testing::HasSubstr("c.exr: channel Y of the texture holds NaN"));
}

TEST(FrameSceneBuilder, MeshesOfTheWaterAreFineEnoughForLamps) {
    scene::FrameState state = with_picture("");
    state.lights[0].type = scene::LightType::point;
    const scene::FrameScene scene = FrameSceneBuilder().build(state);
    EXPECT_EQ(scene.water->columns, 101);
    EXPECT_EQ(scene.state.water->mesh_cells, 100) << "methods see what mesh there is";
}

}  // namespace
}  // namespace dapple::render
