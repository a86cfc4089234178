#include "methods/sliced_beams/light_lattice.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "scene/transform.h"

namespace dapple::methods::sliced_beams {
namespace {

constexpr std::int32_t kBlockSide = 8;
/// Steps of the lattice, largest, in semi-axes of the disc's image (and at least 1 / sqrt 2 of that): the
/// footprint that an image gives is sqrt 3 semi-axes wide, so that 3.5 to 4.9 nodes lie across it.
constexpr double kStep = 0.75;
/// Receivers a node, at least, and how long their footprints may be against a step.
constexpr double kLeastShared = 4;
constexpr double kLongest = 1;
/// Cells along the faces of the cube about a sphere: its surface lies at most 0.1 % of the radius from the
/// tangent planes at their middles, and leans from them by 2 degrees.
constexpr std::uint32_t kSphereCells = 40;
/// Cosine between a sphere's normal and the light, least: nearer to grazing, light falls with the normal too
/// fast for a step from cell to cell not to be seen.
constexpr double kLeastFacingOfSphere = 0.3;
/// Cosine between a plane and the light, least: beyond, a disc's image is too long to tell its middle's way.
constexpr double kLeastFacing = 0.05;

glm::dvec3 unit(int axis, double sign) {
    glm::dvec3 v(0);
    v[axis] = sign;
    return v;
}

/// Face of the cube that a direction points at: 2 * axis, + 1 where negative.
std::uint32_t cube_face(const glm::dvec3& v) {
    const glm::dvec3 size = glm::abs(v);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return static_cast<std::uint32_t>(2 * axis + (v[axis] < 0 ? 1 : 0));
}

int face_axis(std::uint32_t face) {
    return static_cast<int>(face / 2);
}
double face_sign(std::uint32_t face) {
    return face % 2 == 0 ? 1 : -1;
}

/// Weights of four nodes for a point t of the way from the second to the third (Keys 1981, a = -1/2).
std::array<float, 4> cubic_weights(float t) {
    const float u = 1 - t;
    return {-0.5f * t * u * u, 1 + t * t * (1.5f * t - 2.5f), 1 + u * u * (1.5f * u - 2.5f),
            -0.5f * u * t * t};
}

}  // namespace

LightLattice::LightLattice(const scene::FrameScene& scene, Sheets sheets) : sheets_(sheets) {
    for (const scene::Object& object : scene.state.objects) {
        glm::dvec3 half = 0.5 * object.size;
        if (object.shape == scene::Shape::sphere) half = glm::dvec3(object.radius);
        const glm::dmat4 world = scene::relative_from_object(object.transform, scene.origin);
        const glm::dmat4 inverse = glm::inverse(world);
        shapes_.push_back({object.shape, half, world, inverse, glm::transpose(glm::dmat3(inverse))});
    }
}

LightLattice::Patch LightLattice::patch(std::uint32_t object, std::uint32_t index) const {
    const Shape& shape = shapes_[object];
    glm::dvec3 point(0), normal(0);
    if (shape.shape == scene::Shape::sphere) {
        const std::uint32_t face = index / (kSphereCells * kSphereCells),
                            cell = index % (kSphereCells * kSphereCells);
        const int axis = face_axis(face);
        normal[axis] = face_sign(face);
        const std::uint32_t column = cell % kSphereCells, row = cell / kSphereCells;
        normal[(axis + 1) % 3] = (2.0 * column + 1) / kSphereCells - 1;
        normal[(axis + 2) % 3] = (2.0 * row + 1) / kSphereCells - 1;
        normal = glm::normalize(normal);
        point = shape.half.x * normal;
    } else {
        normal = unit(face_axis(index), face_sign(index));
        if (shape.shape == scene::Shape::box) point = shape.half * normal;
    }
    return {index, glm::dvec3(shape.world_from_object * glm::dvec4(point, 1)),
            glm::normalize(shape.normals_from_object * normal)};
}

/// The plane that stands for the surface at a receiver; none where that is not what the shape tells.
std::optional<LightLattice::Patch> LightLattice::patch_of(std::uint32_t object,
                                                          const Receiver<float>& receiver) const {
    if (object >= shapes_.size() || shapes_[object].shape == scene::Shape::mesh) return std::nullopt;
    const Shape& shape = shapes_[object];
    const glm::dvec3 normal(receiver.normal), position(receiver.position);
    std::uint32_t index = 0;
    double room = 1e-5 * (1 + glm::length(position));
    if (shape.shape == scene::Shape::sphere) {
        const glm::dvec3 at(shape.object_from_world * glm::dvec4(position, 1));
        const std::uint32_t face = cube_face(at);
        const int axis = face_axis(face);
        const auto cell = [&](int k) {
            const double c = (at[(axis + k) % 3] / std::abs(at[axis]) + 1) / 2 * kSphereCells;
            return static_cast<std::uint32_t>(std::clamp(c, 0.0, kSphereCells - 1.0));
        };
        index = (face * kSphereCells + cell(2)) * kSphereCells + cell(1);
        room += 0.001 * glm::length(glm::dvec3(shape.world_from_object[axis])) * shape.half.x;
    } else {
        // Normals go to the object's space by the transpose of what takes points from it.
        index = cube_face(glm::transpose(glm::dmat3(shape.world_from_object)) * normal);
    }
    const Patch found = patch(object, index);
    const bool on_it = std::abs(glm::dot(found.normal, position - found.point)) <= room;
    return on_it && glm::dot(found.normal, normal) > 0.98 ? std::optional(found) : std::nullopt;
}

std::optional<LightLattice::Axes> LightLattice::axes(std::size_t sheet, const Patch& patch, int level) const {
    const light::BeamSheet<float>& beams = sheets_[sheet]->sheet();
    const glm::dvec3 normal = glm::transpose(beams.world_from_mesh) * patch.normal;
    if (!(normal.z < -kLeastFacing)) return std::nullopt;
    // The disc's semi-axes, a metre of way below the water, seen along the sheet's axis.
    const auto on_plane = [&](const glm::dvec2& e) {
        return beams.world_from_mesh * glm::dvec3(e, -(normal.x * e.x + normal.y * e.y) / normal.z);
    };
    const double step = std::exp2(0.5 * level);
    Axes axes{step * on_plane(beams.disc_u), step * on_plane(beams.disc_v), {}, {}};
    const glm::dvec3 across_v = glm::cross(axes.v, patch.normal), across_u = glm::cross(patch.normal, axes.u);
    const double area = glm::dot(axes.u, across_v);
    if (!(std::abs(area) > 0)) return std::nullopt;
    axes.to_u = across_v / area;
    axes.to_v = across_u / area;
    return axes;
}

std::optional<LightLattice::Place> LightLattice::place(std::size_t sheet, std::uint32_t object,
                                                       const Receiver<float>& receiver) const {
    const std::optional<Patch> patch = patch_of(object, receiver);
    if (!patch) return std::nullopt;
    const glm::dvec3 position(receiver.position);
    const double way = static_cast<double>(sheets_[sheet]->way(receiver.position));
    if (!(way > 0)) return std::nullopt;
    const int level = static_cast<int>(std::floor(2 * std::log2(kStep * way)));
    const std::optional<Axes> axes = this->axes(sheet, *patch, level);
    if (!axes) return std::nullopt;
    const auto steps = [&](const glm::dvec3& v) {
        return glm::dvec2(glm::dot(axes->to_u, v), glm::dot(axes->to_v, v));
    };
    const glm::dvec2 u = steps(glm::dvec3(receiver.u)), v = steps(glm::dvec3(receiver.v));
    const glm::dvec2 extent = glm::abs(u) + glm::abs(v);
    if (!(std::max(extent.x, extent.y) <= kLongest && std::abs(u.x * v.y - u.y * v.x) * kLeastShared <= 1))
        return std::nullopt;
    const glm::dvec2 at = steps(position - patch->point);
    if (!(std::max(std::abs(at.x), std::abs(at.y)) < 1e8)) return std::nullopt;
    const glm::dvec3& axis = sheets_[sheet]->sheet().world_from_mesh[2];
    if (shapes_[object].shape == scene::Shape::sphere &&
        glm::dot(patch->normal, axis) > -kLeastFacingOfSphere)
        return std::nullopt;
    const double facing = glm::dot(glm::dvec3(receiver.normal), axis) / glm::dot(patch->normal, axis);
    return Place{{static_cast<std::uint32_t>(sheet), object, patch->index, level, 0, 0}, at.x, at.y, facing};
}

namespace {

/// Calls `visit(row, column, weight)` for the 4 x 4 nodes about a point, in a fixed order.
template <class Visit>
void visit_nodes(double row, double column, Visit&& visit) {
    const double top = std::floor(row), left = std::floor(column);
    const std::array<float, 4> down = cubic_weights(static_cast<float>(row - top));
    const std::array<float, 4> across = cubic_weights(static_cast<float>(column - left));
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c)
            visit(static_cast<std::int32_t>(top) + r - 1, static_cast<std::int32_t>(left) + c - 1,
                  down[static_cast<std::size_t>(r)] * across[static_cast<std::size_t>(c)]);
}

// Blocks of negative rows, too: shifts round downwards.
std::int32_t block_of(std::int32_t node) {
    return node >> 3;
}
unsigned bit_of(std::int32_t row, std::int32_t column) {
    return static_cast<unsigned>(kBlockSide * (row & 7) + (column & 7));
}

}  // namespace

