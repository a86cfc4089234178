#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <utility>

#include "base/hash.h"
#include "gpu/pass_list.h"
#include "gpu/validated_device.h"
#include "spirv/test_flat_frag.h"
#include "spirv/test_quads_vert.h"
#include "spirv/test_sprites_vert.h"
#include "spirv/test_two_targets_frag.h"

namespace dapple::gpu {
namespace {

struct Vertex {  // as in test/quads.vert
    glm::vec3 position;
    glm::vec4 color;
};

struct Sprite {  // as in test/sprites.vert
    glm::vec2 position;
    float width;
    glm::vec4 color;
};

/// Two triangles over [a, b] (pixels from the top left).
void add_quad(std::vector<Vertex>& vertices, glm::vec2 a, glm::vec2 b, float depth, glm::vec4 color) {
    for (const glm::vec2 corner : {a, glm::vec2(b.x, a.y), b, a, b, glm::vec2(a.x, b.y)})
        vertices.push_back({{corner, depth}, color});
}

template <class T>
Buffer filled_buffer(Device& device, std::string_view name, const std::vector<T>& values) {
    Buffer buffer(device, name, values.size() * sizeof(T));
    std::copy(values.begin(), values.end(), buffer.as<T>().begin());
    return buffer;
}

constexpr int kSize = 64;  // a power of two, so that pixel positions survive clip space exactly

class Raster : public ::testing::Test {
protected:
    Device& device = test::validated_device();
    Image color{device, "color", kSize, kSize, Format::rgba32f};
    Image depth{device, "depth", kSize, kSize, Format::depth32f};
    Buffer pixels{device, "pixels", kSize* kSize * sizeof(glm::vec4)};
    FrameStats stats;

    RasterPipeline quad_pipeline(Blend blend, bool depth_test = false) {
        return {device,
                "quads",
                test_quads_vert,
                test_flat_frag,
                {.interface = {.storage_buffers = 1, .push_bytes = sizeof(glm::vec2)},
                 .blend = blend,
                 .color_formats = {Format::rgba32f},
                 .depth_test = depth_test}};
    }
    static Bindings bound(const Buffer& buffer) {
        Bindings bindings{.buffers = {&buffer}};
        bindings.set_push(glm::vec2(kSize));
        return bindings;
    }
    glm::vec4 pixel(int x, int y) { return pixels.as<glm::vec4>()[static_cast<std::size_t>(y * kSize + x)]; }
    void draw_quads(const std::vector<Vertex>& vertices, Blend blend) {
        const Buffer buffer = filled_buffer(device, "vertices", vertices);
        const RasterPipeline pipeline = quad_pipeline(blend);
        PassList passes(device);
        passes.draw("quads", pipeline, bound(buffer), {.colors = {&color}},
                    {.vertices = static_cast<std::uint32_t>(vertices.size())});
        passes.copy("read back", color, pixels);
        passes.run(stats);
    }
};

TEST_F(Raster, YPointsDownAndAQuadCoversItsPixels) {
    std::vector<Vertex> vertices;
    add_quad(vertices, {2, 1}, {5, 9}, 0, {1, 2, 3, 4});
    draw_quads(vertices, Blend::none);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const bool inside = x >= 2 && x < 5 && y >= 1 && y < 9;
            ASSERT_EQ(pixel(x, y), inside ? glm::vec4(1, 2, 3, 4) : glm::vec4(0)) << x << ", " << y;
        }
}

TEST_F(Raster, QuadsThatShareEdgesCoverEachPixelOnce) {
    // Edges between pixels, and edges through pixel centres, where the fill rule decides (top and left edges
    // belong to a quad): then the pixels of the last row and column belong to nobody.
    for (const float offset : {0.0f, 0.5f}) {
        std::vector<Vertex> vertices;
        for (float y = 0; y + 4 <= kSize; y += 4)
            for (float x = 0; x + 4 <= kSize; x += 4)
                add_quad(vertices, glm::vec2(x, y) + offset, glm::vec2(x + 4, y + 4) + offset, 0,
                         glm::vec4(1));
        draw_quads(vertices, Blend::add);
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x)
                ASSERT_EQ(pixel(x, y), glm::vec4(1)) << offset << ": " << x << ", " << y;
    }
}

