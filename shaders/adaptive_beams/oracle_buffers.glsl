// What both passes of the oracle read: a grid, its rays, and the light's view.
#include "layout/beam_oracle.h"
#include "optics/language.h"
#include "adaptive_beams/oracle_rules.h"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Vertices { OracleVertex vertices[]; };
layout(scalar, binding = 1) readonly buffer Ways { OracleWay ways[]; };
layout(scalar, binding = 2) readonly buffer Edges { OracleEdge edges[]; };
layout(scalar, binding = 3) readonly buffer Triangles { OracleTriangle triangles[]; };
layout(scalar, binding = 4) readonly buffer Texels { OracleTexel texels[]; };
layout(scalar, binding = 5) writeonly buffer Verdicts { uint verdicts[]; };
layout(scalar, push_constant) uniform Push { OraclePush settings; };

#include "adaptive_beams/oracle_verdicts.h"
