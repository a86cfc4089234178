#include "methods/adaptive_beams/oracle.h"

#include "base/parallel.h"
#include "methods/adaptive_beams/oracle_judge.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr std::size_t kTile = 256;

}  // namespace

Verdicts judge(const OracleTask& task, std::span<const layout::OracleTexel> texels) {
    oracle_rules::Judge judge{task.vertices, task.ways, task.edges, task.triangles, texels};
    Verdicts verdicts;
    verdicts.edges.resize(task.edges.size());
    verdicts.triangles.resize(task.triangles.size());
    parallel_for(task.edges.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            verdicts.edges[i] = judge.edge_verdict_of(static_cast<std::uint32_t>(i), task.settings);
    });
    parallel_for(task.triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            verdicts.triangles[i] = judge.triangle_verdict_of(static_cast<std::uint32_t>(i), task.settings);
    });
    return verdicts;
}

}  // namespace dapple::methods::adaptive_beams