void LightLattice::ask(std::size_t sheet, const ReceiverGroup& group, std::vector<Request>& requests) const {
    if (!blurs(sheet)) return;
    for (const Receiver<float>& receiver : group.receivers) {
        const std::optional<Place> place = this->place(sheet, group.object, receiver);
        if (!place) continue;
        visit_nodes(place->row, place->column, [&](std::int32_t row, std::int32_t column, float) {
            BlockKey key = place->plane;
            key.row = block_of(row);
            key.column = block_of(column);
            const auto known = std::find_if(requests.rbegin(), requests.rend(),
                                            [&](const Request& request) { return request.key == key; });
            Request& request = known != requests.rend() ? *known : requests.emplace_back(Request{key, 0});
            request.nodes |= std::uint64_t{1} << bit_of(row, column);
        });
    }
}

void LightLattice::find(std::vector<Request> requests, QueryCounts& counts) {
    std::sort(requests.begin(), requests.end(),
              [](const Request& a, const Request& b) { return a.key < b.key; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        if (kept > 0 && requests[kept - 1].key == requests[i].key)
            requests[kept - 1].nodes |= requests[i].nodes;
        else
            requests[kept++] = requests[i];
    }
    requests.resize(kept);
    blocks_.resize(kept);
    nodes_ = 0;
    std::vector<QueryCounts> parts(kept);
    parallel_for(kept, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) fill(requests[i], blocks_[i], parts[i]);
    });
    for (std::size_t i = 0; i < kept; ++i) {
        counts.add(parts[i]);
        nodes_ += static_cast<std::size_t>(__builtin_popcountll(requests[i].nodes));
    }
}

