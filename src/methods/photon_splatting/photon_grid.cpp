#include "methods/photon_splatting/photon_grid.h"

#include <algorithm>
#include <cmath>

#include "optics/optics.h"

namespace dapple::methods {
namespace {

// A neighbour's ray that meets the tangent plane so much more steeply or levelly spans no footprint with this
// one.
constexpr float kLeastRelativeCosine = 0.1f;
// Neighbours further apart on the water, in cells, are on different sheets of it.
constexpr float kFarthestNeighbor = 4;
// Of the squared length of the longer step on a mirror, at least, that the other has across it, to tell how
// the mirror bends there.
constexpr float kLeastAcross = 1e-3f;

/// From the points to where the rays beside them meet the same planes; `meets`: not where those run along the
/// plane or away from it.
Vectors3 step_to(const RayLanes& own, const RayLanes& other, const PhotonHits& hits, Flags& meets) {
    // Differences of the rays come first: the points themselves have lost the digits.
    const Vectors3 level = (other.origin - own.origin) + hits.depth * (other.slope - own.slope);
    const Floats own_cosine = dot(hits.normal, own.slope), cosine = dot(hits.normal, other.slope);
    meets = cosine < kLeastRelativeCosine * own_cosine;  // both are negative
    return level - (dot(hits.normal, level) / cosine) * other.slope;
}

}  // namespace

PhotonGrid::PhotonGrid(const scene::FrameScene& scene, const light::BeamMesh& mesh)
    : mesh_(mesh),
      columns_(static_cast<std::size_t>(mesh.columns)),
      rows_(static_cast<std::size_t>(mesh.rows)),
      cell_area_(std::abs(glm::determinant(mesh.texel))),
      farthest_(kFarthestNeighbor * mesh.longest_step()) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
    const double n = scene.state.water->refractive_index;
    sun_ = light.type == scene::LightType::sun;
    sun_direction_ = glm::vec3(light.direction);
    light_position_ = glm::vec3(light.position - scene.origin);
    eta_ = static_cast<float>(mesh.from_below ? n : 1 / n);
}

bool PhotonGrid::inner(std::size_t first) const {
    return first >= columns_ && first + kPhotons + columns_ <= mesh_.vertices();
}

RayLanes PhotonGrid::rays_from(std::size_t first) const {
    const Vectors3 origin = load(&mesh_.origin[first]), slope = load(&mesh_.slope[first]);
    const Floats start = load(&mesh_.start[first]);
    const Vectors3 surface = origin + start * slope;
    return {origin, slope, start, surface, mesh_.mirrored() ? load(&mesh_.water_point[first]) : surface};
}

RayLanes PhotonGrid::rays_at(const std::array<std::size_t, kPhotons>& index) const {
    RayLanes rays;
    for (std::size_t k = 0; k < kPhotons; ++k) {
        set_lane(rays.origin, k, mesh_.origin[index[k]]);
        set_lane(rays.slope, k, mesh_.slope[index[k]]);
        rays.start[k] = mesh_.start[index[k]];
    }
    rays.surface = rays.origin + rays.start * rays.slope;
    rays.water = rays.surface;
    if (mesh_.mirrored())
        for (std::size_t k = 0; k < kPhotons; ++k) set_lane(rays.water, k, mesh_.water_point[index[k]]);
    return rays;
}

Flags PhotonGrid::near(const RayLanes& own, const RayLanes& other) const {
    const Vectors3 apart = other.water - own.water;
    return dot(apart, apart) <= farthest_ * farthest_;
}

Photons PhotonGrid::in_row(std::size_t first, std::size_t count) const {
    std::array<std::size_t, kPhotons> vertex;
    for (std::size_t k = 0; k < kPhotons; ++k) vertex[k] = first + std::min(k, count - 1);
    const Flags columns = Flags{0, 1, 2, 3, 4, 5, 6, 7} + static_cast<std::int32_t>(first % columns_);
    const auto beside = [&](std::size_t from, Flags present) {
        return Photons::Beside{rays_from(from), present, present & load(&mesh_.valid[from])};
    };
    // Made where it is returned to: it is too large to be cleared or copied for eight photons.
    Photons photons{
        vertex,
        first_of(count),
        rays_from(first),
        {beside(first - 1, columns > 0), beside(first + 1, columns < static_cast<std::int32_t>(columns_) - 1),
         beside(first - columns_, all(true)), beside(first + columns_, all(true))}};
    for (Photons::Beside& one : photons.beside) one.connected &= near(photons.own, one.ray);
    return photons;
}

