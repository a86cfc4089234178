#include <algorithm>
#include <limits>
#include <string>

#include "gpu/pass_list.h"
#include "gpu/pipeline.h"
#include "gpu/resource.h"
#include "methods/adaptive_beams/oracle.h"
#include "spirv/adaptive_beams_oracle_edge_comp.h"
#include "spirv/adaptive_beams_oracle_triangle_comp.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr std::uint32_t kGroup = 64;  // local_size_x of oracle_buffers.glsl
constexpr gpu::Interface kInterface{
    .storage_buffers = 6, .sampled_images = 0, .push_bytes = sizeof(layout::OraclePush)};
static_assert(sizeof(layout::OraclePush) == 112);
static_assert(sizeof(layout::OracleVertex) == 48);
static_assert(sizeof(layout::OracleWay) == 40);

template <class T>
gpu::Buffer filled(gpu::Device& device, std::string_view name, std::span<const T> values) {
    gpu::Buffer buffer(device, name, std::max<std::size_t>(1, values.size()) * sizeof(T));
    std::copy(values.begin(), values.end(), buffer.as<T>().begin());
    return buffer;
}

}  // namespace

struct OraclePass::State {
    explicit State(gpu::Device& to)
        : device(to),
          edge(to, "oracle, edges", adaptive_beams_oracle_edge_comp, kInterface),
          triangle(to, "oracle, triangles", adaptive_beams_oracle_triangle_comp, kInterface) {}
    gpu::Device& device;
    gpu::ComputePipeline edge;
    gpu::ComputePipeline triangle;
};

OraclePass::OraclePass(gpu::Device& device) : state_(std::make_unique<State>(device)) {}
OraclePass::~OraclePass() = default;

Verdicts OraclePass::judge(const OracleTask& task, std::span<const layout::OracleTexel> texels,
                           FrameStats& stats) {
    gpu::Device& device = state_->device;
    const gpu::Buffer vertices = filled<layout::OracleVertex>(device, "oracle vertices", task.vertices);
    const gpu::Buffer ways = filled<layout::OracleWay>(device, "oracle ways", task.ways);
    const gpu::Buffer edges = filled<layout::OracleEdge>(device, "oracle edges", task.edges);
    const gpu::Buffer triangles = filled<layout::OracleTriangle>(device, "oracle triangles", task.triangles);
    const gpu::Buffer view = filled<layout::OracleTexel>(device, "light's view", texels);
    Verdicts verdicts;
    verdicts.edges.resize(task.edges.size());
    verdicts.triangles.resize(task.triangles.size());
    gpu::Buffer of_edges = filled<std::uint32_t>(device, "verdicts on edges", verdicts.edges);
    gpu::Buffer of_triangles = filled<std::uint32_t>(device, "verdicts on triangles", verdicts.triangles);

    gpu::PassList passes(device);
    const auto add = [&](const char* name, const gpu::ComputePipeline& pipeline, const gpu::Buffer& result,
                         std::size_t count) {
        layout::OraclePush push = task.settings;
        push.count = static_cast<std::uint32_t>(count);
        gpu::Bindings bindings{.buffers = {&vertices, &ways, &edges, &triangles, &view, &result},
                               .writes = {&result}};
        bindings.set_push(push);
        passes.compute(name, pipeline, std::move(bindings), {(push.count + kGroup - 1) / kGroup, 1, 1});
    };
    add("oracle, edges", state_->edge, of_edges, verdicts.edges.size());
    add("oracle, triangles", state_->triangle, of_triangles, verdicts.triangles.size());
    passes.run(stats);
    std::copy_n(of_edges.as<std::uint32_t>().begin(), verdicts.edges.size(), verdicts.edges.begin());
    std::copy_n(of_triangles.as<std::uint32_t>().begin(), verdicts.triangles.size(),
                verdicts.triangles.begin());
    return verdicts;
}

}  // namespace dapple::methods::adaptive_beams
