#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <span>

#include "layout/beam_oracle.h"
#include "optics/optics.h"

/// The oracle's rules in C++, in float as the device has them.
namespace dapple::methods::adaptive_beams::oracle_rules {

using real = float;
using real2 = glm::vec2;
using real3 = glm::vec3;
using glm::abs;
using glm::dot;
using glm::exp;
using glm::floor;
using glm::inversesqrt;
using glm::length;
using glm::max;
using glm::min;
using glm::normalize;
using layout::OracleEdge;
using layout::OraclePush;
using layout::OracleTexel;
using layout::OracleTriangle;
using layout::OracleVertex;
using layout::OracleWay;
using layout::uint;

#include "adaptive_beams/oracle_rules.h"

struct Judge {
    std::span<const OracleVertex> vertices;
    std::span<const OracleWay> ways;
    std::span<const OracleEdge> edges;
    std::span<const OracleTriangle> triangles;
    std::span<const OracleTexel> texels;

#include "adaptive_beams/oracle_verdicts.h"
};

}  // namespace dapple::methods::adaptive_beams::oracle_rules
