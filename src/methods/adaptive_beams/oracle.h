#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "layout/beam_oracle.h"

namespace dapple::methods::adaptive_beams {

/// What the oracle looks at: a grid, its rays, and the light's view.
struct OracleTask {
    std::vector<layout::OracleVertex> vertices;
    std::vector<layout::OracleWay> ways;  ///< kOracleWays a vertex (shaders/adaptive_beams/oracle_rules.h)
    std::vector<layout::OracleEdge> edges;
    std::vector<layout::OracleTriangle> triangles;
    layout::OraclePush settings{};  ///< but for `count`
};

/// Why an edge or a triangle is split, by the names of oracle_rules.h; 0: it is kept.
struct Verdicts {
    std::vector<std::uint32_t> edges;
    std::vector<std::uint32_t> triangles;
};

/// Liktor and Dachsbacher's oracle (2011, 4.2) in their words on `texels`, settings.texels squared, row by
/// row.
Verdicts judge(const OracleTask& task, std::span<const layout::OracleTexel> texels);

/// The same by compute passes; differs from judge() only where rounding decides.
class OraclePass {
public:
    explicit OraclePass(gpu::Device& device);
    ~OraclePass();
    Verdicts judge(const OracleTask& task, std::span<const layout::OracleTexel> texels, FrameStats& stats);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods::adaptive_beams
