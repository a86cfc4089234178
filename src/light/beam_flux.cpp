#include "light/beam_flux.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "light/steepness_map.h"
#include "optics/optics.h"

namespace dapple::light {
namespace {

constexpr std::size_t kTile = 1 << 13;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Light that arrives at a point of the water.
struct Arrival {
    glm::dvec3 direction;
    double falloff = 1;   // of a spot or an area light
    double absorbed = 0;  // share
};

/// Share of light that is lost on a way of that optical depth.
double lost(double depth) {
    return -std::expm1(-depth);
}

/// The kinds of light, each with what its inner loops need: `at` a vertex and `on` a triangle, whose
/// cross product of two edges is `twice_area`, turned towards the light's side.
struct SunRays {
    glm::dvec3 direction;
    Arrival at(glm::dvec3) const { return {direction}; }
    double on(glm::dvec3, glm::dvec3, glm::dvec3, glm::dvec3 twice_area) const {
        return -0.5 * glm::dot(twice_area, direction);
    }
};

/// atan(y / x) for y of either sign; a few terms where they leave no error.
double angle_of(double y, double x) {
    const double ratio = y / x;
    if (!(x > 0 && std::abs(ratio) < 0.01)) return std::atan2(y, x);
    const double s = ratio * ratio;
    return ratio * (1 - s * (1.0 / 3 - s * (1.0 / 5 - s * (1.0 / 7 - s * (1.0 / 9)))));
}

struct LampRays {
    glm::dvec3 position;
    double extinction;  // /m
    Arrival at(glm::dvec3 point) const {
        const glm::dvec3 way = point - position;
        const double length = std::sqrt(glm::dot(way, way));
        return {way * (1 / length), 1, extinction > 0 ? lost(extinction * length) : 0};
    }
    double on(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c, glm::dvec3 twice_area) const {
        a -= position;
        b -= position;
        c -= position;
        const double la = std::sqrt(glm::dot(a, a)), lb = std::sqrt(glm::dot(b, b)),
                     lc = std::sqrt(glm::dot(c, c));
        // a . (b x c), by the edges: no digits are lost for a small triangle far away.
        const double volume = -glm::dot(a, twice_area);
        return 2 * angle_of(volume,
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
};

struct SpotRays : LampRays {
    glm::dvec3 axis;
    double cos_outer, cos_inner;
    Arrival at(glm::dvec3 point) const {
        Arrival arrival = LampRays::at(point);
        arrival.falloff =
            optics::f64::spot_light_falloff(glm::dot(arrival.direction, axis), cos_outer, cos_inner);
        return arrival;
    }
};

/// Of a part of an area light.
struct EmitterRays : LampRays {
    glm::dvec3 axis;
    Arrival at(glm::dvec3 point) const {
        Arrival arrival = LampRays::at(point);
        arrival.falloff = std::max(0.0, glm::dot(arrival.direction, axis));
        return arrival;
    }
};

/// Calls `body` with the rays of the light's kind, so that inner loops are compiled for each.
template <class Body>
auto with_rays(const WaterLight& light, Body&& body) {
    switch (light.type) {
        case scene::LightType::point:
            return body(LampRays{light.position, light.extinction});
        case scene::LightType::spot:
            return body(SpotRays{
                {light.position, light.extinction}, light.direction, light.cos_outer, light.cos_inner});
        case scene::LightType::quad:
        case scene::LightType::disc:
            return body(EmitterRays{{light.position, light.extinction}, light.direction});
        default:
            return body(SunRays{light.direction});
    }
}

/// Mean of the light's picture over a triangle of the water.
double picture_on(const WaterLight& light, const scene::TriangleMesh& mesh, glm::uvec3 t) {
    if (light.picture == nullptr) return 1;
    const std::array<glm::dvec3, 3> ways{mesh.positions[t.x] - light.position,
                                         mesh.positions[t.y] - light.position,
                                         mesh.positions[t.z] - light.position};
    return light.picture->mean(ways)[light.channel];
}

double event_share(Event event, double cos_i, double eta) {
    const double cos_t = optics::f64::transmitted_cosine(cos_i, eta);
    return event == Event::transmission ? optics::f64::fresnel_transmittance(cos_i, cos_t, eta)
                                        : optics::f64::fresnel_reflectance(cos_i, cos_t, eta);
}

/// The unit normal against the ray. A normal that faces away is tilted until the light grazes it, so that
/// facets at the terminator keep a ray at each corner.
glm::dvec3 facing(glm::dvec3 normal, glm::dvec3 direction) {
    const double along = glm::dot(normal, direction);
    if (along <= 0) return normal;
    normal -= along * direction;
    const double square = glm::dot(normal, normal);
    if (square > 1e-24) return normal * (1 / std::sqrt(square));
    return mesh_frame(direction)[0];
}

glm::dvec3 twice_area(const scene::TriangleMesh& mesh, glm::uvec3 t) {
    const glm::dvec3& a = mesh.positions[t.x];
    return glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
}

/// Of the light that arrives somewhere.
struct Share {
    double carried;   // after the event
    double absorbed;  // before it, that it would have carried too
};

Share share_of(const Arrival& arrival, Event event, double cos_i, double eta) {
    const double share = arrival.falloff * event_share(event, cos_i, eta);
    return {share * (1 - arrival.absorbed), share * arrival.absorbed};
}

/// At the middle of a triangle by its own plane, where normals mean nothing.
template <class Rays>
Share share_of_plane(const Rays& rays, const WaterLight& light, const scene::TriangleMesh& mesh, glm::uvec3 t,
                     glm::dvec3 area, Event event, double eta) {
    Arrival arrival = rays.at((mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) / 3.0);
    if (!light.depths.empty()) {
        const auto depth = [&](glm::uint v) { return static_cast<double>(light.depths[v]); };
        arrival.absorbed = lost((depth(t.x) + depth(t.y) + depth(t.z)) / 3);
    }
    const double cos_i = std::clamp(-glm::dot(area, arrival.direction) / glm::length(area), 0.0, 1.0);
    return share_of(arrival, event, cos_i, eta);
}

template <class Rays>
double incident(const Rays& rays, const scene::TriangleMesh& mesh, glm::uvec3 t, double side,
                glm::dvec3 area) {
    return rays.on(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z], side * area);
}

}  // namespace

double incident_on_triangle(const scene::TriangleMesh& mesh, glm::uvec3 triangle, const WaterLight& light) {
    return with_rays(light, [&](const auto& rays) {
        return incident(rays, mesh, triangle, light.side(), twice_area(mesh, triangle));
    });
}

template <class Real>
void trace_vertices(const scene::FrameScene& scene, const WaterLight& light, double eta,
                    const std::array<glm::dvec3, kSheetAxes>& axes, int axis_index, BeamSheet<Real>& sheet,
                    VertexEvents& events) {
    const scene::TriangleMesh& mesh = scene.water->mesh;
    const std::size_t count = mesh.positions.size();
    const bool transmission = sheet.event == Event::transmission;
    const glm::dmat3 mesh_from_world = glm::transpose(sheet.world_from_mesh);
    const double side = light.side();
    sheet.rays.resize(count);
    sheet.start.resize(count);
    sheet.valid.resize(count);
    events.share.resize(count);
    const bool dimmed = light.extinction > 0 || !light.depths.empty();
    events.absorbed.resize(dimmed ? count : 0);
    events.cones.resize(count);
    std::vector<double> flattest(count / kTile + 1, kInfinity);

    const auto trace = [&](const auto& rays, std::size_t v) {
        const glm::dvec3 position = mesh.positions[v], normal = side * mesh.normals[v];
        Arrival arrival = rays.at(position);
        if (!light.depths.empty()) arrival.absorbed = lost(static_cast<double>(light.depths[v]));
        const glm::dvec3 against = facing(normal, arrival.direction);
        const double cos_i = std::clamp(-glm::dot(arrival.direction, against), 0.0, 1.0);
        glm::dvec3 out;
        bool exists = true;
        if (transmission) {
            exists = optics::f64::refracted_direction(arrival.direction, against, eta, out);
        } else {
            out = optics::f64::reflected_direction(arrival.direction, against);
        }
        // One test for all that is not a number or no unit vector: positions enter through `far`.
        const double far = glm::dot(position, position), unit = glm::dot(normal, normal);
        const bool finite =
            far < kInfinity && unit > 0.5 && unit < 2 && glm::dot(arrival.direction, arrival.direction) > 0.5;
        exists = exists && finite;
        const Share share = share_of(arrival, sheet.event, cos_i, eta);
        events.share[v] = finite ? share.carried : kNothing;
        if (!events.absorbed.empty()) events.absorbed[v] = share.absorbed;
        const double along = glm::dot(out, axes[0]);
        const unsigned cones = static_cast<unsigned>(along > kConeCosine) |
                               static_cast<unsigned>(out.x > kConeCosine) << 1 |
                               static_cast<unsigned>(out.x < -kConeCosine) << 2 |
                               static_cast<unsigned>(out.z > kConeCosine) << 3 |
                               static_cast<unsigned>(out.z < -kConeCosine) << 4 |
                               static_cast<unsigned>(out.y > kConeCosine) << 5 |
                               static_cast<unsigned>(out.y < -kConeCosine) << 6;
        events.cones[v] = exists ? static_cast<std::uint8_t>(cones) : std::uint8_t{0};
        const bool fits = exists && (cones >> axis_index & 1) != 0;
        const glm::dvec3 at = mesh_from_world * (far < kInfinity ? position - scene.origin : glm::dvec3(0));
        const glm::dvec3 way = fits ? mesh_from_world * out : glm::dvec3(0, 0, 1);
        const glm::dvec2 slope = glm::dvec2(way) * (1 / way.z);
        sheet.rays[v] = {static_cast<Real>(at.x - at.z * slope.x), static_cast<Real>(at.y - at.z * slope.y),
                         static_cast<Real>(slope.x), static_cast<Real>(slope.y)};
        sheet.start[v] = static_cast<Real>(at.z);
        sheet.valid[v] = fits ? 1 : 0;
        return exists ? out.y * out.y / (out.x * out.x + out.z * out.z) : kInfinity;
    };
    with_rays(light, [&](const auto& rays) {
        parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
            double least = kInfinity;
            for (std::size_t v = begin; v < end; ++v) least = std::min(least, trace(rays, v));
            flattest[begin / kTile] = least;
        });
    });
    events.flattest_squared = *std::min_element(flattest.begin(), flattest.end());
}