Photons PhotonGrid::of(std::span<const std::size_t> vertices) const {
    Photons photons;
    photons.on = first_of(vertices.size());
    for (std::size_t k = 0; k < kPhotons; ++k) photons.vertex[k] = vertices[std::min(k, vertices.size() - 1)];
    photons.own = rays_at(photons.vertex);
    for (std::size_t side = 0; side < 4; ++side) {
        Photons::Beside& beside = photons.beside[side];
        const bool after = side % 2 == 1;
        const std::size_t stride = side < 2 ? 1 : columns_, places = side < 2 ? columns_ : rows_;
        std::array<std::size_t, kPhotons> at = photons.vertex;
        for (std::size_t k = 0; k < kPhotons; ++k) {
            const std::size_t place = side < 2 ? at[k] % columns_ : at[k] / columns_;
            if (after ? place + 1 >= places : place == 0) continue;
            at[k] = after ? at[k] + stride : at[k] - stride;
            beside.present[k] = -1;
            beside.connected[k] = mesh_.valid[at[k]] != 0 ? -1 : 0;
        }
        beside.ray = rays_at(at);
        beside.connected &= near(photons.own, beside.ray);
    }
    return photons;
}

Vectors3 PhotonGrid::incident(const RayLanes& rays) const {
    return sun_ ? all(sun_direction_) : normalized(rays.water - all(light_position_));
}

Vectors3 PhotonGrid::normal(const RayLanes& rays) const {
    // Snell's law and the law of reflection in vector form: what changes is along the normal.
    const Vectors3 in = incident(rays), out = from_water(rays);
    const bool reflection = mesh_.event == light::Event::reflection;
    const Vectors3 unit = normalized(out - all(reflection ? 1.0f : eta_) * in);
    return choose(dot(unit, in) < 0.0f, unit, -unit);
}

Vectors3 PhotonGrid::from_water(const RayLanes& rays) const {
    return normalized(mesh_.mirrored() ? rays.surface - rays.water : rays.slope);
}

Vectors3 PhotonGrid::mirror_normal(const RayLanes& rays) const {
    return normalized(normalized(rays.slope) - from_water(rays));
}

Floats PhotonGrid::whole_way(const Photons& photons, const PhotonHits& hits) const {
    if (!mesh_.mirrored()) return hits.way;
    const Vectors3 before = photons.own.surface - photons.own.water;
    return hits.way + lanes::square_root<float>(dot(before, before));
}

Vectors3 PhotonGrid::turned(const Photons& photons, Vectors3 dx, Flags on) const {
    Vectors3 result;
    for (std::size_t k = 0; !sun_ && k < kPhotons; ++k)
        if (on[k] != 0)
            set_lane(result, k,
                     optics::f32::normalized_differential(lane(photons.own.water, k) - light_position_,
                                                          lane(dx, k)));
    return result;
}

Vectors3 PhotonGrid::spread(const Photons& photons, Vectors3 turned, Vectors3 dn, Flags on) const {
    const Vectors3 incidents = incident(photons.own), normals = normal(photons.own);
    const bool reflection = mesh_.event == light::Event::reflection;
    Vectors3 result;
    for (std::size_t k = 0; k < kPhotons; ++k) {
        if (on[k] == 0) continue;
        const glm::vec3 in = lane(incidents, k), n = lane(normals, k), turn = lane(turned, k);
        set_lane(result, k,
                 reflection ? optics::f32::reflected_differential(in, n, turn, lane(dn, k))
                            : optics::f32::refracted_differential(in, n, eta_, turn, lane(dn, k)));
    }
    return result;
}

Vectors3 PhotonGrid::moved_on_mirror(const Photons& photons, Vectors3 place, Vectors3 direction,
                                     Flags on) const {
    const Vectors3 outs = from_water(photons.own), mirrors = mirror_normal(photons.own);
    Vectors3 result;
    for (std::size_t k = 0; k < kPhotons; ++k) {
        if (on[k] == 0) continue;
        const float way = glm::distance(lane(photons.own.surface, k), lane(photons.own.water, k));
        set_lane(result, k,
                 optics::f32::transferred_differential(lane(place, k), lane(direction, k), lane(outs, k), way,
                                                       lane(mirrors, k)));
    }
    return result;
}

