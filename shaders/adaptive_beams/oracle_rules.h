// The oracle of adaptive beams: which edges and triangles of the projected grid are split (Liktor and
// Dachsbacher 2011, 4.2). GLSL and C++ at once, by the rules of optics/language.h; layout/beam_oracle.h
// stands before it.

// What an edge is split for; 0: it is kept.
const uint kKept = 0u;
const uint kSilhouette = 1u;  // one end meets the body, the other does not
const uint kPaths = 2u;       // other surfaces or ends
const uint kNormals = 3u;
const uint kDepths = 4u;
const uint kSpotEdge = 5u;
const uint kLanding = 6u;  // beams bend: landing points between the ends are not between those of the ends
const uint kHidden = 7u;   // of triangles: texels differ from what the corners say

const uint kDiscarded = 8u;  // of triangles: the body is not met anywhere in it

const uint kOracleWays =
    4u;  // a vertex: first and last leg of the transmitted path, then of the reflected one

// Two normals farther apart than 30 deg, or a surface that leaves its chord by half the chord, are no one
// smooth surface to a beam.
const real kSmoothCosine = real(0.866);
const real kDepthJump = real(0.5);
// A spot's intensity is interpolated to a hundredth of its peak.
const real kFalloffError = real(0.01);
// Pixels by which a landing point may be off, where its beam neither narrows nor widens and carries all the
// light. A caustic is then where it belongs to what the picture can show.
const real kPixels = real(1.0);
// An error of landing points that is a share of the beam's width is an error of brightness of that share, and
// a narrower beam is brighter: the tolerance goes with the width, within these bounds. At a focus the width
// goes to 0.
const real kNarrowest = real(0.125);
const real kWidest = real(4.0);
const real kLeastShare = real(0.125);      // weaker light is not let pass more than this
const real kNearestToCamera = real(0.25);  // m; beams that go through the camera need no endless splitting
const real kSpreadCosine = real(0.2);      // rays of an edge that fly farther apart are split whatever comes

// m in the world that a pixel is wide at a point.
FN real pixel_at(real3 point, OraclePush push) {
    return push.pixel_size + push.pixel_angle * max(length(point - push.camera), kNearestToCamera);
}

// Way along a leg to where it is nearest to the camera: the central ray of Liktor and Dachsbacher.
FN real nearest_to_camera(OracleWay way, OraclePush push) {
    return min(max(dot(push.camera - way.start, way.direction), real(0.0)), way.reach);
}

// Whether a beam between two rays is off where the ray between them is, at `distance` along that.
FN bool lands_off(OracleWay a, OracleWay b, OracleWay middle, real distance, OraclePush push) {
    real3 at = middle.start + distance * middle.direction;
    real along_a = dot(a.direction, middle.direction);
    real along_b = dot(b.direction, middle.direction);
    if (min(along_a, along_b) < kSpreadCosine) return true;
    real3 at_a = a.start + (dot(at - a.start, middle.direction) / along_a) * a.direction;
    real3 at_b = b.start + (dot(at - b.start, middle.direction) / along_b) * b.direction;
    real error = length(at - real(0.5) * (at_a + at_b));
    real width = length(at_a - at_b);
    real first_width = length(a.start - b.start);
    real pixel = pixel_at(at, push);
    if (max(width, first_width) < pixel) return false;
    real narrowing = min(max(width / max(first_width, real(1e-9)), kNarrowest), kWidest);
    return error * max(middle.share, kLeastShare) > kPixels * pixel * narrowing;
}

FN bool way_bends(OracleWay a, OracleWay b, OracleWay middle, OraclePush push) {
    if (a.path == 0u || middle.reach <= real(0.0)) return false;
    return lands_off(a, b, middle, middle.reach, push) ||
           lands_off(a, b, middle, real(0.5) * middle.reach, push) ||
           lands_off(a, b, middle, real(0.25) * middle.reach, push) ||
           lands_off(a, b, middle, nearest_to_camera(middle, push), push);
}

// What the rays at the ends and in the middle of an edge say, but for way_bends() of their ways.
FN uint edge_verdict(OracleVertex a, OracleVertex b, OracleVertex middle) {
    if (a.on_body != b.on_body || a.on_body != middle.on_body) return kSilhouette;
    if (a.on_body == 0u) return kKept;
    if (abs(middle.falloff - real(0.5) * (a.falloff + b.falloff)) > kFalloffError) return kSpotEdge;
    if (max(max(a.falloff, b.falloff), middle.falloff) <= real(0.0)) return kKept;
    if (a.ends != b.ends || a.ends != middle.ends) return kPaths;
    if (dot(a.normal, b.normal) < kSmoothCosine) return kNormals;
    if (abs(middle.depth - real(0.5) * (a.depth + b.depth)) > kDepthJump * length(a.position - b.position))
        return kDepths;
    return kKept;
}

// By how much a normal within a triangle may differ from the one that its corners give, rad: the landing
// point is then off by what lands_off() lets pass.
FN real normal_tolerance(OracleWay a, OracleWay b, OracleWay c, real deflection, OraclePush push) {
    real largest = real(1e9);
    if (a.path == 0u || b.path == 0u || c.path == 0u) return largest;
    real reach = max(max(a.reach, b.reach), c.reach);
    if (reach <= real(0.0)) return largest;
    real pixel = pixel_at(a.start + nearest_to_camera(a, push) * a.direction, push);
    pixel = min(pixel, pixel_at(b.start + nearest_to_camera(b, push) * b.direction, push));
    pixel = min(pixel, pixel_at(c.start + nearest_to_camera(c, push) * c.direction, push));
    real share = max(max(max(a.share, b.share), c.share), kLeastShare);
    return kPixels * pixel / (share * deflection * reach);
}