template <class Real>
FluxSurvey fill_flux(const scene::TriangleMesh& mesh, const WaterLight& light, double eta,
                     const VertexEvents& events, const std::vector<float>& visible, int axis_index,
                     BeamSheet<Real>& sheet) {
    const std::size_t count = mesh.triangles.size();
    const double side = light.side();
    sheet.flux.resize(count);
    std::vector<FluxSurvey> tiles(count / kTile + 1);

    const auto flux_of = [&](const auto& rays, std::size_t index, FluxSurvey& survey) {
        const glm::uvec3 t = mesh.triangles[index];
        const glm::dvec3 area = twice_area(mesh, t);
        double met = incident(rays, mesh, t, side, area);
        if (!(std::abs(met) < kInfinity)) {
            ++survey.losses.unknown_facets;
            return 0.0;
        }
        survey.steepest_squared = std::max(survey.steepest_squared, slope_squared(area));
        survey.faces_away |= met < 0;
        if (!(met > 0)) return 0.0;
        Share share{(events.share[t.x] + events.share[t.y] + events.share[t.z]) / 3, 0};
        const bool finite = share.carried >= 0;
        if (!finite) {
            share = share_of_plane(rays, light, mesh, t, side * area, sheet.event, eta);
        } else if (!events.absorbed.empty()) {
            share.absorbed = (events.absorbed[t.x] + events.absorbed[t.y] + events.absorbed[t.z]) / 3;
        }
        if (share.carried > 0 || share.absorbed > 0) met *= picture_on(light, mesh, t);
        survey.losses.absorbed += met * share.absorbed;
        double flux = met * share.carried;
        if (!visible.empty()) {
            const double seen = static_cast<double>(visible[index]);
            survey.losses.wave_shadow += flux * (1 - seen);
            flux *= seen;
        }
        const unsigned cones = events.cones[t.x] & events.cones[t.y] & events.cones[t.z];
        if (cones == 0) {
            const bool all_rays = events.cones[t.x] && events.cones[t.y] && events.cones[t.z];
            (!finite    ? survey.losses.not_finite
             : all_rays ? survey.losses.outside_cone
                        : survey.losses.total_reflection) += flux;
            return 0.0;
        }
        if (flux > 0) survey.axes |= cones & -cones;
        if (std::countr_zero(cones) != axis_index) return 0.0;
        return flux;
    };
    with_rays(light, [&](const auto& rays) {
        parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
            FluxSurvey survey;
            for (std::size_t i = begin; i < end; ++i)
                sheet.flux[i] = static_cast<Real>(flux_of(rays, i, survey));
            tiles[begin / kTile] = survey;
        });
    });
    FluxSurvey total;
    for (const FluxSurvey& tile : tiles) {
        total.faces_away |= tile.faces_away;
        total.steepest_squared = std::max(total.steepest_squared, tile.steepest_squared);
        total.axes |= tile.axes;
        total.losses += tile.losses;
    }
    return total;
}

template void trace_vertices(const scene::FrameScene&, const WaterLight&, double,
                             const std::array<glm::dvec3, kSheetAxes>&, int, BeamSheet<float>&,
                             VertexEvents&);
template void trace_vertices(const scene::FrameScene&, const WaterLight&, double,
                             const std::array<glm::dvec3, kSheetAxes>&, int, BeamSheet<double>&,
                             VertexEvents&);
template FluxSurvey fill_flux(const scene::TriangleMesh&, const WaterLight&, double, const VertexEvents&,
                              const std::vector<float>&, int, BeamSheet<float>&);
template FluxSurvey fill_flux(const scene::TriangleMesh&, const WaterLight&, double, const VertexEvents&,
                              const std::vector<float>&, int, BeamSheet<double>&);

}  // namespace dapple::light
