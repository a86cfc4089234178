// What the device's rasteriser does at best: the figures that light passes are held against. 'Time' is wall
// time, 'CPU' that of all threads of the process, items_per_second primitives a CPU-second. Validation is
// off.
#include <benchmark/benchmark.h>

#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "gpu/pass_list.h"
#include "spirv/test_flat_frag.h"
#include "spirv/test_mesh_frag.h"
#include "spirv/test_mesh_vert.h"
#include "spirv/test_sprites_vert.h"

namespace dapple::gpu {
namespace {

constexpr int kSize = 1024;  // pixels a side of the targets

Device& shared_device() {
    static Device device(DeviceOptions{});
    return device;
}

/// Measures one draw. The first run, in which the driver compiles the shaders, is not counted.
void measure(benchmark::State& state, const RasterPipeline& pipeline, const Bindings& bindings,
             const Targets& targets, const Draw& draw, std::size_t primitives) {
    PassList passes(shared_device());
    const auto run = [&] {
        FrameStats stats;
        passes.draw("draw", pipeline, bindings, targets, draw);
        passes.run(stats);
    };
    run();
    for ([[maybe_unused]] auto _ : state) run();
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(primitives));
    state.SetLabel(shared_device().info().name);
}

/// A million squares of range(0) pixels in rows, as photons from a mesh land, added into RGBA32F.
void added_sprites(benchmark::State& state) {
    struct Sprite {  // as in test/sprites.vert
        glm::vec2 position;
        float width;
        glm::vec4 color;
    };
    constexpr int kSide = 1000;
    Device& device = shared_device();
    Buffer sprites(device, "sprites", sizeof(Sprite) * kSide * kSide);
    for (int i = 0; i < kSide * kSide; ++i)
        sprites.as<Sprite>()[static_cast<std::size_t>(i)] = {
            .position = (glm::vec2(i % kSide, i / kSide) + 0.5f) * (float(kSize) / kSide),
            .width = static_cast<float>(state.range(0)),
            .color = glm::vec4(1)};
    const RasterPipeline pipeline(device, "sprites", test_sprites_vert, test_flat_frag,
                                  {.interface = {.storage_buffers = 1, .push_bytes = sizeof(glm::vec2)},
                                   .topology = Topology::points,
                                   .blend = Blend::add,
                                   .color_formats = {Format::rgba32f}});
    const Image target(device, "target", kSize, kSize, Format::rgba32f);
    Bindings bindings{.buffers = {&sprites}};
    bindings.set_push(glm::vec2(kSize));
    measure(state, pipeline, bindings, {.colors = {&target}}, {.vertices = kSide * kSide}, kSide * kSide);
}

/// A wavy grid of range(0) x range(0) cells, two triangles each, into two RGBA32F targets and depth: a
/// caustic map.
void mesh(benchmark::State& state) {
    struct Vertex {  // as in test/mesh.vert
        glm::vec3 position;
        glm::vec3 normal;
    };
    const auto cells = static_cast<std::uint32_t>(state.range(0));
    const std::uint32_t side = cells + 1;
    Device& device = shared_device();
    Buffer vertices(device, "vertices", sizeof(Vertex) * side * side);
    for (std::uint32_t i = 0; i < side * side; ++i) {
        const glm::vec2 place = glm::vec2(i % side, i / side) * (2.0f / static_cast<float>(cells)) - 1.0f;
        vertices.as<Vertex>()[i] = {{place.x, 0.5f + 0.1f * std::sin(20 * place.x), place.y},
                                    {-2 * std::cos(20 * place.x), 1, 0}};
    }
    const std::uint32_t triangles = 2 * cells * cells;
    Buffer indices(device, "indices", sizeof(std::uint32_t) * 3 * triangles);
    auto next = indices.as<std::uint32_t>().begin();
    for (std::uint32_t row = 0; row < cells; ++row)
        for (std::uint32_t column = 0; column < cells; ++column) {
            const std::uint32_t a = row * side + column;
            for (const std::uint32_t corner : {a, a + side, a + 1, a + 1, a + side, a + side + 1})
                *next++ = corner;
        }
    const RasterPipeline pipeline(device, "mesh", test_mesh_vert, test_mesh_frag,
                                  {.interface = {.storage_buffers = 1},
                                   .color_formats = {Format::rgba32f, Format::rgba32f},
                                   .depth_test = true});
    const Image position(device, "position", kSize, kSize, Format::rgba32f);
    const Image normal(device, "normal", kSize, kSize, Format::rgba32f);
    const Image depth(device, "depth", kSize, kSize, Format::depth32f);
    measure(state, pipeline, {.buffers = {&vertices}}, {.colors = {&position, &normal}, .depth = &depth},
            {.vertices = 3 * triangles, .index_buffer = &indices}, triangles);
}

BENCHMARK(added_sprites)
    ->ArgName("px")
    ->Arg(2)
    ->Arg(4)
    ->Arg(8)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
// 1.0 and 2.0 million triangles.
BENCHMARK(mesh)->ArgName("cells")->Arg(708)->Arg(1000)->MeasureProcessCPUTime()->Unit(
    benchmark::kMillisecond);

}  // namespace
}  // namespace dapple::gpu
