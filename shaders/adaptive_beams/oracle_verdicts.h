// The oracle's verdicts on edges and triangles by their numbers (oracle_rules.h stands before it). What they
// read are arrays: storage buffers in GLSL; in C++ the functions are members of a struct that has them.

FN uint edge_verdict_of(uint index, OraclePush push) {
    OracleEdge edge = edges[index];
    OracleVertex a = vertices[edge.first];
    uint verdict = edge_verdict(a, vertices[edge.second], vertices[edge.middle]);
    if (verdict != kKept || a.on_body == 0u || a.falloff + vertices[edge.second].falloff <= real(0.0))
        return verdict;
    for (uint w = 0u; w < kOracleWays; ++w)
        if (way_bends(ways[edge.first * kOracleWays + w], ways[edge.second * kOracleWays + w],
                      ways[edge.middle * kOracleWays + w], push))
            return kLanding;
    return kKept;
}

// Looks at all texels of the light's view whose middles the triangle holds: a body that the corners missed, a
// hole, edges in the picture that a spot throws, and waves shorter than the edges.
FN uint triangle_verdict_of(uint index, OraclePush push) {
    OracleTriangle triangle = triangles[index];
    OracleVertex a = vertices[triangle.corner[0]];
    OracleVertex b = vertices[triangle.corner[1]];
    OracleVertex c = vertices[triangle.corner[2]];
    uint met = a.on_body + b.on_body + c.on_body;
    bool any = met > 0u;
    for (uint i = 0u; i < 3u; ++i) any = any || vertices[edges[triangle.edge[i]].middle].on_body != 0u;

    real tolerance = real(1e9);
    bool dark = a.falloff + b.falloff + c.falloff <= real(0.0);
    if (met == 3u && !dark)
        for (uint w = 0u; w < kOracleWays; ++w)
            tolerance = min(tolerance, normal_tolerance(ways[triangle.corner[0] * kOracleWays + w],
                                                        ways[triangle.corner[1] * kOracleWays + w],
                                                        ways[triangle.corner[2] * kOracleWays + w],
                                                        w < 2u ? push.transmission : push.reflection, push));

    real last = real(push.texels) - real(1.0);
    uint left = uint(min(max(floor(min(min(a.uv.x, b.uv.x), c.uv.x)), real(0.0)), last));
    uint right = uint(min(max(floor(max(max(a.uv.x, b.uv.x), c.uv.x)), real(0.0)), last));
    uint top = uint(min(max(floor(min(min(a.uv.y, b.uv.y), c.uv.y)), real(0.0)), last));
    uint bottom = uint(min(max(floor(max(max(a.uv.y, b.uv.y), c.uv.y)), real(0.0)), last));
    real2 ab = b.uv - a.uv;
    real2 ac = c.uv - a.uv;
    real area = ab.x * ac.y - ab.y * ac.x;
    for (uint y = top; y <= bottom; ++y) {
        for (uint x = left; x <= right; ++x) {
            real dx = real(x) + real(0.5) - a.uv.x;
            real dy = real(y) + real(0.5) - a.uv.y;
            real of_b = (dx * ac.y - dy * ac.x) / area;
            real of_c = (ab.x * dy - ab.y * dx) / area;
            if (min(min(of_b, of_c), real(1.0) - of_b - of_c) < real(0.0)) continue;
            OracleTexel texel = texels[y * push.texels + x];
            any = any || texel.on_body != 0u;
            if (push.textured != 0u && texel.on_body != 0u) {
                real even = a.falloff + of_b * (b.falloff - a.falloff) + of_c * (c.falloff - a.falloff);
                if (abs(texel.light - even) > kFalloffError) return kHidden;
            }
            if (met != (texel.on_body != 0u ? 3u : 0u)) return dark ? kKept : kHidden;
            if (met == 0u || dark) continue;
            real3 normal = normalize(a.normal + of_b * (b.normal - a.normal) + of_c * (c.normal - a.normal));
            if (length(texel.normal - normal) > tolerance) return kHidden;
        }
    }
    return any ? kKept : kDiscarded;
}
