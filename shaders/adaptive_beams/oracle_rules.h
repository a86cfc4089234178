// The oracle of adaptive beams: which edges and triangles of the projected grid are kept, split or discarded
// (Liktor and Dachsbacher 2011, 4.2). GLSL and C++ at once, by the rules of optics/language.h;
// layout/beam_oracle.h stands before it.

// What an edge is split for; 0: it is kept.
const uint kKept = 0u;
const uint kSilhouette = 1u;  // one end meets the body, the other does not
const uint kPaths = 2u;       // other surfaces or ends
const uint kNormals = 3u;
const uint kDepths = 4u;
const uint kSpotEdge = 5u;
const uint kLanding = 6u;  // beams bend: landing points between the ends are not between those of the ends
const uint kHidden = 7u;   // of triangles: texels differ from what the corners say

const uint kDiscarded = 8u;  // of triangles: the body is not met anywhere in it; it leaves the grid

const uint kOracleWays =
    4u;  // a vertex: first and last leg of the transmitted path, then of the reflected one

// Two normals farther apart than 30 deg, or a surface that leaves its chord by half the chord, are no one
// smooth surface to a beam.
const real kSmoothCosine = real(0.866);
const real kDepthJump = real(0.5);
// A spot's intensity is interpolated to a hundredth of its peak.
const real kFalloffError = real(0.01);
// An error of landing points that is a share of the beam's width is an error of brightness of that share,
// which shows where the beam is wider than pixels: beams wider than 1 / kOfWidth pixels may be off by as many
// times more.
const real kOfWidth = real(0.5);
// A landing point off by kOfWidth of the tolerance in the middle of an edge goes with widths of its halves,
// and so a brightness, that differ by four times kOfWidth of it from their mean's.
const real kHiddenChange = real(2.0);
const real kLeastShare = real(0.125);      // weaker light is not let pass more than this
const real kNearestToCamera = real(0.25);  // m; beams that go through the camera need no endless splitting
const real kSpreadCosine = real(0.2);      // rays of an edge that fly farther apart are split whatever comes
// Pixels: narrower cells show no edge of a spot, of its picture, or of a surface.
const real kLeastWidth = real(1.0);
const real kMostDimming = real(40.0);  // optical depths

// m in the world that a pixel is wide within `room` m of a point, where that is nearest to the camera; more
// by as much as the water between dims what is there.
FN real pixel_at(real3 point, real room, uint in_water, OraclePush push) {
    real3 way = point - push.camera;
    real far = push.pixel_size > real(0.0) ? abs(dot(way, push.forward)) : length(way);
    far = max(far - room, real(0.0));
    real dimming = in_water != 0u ? min(push.extinction * far, kMostDimming) : real(0.0);
    return (push.pixel_size + push.pixel_angle * max(far, kNearestToCamera)) * exp(dimming);
}

// Way along a leg to where it is nearest to the camera: the central ray of Liktor and Dachsbacher.
FN real nearest_to_camera(OracleWay way, OraclePush push) {
    return min(max(dot(push.camera - way.start, way.direction), real(0.0)), way.reach);
}

FN real nearest_pixel(OracleWay way, real room, OraclePush push) {
    return pixel_at(way.start + nearest_to_camera(way, push) * way.direction, room, way.in_water, push);
}

// Whether both ends of a leg, taken from the camera, are `margin` beyond one side of the view.
FN bool beside_view(real3 from, real3 to, real3 across, real half_tangent, real half_size, real margin,
                    OraclePush push) {
    real scale = inversesqrt(real(1.0) + half_tangent * half_tangent);
    real first = scale * (abs(dot(from, across)) - half_tangent * dot(from, push.forward)) - half_size;
    real last = scale * (abs(dot(to, across)) - half_tangent * dot(to, push.forward)) - half_size;
    return min(first, last) > margin && dot(from, across) * dot(to, across) > real(0.0);
}

// Whether the camera may see something of a leg that is `margin` m thick on all sides.
FN bool in_view(OracleWay way, real margin, OraclePush push) {
    if (way.path == 0u) return false;
    real3 from = way.start - push.camera;
    real3 to = from + way.reach * way.direction;
    return max(dot(from, push.forward), dot(to, push.forward)) >= -margin &&
           !beside_view(from, to, push.right, push.half_tangent.x, push.half_size.x, margin, push) &&
           !beside_view(from, to, push.up, push.half_tangent.y, push.half_size.y, margin, push);
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
    // Its beams reach as far to the sides, about.
    real pixel = pixel_at(at, max(width, length(a.start - b.start)), middle.in_water, push);
    return error * max(middle.share, kLeastShare) > push.tolerance * max(pixel, kOfWidth * width);
}

FN bool way_bends(OracleWay a, OracleWay b, OracleWay middle, OraclePush push) {
    if (a.path == 0u || middle.reach <= real(0.0)) return false;
    real width = length(a.start + a.reach * a.direction - b.start - b.reach * b.direction);
    if (!in_view(middle, max(width, length(a.start - b.start)), push)) return false;
    return lands_off(a, b, middle, middle.reach, push) ||
           lands_off(a, b, middle, real(0.5) * middle.reach, push) ||
           lands_off(a, b, middle, real(0.25) * middle.reach, push) ||
           lands_off(a, b, middle, nearest_to_camera(middle, push), push);
}

// m that an edge is long, about: across the light.
FN real edge_length(OracleVertex a, OracleVertex b, OraclePush push) {
    return length(a.uv - b.uv) * (push.texel_size + push.texel_angle * max(a.depth, b.depth));
}

// Pixels that cells of this size, m, about a leg are wide where they are nearest to the camera; 0 where it
// does not see them.
FN real pixels_wide(OracleWay way, real size, OraclePush push) {
    return in_view(way, size, push) ? size / nearest_pixel(way, size, push) : real(0.0);
}

// Whether cells of so many pixels are split for a reason other than where light lands: outlines are cut out
// in the end, so that cells that lie on them need not be small.
FN bool is_wide(uint verdict, real pixels, OraclePush push) {
    return pixels > (verdict == kSilhouette || verdict == kPaths ? push.least_outline : kLeastWidth);
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

// By how much normals within a triangle may differ from those that its corners give, rad (x), so that landing
// points are off by what lands_off() lets pass in narrow beams; and how fast that difference may change, rad
// a m (y), so that brightness is: of waves within a wide beam the shares count, not where it lands.
FN real2 normal_tolerance(OracleWay a, OracleWay b, OracleWay c, real size, real deflection,
                          OraclePush push) {
    real2 largest = real2(real(1e9), real(1e9));
    if (a.path == 0u || b.path == 0u || c.path == 0u) return largest;
    real reach = max(max(a.reach, b.reach), c.reach);
    if (reach <= real(0.0)) return largest;
    if (!in_view(a, size, push) && !in_view(b, size, push) && !in_view(c, size, push)) return largest;
    real pixel =
        min(min(nearest_pixel(a, size, push), nearest_pixel(b, size, push)), nearest_pixel(c, size, push));
    real share = max(max(max(a.share, b.share), c.share), kLeastShare);
    real each = push.tolerance / (share * deflection * reach);
    return real2(pixel * each, kHiddenChange * each);
}
