// The oracle's verdicts on edges and triangles by their numbers (oracle_rules.h stands before it). What they
// read are arrays: storage buffers in GLSL; in C++ the functions are members of a struct that has them.

// Pixels that cells of a size, m, about the legs of a vertex are wide, at most.
FN real pixels_about(uint vertex, real size, OraclePush push) {
    real pixels = real(0.0);
    for (uint w = 0u; w < kOracleWays; ++w)
        pixels = max(pixels, pixels_wide(ways[vertex * kOracleWays + w], size, push));
    return pixels;
}

FN uint edge_verdict_of(uint index, OraclePush push) {
    OracleEdge edge = edges[index];
    OracleVertex a = vertices[edge.first];
    OracleVertex b = vertices[edge.second];
    uint verdict = edge_verdict(a, b, vertices[edge.middle]);
    if (verdict != kKept) {
        real size = edge_length(a, b, push);
        real pixels = max(max(pixels_about(edge.first, size, push), pixels_about(edge.second, size, push)),
                          pixels_about(edge.middle, size, push));
        return is_wide(verdict, pixels, push) ? verdict : kKept;
    }
    if (a.on_body == 0u || a.falloff + b.falloff <= real(0.0)) return kKept;
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
    // Where none of its rays meets the body, nobody knows where its light would go.
    real size = max(edge_length(a, b, push), max(edge_length(b, c, push), edge_length(c, a, push)));
    real pixels = real(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        uint middle = edges[triangle.edge[i]].middle;
        any = any || vertices[middle].on_body != 0u;
        pixels =
            max(pixels, max(pixels_about(triangle.corner[i], size, push), pixels_about(middle, size, push)));
    }
    bool outlines = !any || is_wide(kSilhouette, pixels, push);
    bool edges_of_light = !any || is_wide(kSpotEdge, pixels, push);

    real2 tolerance = real2(real(1e9), real(1e9));
    bool dark = a.falloff + b.falloff + c.falloff <= real(0.0);
    if (met == 3u && !dark)
        for (uint w = 0u; w < kOracleWays; ++w)
            tolerance = min(tolerance, normal_tolerance(ways[triangle.corner[0] * kOracleWays + w],
                                                        ways[triangle.corner[1] * kOracleWays + w],
                                                        ways[triangle.corner[2] * kOracleWays + w], size,
                                                        w < 2u ? push.transmission : push.reflection, push));

    real last = real(push.texels) - real(1.0);
    uint left = uint(min(max(floor(min(min(a.uv.x, b.uv.x), c.uv.x)), real(0.0)), last));
    uint right = uint(min(max(floor(max(max(a.uv.x, b.uv.x), c.uv.x)), real(0.0)), last));
    uint top = uint(min(max(floor(min(min(a.uv.y, b.uv.y), c.uv.y)), real(0.0)), last));
    uint bottom = uint(min(max(floor(max(max(a.uv.y, b.uv.y), c.uv.y)), real(0.0)), last));
    real2 ab = b.uv - a.uv;
    real2 ac = c.uv - a.uv;
    real area = ab.x * ac.y - ab.y * ac.x;
    real texel_size = push.texel_size + push.texel_angle * max(max(a.depth, b.depth), c.depth);
    // What the corners' normals change by from texel to texel.
    real3 along_x = (ac.y * (b.normal - a.normal) - ab.y * (c.normal - a.normal)) / area;
    real3 along_y = (ab.x * (c.normal - a.normal) - ac.x * (b.normal - a.normal)) / area;
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
                if (edges_of_light && abs(texel.light - even) > kFalloffError) return kHidden;
            }
            if (met != (texel.on_body != 0u ? 3u : 0u)) {
                if (outlines && !dark) return kHidden;
                continue;
            }
            if (met == 0u || dark) continue;
            real3 off = texel.normal -
                        normalize(a.normal + of_b * (b.normal - a.normal) + of_c * (c.normal - a.normal));
            if (length(off) <= tolerance.x) continue;
            // Against the texels beside it, or at the rim on its other side.
            OracleTexel beside = texels[y * push.texels + (x + 1u < push.texels ? x + 1u : x - 1u)];
            OracleTexel below = texels[(y + 1u < push.texels ? y + 1u : y - 1u) * push.texels + x];
            real change = real(0.0);
            if (beside.on_body != 0u) change = length(beside.normal - texel.normal - along_x);
            if (below.on_body != 0u) change = max(change, length(below.normal - texel.normal - along_y));
            if (change > tolerance.y * texel_size) return kHidden;
        }
    }
    return any ? kKept : kDiscarded;
}