TEST_F(Raster, DepthTestKeepsTheNearestAndLetsEqualDepthsPass) {
    std::vector<Vertex> vertices;
    add_quad(vertices, {0, 0}, {kSize, kSize}, 0.5f, glm::vec4(1));
    add_quad(vertices, {0, 0}, {kSize / 2, kSize}, 0.75f, glm::vec4(2));             // hidden
    add_quad(vertices, {kSize / 2, 0}, {kSize, kSize / 2}, 0.25f, glm::vec4(3));     // in front
    add_quad(vertices, {kSize / 2, kSize / 2}, {kSize, kSize}, 0.5f, glm::vec4(4));  // equal: the later one
    const Buffer buffer = filled_buffer(device, "vertices", vertices);
    const RasterPipeline pipeline = quad_pipeline(Blend::none, true);
    Buffer depths(device, "depths", kSize * kSize * sizeof(float));
    PassList passes(device);
    // The second draw keeps what the first left in both targets.
    const Buffer second =
        filled_buffer(device, "second", std::vector<Vertex>(vertices.begin() + 6, vertices.end()));
    passes.draw("first", pipeline, bound(buffer), {.colors = {&color}, .depth = &depth}, {.vertices = 6});
    passes.draw("second", pipeline, bound(second), {.colors = {&color}, .depth = &depth, .clear = false},
                {.vertices = 18});
    passes.copy("read colours", color, pixels);
    passes.copy("read depths", depth, depths);
    passes.run(stats);
    const int low = 5;
    const int high = kSize - 5;
    EXPECT_EQ(pixel(low, low).x, 1);
    EXPECT_EQ(pixel(low, high).x, 1);
    EXPECT_EQ(pixel(high, low).x, 3);
    EXPECT_EQ(pixel(high, high).x, 4);
    EXPECT_EQ(depths.as<float>()[low * kSize + high], 0.25f);
    EXPECT_EQ(depths.as<float>()[high * kSize + high], 0.5f);
}

TEST_F(Raster, IndicesPickVertices) {
    std::vector<Vertex> corners;
    for (const glm::vec2 corner : {glm::vec2(0, 0), glm::vec2(8, 0), glm::vec2(0, 8), glm::vec2(8, 8)})
        corners.push_back({{corner, 0}, glm::vec4(1)});
    const Buffer vertices = filled_buffer(device, "vertices", corners);
    const Buffer indices = filled_buffer(device, "indices", std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3});
    const RasterPipeline pipeline = quad_pipeline(Blend::add);
    PassList passes(device);
    passes.draw("quad", pipeline, bound(vertices), {.colors = {&color}},
                {.vertices = 6, .index_buffer = &indices});
    passes.copy("read back", color, pixels);
    passes.run(stats);
    for (int y = 0; y < 10; ++y)
        for (int x = 0; x < 10; ++x) ASSERT_EQ(pixel(x, y).x, x < 8 && y < 8 ? 1 : 0) << x << ", " << y;
}

TEST_F(Raster, SeveralTargetsOfDifferentFormats) {
    std::vector<Vertex> vertices;
    add_quad(vertices, {0, 0}, {kSize, kSize}, 0, {1, 2, 3, 4});
    const Buffer buffer = filled_buffer(device, "vertices", vertices);
    const RasterPipeline pipeline(device, "two targets", test_quads_vert, test_two_targets_frag,
                                  {.interface = {.storage_buffers = 1, .push_bytes = sizeof(glm::vec2)},
                                   .color_formats = {Format::rgba32f, Format::r32u}});
    const Image places(device, "places", kSize, kSize, Format::r32u);
    Buffer read(device, "read", kSize * kSize * sizeof(std::uint32_t));
    PassList passes(device);
    passes.draw("both", pipeline, bound(buffer), {.colors = {&color, &places}}, {.vertices = 6});
    passes.copy("read colours", color, pixels);
    passes.copy("read places", places, read);
    passes.run(stats);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            ASSERT_EQ(pixel(x, y), glm::vec4(2, 4, 6, 8));
            ASSERT_EQ(read.as<std::uint32_t>()[static_cast<std::size_t>(y * kSize + x)],
                      static_cast<std::uint32_t>(x + 1000 * y));
        }
}