Vectors3 PhotonGrid::mirror_turn(const Photons& photons, Vectors3 moved) const {
    const auto place = [](const RayLanes& rays) { return rays.surface; };
    const auto facing = [&](const RayLanes& rays) { return mirror_normal(rays); };
    const Vectors3 a = photons.step_of(GridAxis::columns, place), b = photons.step_of(GridAxis::rows, place);
    const Vectors3 turn_a = photons.step_of(GridAxis::columns, facing),
                   turn_b = photons.step_of(GridAxis::rows, facing);
    // moved = s a + t b in the least squares, of the two by two equations of which the diagonal is raised.
    const Floats least = kLeastAcross * lanes::greater(dot(a, a), dot(b, b));
    const Floats aa = dot(a, a) + least, bb = dot(b, b) + least, ab = dot(a, b);
    const Floats to_a = dot(moved, a), to_b = dot(moved, b), inverse = 1.0f / (aa * bb - ab * ab);
    const Vectors3 turn =
        (inverse * (to_a * bb - to_b * ab)) * turn_a + (inverse * (to_b * aa - to_a * ab)) * turn_b;
    return choose(photons.any_connected(GridAxis::columns) & photons.any_connected(GridAxis::rows) &
                      finite(dot(turn, turn)),
                  turn, {});
}

Vectors3 PhotonGrid::carried(const Photons& photons, const PhotonHits& hits, const Leaving& leaving,
                             Flags on) const {
    const Vectors3 outs = from_water(photons.own);
    const bool mirrored = mesh_.mirrored();
    const Vectors3 mirrors = mirrored ? mirror_normal(photons.own) : Vectors3{};
    const Vectors3 places =
        mirrored ? moved_on_mirror(photons, leaving.place, leaving.direction, on) : leaving.place;
    Vectors3 result;
    for (std::size_t k = 0; k < kPhotons; ++k) {
        if (on[k] == 0) continue;
        const glm::vec3 place = lane(places, k);
        glm::vec3 direction = lane(leaving.direction, k);
        if (mirrored)
            direction = optics::f32::reflected_differential(lane(outs, k), lane(mirrors, k), direction,
                                                            lane(leaving.mirror_turn, k));
        set_lane(result, k,
                 optics::f32::transferred_differential(place, direction, lane(hits.beam, k), hits.way[k],
                                                       lane(hits.normal, k)));
    }
    return result;
}

Floats PhotonGrid::cell_across_light(const RayLanes& rays) const {
    return cell_area_ * lanes::magnitude(incident(rays).y);
}

PhotonHits PhotonGrid::hits(const Photons& photons, Floats depth, Vectors3 normal) const {
    const RayLanes& own = photons.own;
    const Floats square = dot(own.slope, own.slope), inverse = lanes::inverse_root(square);
    return {depth, own.origin + depth * own.slope, normal, inverse * own.slope,
            square * inverse * (depth - own.start)};
}

Vectors3 PhotonGrid::parallel_step(const Photons& photons, const PhotonHits& hits, GridAxis axis) const {
    const glm::vec2 step = mesh_.texel[axis == GridAxis::columns ? 0 : 1];
    const Vectors3 across = all(glm::vec3(step.x, 0, step.y)), slope = photons.own.slope;
    return across - (dot(hits.normal, across) / dot(hits.normal, slope)) * slope;
}

GridSteps PhotonGrid::step(const Photons& photons, const PhotonHits& hits, GridAxis axis,
                           bool forward) const {
    const Photons::Beside &before = photons.before(axis), &after = photons.after(axis);
    Flags has_before, has_after;
    const Vectors3 to_before = step_to(photons.own, before.ray, hits, has_before),
                   to_after = step_to(photons.own, after.ray, hits, has_after);
    has_before &= before.connected;
    has_after &= after.connected;
    if (forward) has_before &= ~has_after;
    const Flags both = has_before & has_after;
    const Floats share = both ? all(0.5f) : all(1.0f);
    const auto between = [&](Vectors3 low, Vectors3 high) {
        return share * (choose(has_after, high, {}) - choose(has_before, low, {}));
    };
    GridSteps steps;
    steps.any = has_before | has_after;
    steps.on_plane = between(to_before, to_after);
    steps.on_water =
        between(before.ray.surface - photons.own.surface, after.ray.surface - photons.own.surface);
    if (lanes::any(~steps.any))
        steps.on_plane = choose(steps.any, steps.on_plane, parallel_step(photons, hits, axis));
    return steps;
}

}  // namespace dapple::methods