void LightLattice::fill(const Request& request, Block& block, QueryCounts& counts) const {
    block.key = request.key;
    block.irradiance.fill(glm::vec3(0));
    block.hidden = 0;
    const Patch patch = this->patch(request.key.object, request.key.patch);
    const std::optional<Axes> axes = this->axes(request.key.sheet, patch, request.key.level);
    std::vector<Receiver<float>> receivers;
    std::vector<std::size_t> places;
    for (std::uint64_t left = request.nodes; axes && left != 0; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const std::int32_t row_in_block = bit / kBlockSide, column_in_block = bit % kBlockSide;
        const double row = kBlockSide * request.key.row + row_in_block;
        const double column = kBlockSide * request.key.column + column_in_block;
        // A footprint of its own that is nothing against the disc's image.
        const glm::dvec3 u = 0.1 * axes->u, v = 0.1 * axes->v;
        receivers.push_back({glm::vec3(patch.point + column * axes->u + row * axes->v), glm::vec3(u),
                             glm::vec3(v), glm::vec3(patch.normal)});
        places.push_back(static_cast<std::size_t>(bit));
    }
    std::vector<glm::vec3> irradiance(receivers.size(), glm::vec3(0));
    std::vector<std::uint8_t> hidden(receivers.size(), 0);
    sheets_[request.key.sheet]->add(receivers, request.key.object, irradiance, counts, hidden);
    for (std::size_t i = 0; i < places.size(); ++i) {
        block.irradiance[places[i]] = irradiance[i];
        block.hidden |= std::uint64_t{hidden[i]} << places[i];
    }
}

const LightLattice::Block& LightLattice::block(const BlockKey& key) const {
    return *std::lower_bound(blocks_.begin(), blocks_.end(), key,
                             [](const Block& block, const BlockKey& wanted) { return block.key < wanted; });
}

LightLattice::Split LightLattice::split(std::size_t sheet, const ReceiverGroup& group) const {
    Split split;
    for (std::size_t i = 0; i < group.receivers.size(); ++i) {
        const std::optional<Place> place =
            blurs(sheet) ? this->place(sheet, group.object, group.receivers[i]) : std::nullopt;
        (place && !near_shadow(*place) ? split.shared : split.alone).push_back(i);
    }
    return split;
}

bool LightLattice::near_shadow(const Place& place) const {
    bool found = false;
    const Block* last = nullptr;
    visit_nodes(place.row, place.column, [&](std::int32_t row, std::int32_t column, float) {
        BlockKey key = place.plane;
        key.row = block_of(row);
        key.column = block_of(column);
        if (!last || last->key != key) last = &block(key);
        found |= (last->hidden >> bit_of(row, column) & 1) != 0;
    });
    return found;
}

void LightLattice::add(std::size_t sheet, const ReceiverGroup& group, std::span<const std::size_t> shared,
                       std::span<glm::vec3> irradiance) const {
    const Block* last = nullptr;
    for (const std::size_t i : shared) {
        const std::optional<Place> place = this->place(sheet, group.object, group.receivers[i]);
        if (!place) continue;
        glm::vec3 sum(0);
        visit_nodes(place->row, place->column, [&](std::int32_t row, std::int32_t column, float weight) {
            BlockKey key = place->plane;
            key.row = block_of(row);
            key.column = block_of(column);
            if (!last || last->key != key) last = &block(key);
            sum += weight * last->irradiance[bit_of(row, column)];
        });
        // Weights beside the middle are negative.
        irradiance[i] += static_cast<float>(std::max(0.0, place->facing)) * glm::max(sum, glm::vec3(0));
    }
}

}  // namespace dapple::methods::sliced_beams