TEST_F(Raster, AddedSpritesHaveTheBitsOfASumInTheirOrder) {
    if (device.largest_point_size() < 8) GTEST_SKIP() << "the device has no large points";
    // Positions a quarter off the pixels, so that no pixel's centre lies on a sprite's edge.
    std::vector<Sprite> sprites;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const auto random = [i](std::uint32_t dimension) { return hash_uniform(1, 0, i, dimension); };
        sprites.push_back(
            {.position = {std::floor(random(0) * kSize) + 0.25, std::floor(random(1) * kSize) + 0.25},
             .width = static_cast<float>(1 + std::floor(random(2) * 8)),
             .color = {random(3), random(4) * 1e-3, random(5) * 1e3, 1}});
    }
    std::vector<glm::vec4> expected(kSize * kSize, glm::vec4(0));
    const auto first_inside = [](float edge) { return static_cast<int>(std::ceil(edge - 0.5f)); };
    for (const Sprite& sprite : sprites) {
        const glm::vec2 low = sprite.position - sprite.width / 2;
        const glm::vec2 high = sprite.position + sprite.width / 2;
        for (int y = std::max(0, first_inside(low.y)); y < std::min(kSize, first_inside(high.y)); ++y)
            for (int x = std::max(0, first_inside(low.x)); x < std::min(kSize, first_inside(high.x)); ++x)
                expected[static_cast<std::size_t>(y * kSize + x)] += sprite.color;
    }
    const Buffer buffer = filled_buffer(device, "sprites", sprites);
    const RasterPipeline pipeline(device, "sprites", test_sprites_vert, test_flat_frag,
                                  {.interface = {.storage_buffers = 1, .push_bytes = sizeof(glm::vec2)},
                                   .topology = Topology::points,
                                   .blend = Blend::add,
                                   .color_formats = {Format::rgba32f}});
    for (int run = 0; run < 2; ++run) {
        PassList passes(device);
        passes.draw("sprites", pipeline, bound(buffer), {.colors = {&color}},
                    {.vertices = static_cast<std::uint32_t>(sprites.size())});
        passes.copy("read back", color, pixels);
        passes.run(stats);
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x)
                ASSERT_EQ(pixel(x, y), expected[static_cast<std::size_t>(y * kSize + x)]) << x << ", " << y;
    }
}

TEST_F(Raster, WrongTargetsAreRefusedWithASentence) {
    const RasterPipeline pipeline = quad_pipeline(Blend::none);
    const Buffer vertices(device, "vertices", 6 * sizeof(Vertex));
    const Image small(device, "small", 8, 8, Format::rgba32f);
    const Image scalar(device, "scalar", kSize, kSize, Format::r32f);
    PassList passes(device);
    const auto draw = [&](Targets targets) {
        passes.draw("draw", pipeline, bound(vertices), std::move(targets), {.vertices = 6});
    };
    EXPECT_THROW(draw({}), std::logic_error);
    EXPECT_THROW(draw({.colors = {&color, &small}}), std::logic_error);
    EXPECT_THROW(draw({.colors = {&scalar}}), std::logic_error);
    EXPECT_THROW(draw({.colors = {&color}, .depth = &depth}), std::logic_error);
    const auto make = [&](std::vector<Format> formats) {
        return RasterPipeline(device, "bad", test_quads_vert, test_flat_frag,
                              {.blend = Blend::add, .color_formats = std::move(formats)});
    };
    EXPECT_THROW(make({Format::depth32f}), std::logic_error);
    EXPECT_THROW(make({Format::r32u}), std::logic_error);
}

}  // namespace
}  // namespace dapple::gpu
