#include "methods/reference/own_media.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "scene/transform.h"

namespace dapple::reference {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostBlocks = 0x1p24;
/// Interpolated densities may round to more than the largest voxel.
constexpr float kRoundUp = 1 + 0x1p-20f;
/// Steps of ratio tracking that a block may be expected to take; where it is denser its cells are integrated.
constexpr double kMostSteps = 32;
/// Optical depth beyond which nothing of a homogeneous medium is looked at.
constexpr double kDarkness = 60;

/// The way to there, m, for the channels that scatter; 0: none does.
double farthest_lit(const glm::dvec3& extinction, const glm::dvec3& scattering) {
    double farthest = 0;
    for (int channel = 0; channel < 3; ++channel)
        if (scattering[channel] > 0) farthest = std::max(farthest, kDarkness / extinction[channel]);
    return farthest;
}

int floor_divide(int a, int b) {
    return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/// Where a file whose third axis points up lies when it is stood up: (x, y, z) goes to (x, z, -y).
glm::dmat4 stood_up() {
    glm::dmat4 turn(1.0);
    turn[1] = {0, 0, -1, 0};
    turn[2] = {0, 1, 0, 0};
    return turn;
}

/// Of voxels low to high, both included; `low` begins a block of 8 voxels.
float largest_voxel(grids::DensityGrid::Reader& reader, glm::ivec3 low, glm::ivec3 high) {
    float largest = 0;
    for (int z = low.z; z <= high.z; z += 8) {
        for (int y = low.y; y <= high.y; y += 8) {
            for (int x = low.x; x <= high.x; x += 8) {
                if (reader.block_is_empty({x, y, z})) continue;
                const glm::ivec3 last = glm::min(high, glm::ivec3(x, y, z) + 7);
                for (int k = z; k <= last.z; ++k)
                    for (int j = y; j <= last.y; ++j)
                        for (int i = x; i <= last.x; ++i)
                            largest = std::max(largest, reader.voxel({i, j, k}));
            }
        }
    }
    return largest;
}

bool any(const glm::dvec3& v) {
    return v.x > 0 || v.y > 0 || v.z > 0;
}

}  // namespace

GridBounds::GridBounds(const grids::DensityGrid& grid) {
    const auto blocks = [&] {
        for (int axis = 0; axis < 3; ++axis) {
            first[axis] = floor_divide(grid.low()[axis] - 1, edge);
            count[axis] = floor_divide(grid.high()[axis] + 1, edge) - first[axis] + 1;
        }
        return static_cast<double>(count.x) * count.y * count.z;
    };
    while (blocks() > kMostBlocks) edge *= 2;
    most.assign(static_cast<std::size_t>(blocks()), 0);
    const auto rows = static_cast<std::size_t>(count.y) * static_cast<std::size_t>(count.z);
    parallel_for(rows, 16, [&](std::size_t begin, std::size_t end) {
        grids::DensityGrid::Reader reader(grid);
        for (std::size_t row = begin; row < end; ++row) {
            const int y = static_cast<int>(row) % count.y, z = static_cast<int>(row) / count.y;
            for (int x = 0; x < count.x; ++x) {
                // Cells reach one voxel into the next block.
                const glm::ivec3 low = edge * (first + glm::ivec3(x, y, z));
                most[row * static_cast<std::size_t>(count.x) + static_cast<std::size_t>(x)] =
                    kRoundUp * largest_voxel(reader, low, low + edge);
            }
        }
    });
}

float GridBounds::at(glm::ivec3 block) const {
    const glm::ivec3 place = block - first;
    for (int axis = 0; axis < 3; ++axis)
        if (place[axis] < 0 || place[axis] >= count[axis]) return 0;
    return most[(static_cast<std::size_t>(place.z) * static_cast<std::size_t>(count.y) +
                 static_cast<std::size_t>(place.y)) *
                    static_cast<std::size_t>(count.x) +
                static_cast<std::size_t>(place.x)];
}

std::optional<Stretch> OwnMedia::Bounded::inside(const glm::dvec3& origin, const glm::dvec3& direction,
                                                 double length) const {
    const auto o = glm::dvec3(local_from_relative * glm::dvec4(origin, 1));
    const auto d = glm::dvec3(local_from_relative * glm::dvec4(direction, 0));
    Stretch stretch{0, length};
    for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == 0) {
            if (o[axis] < low[axis] || o[axis] > high[axis]) return {};
            continue;
        }
        const double a = (low[axis] - o[axis]) / d[axis], b = (high[axis] - o[axis]) / d[axis];
        stretch.begin = std::max(stretch.begin, std::min(a, b));
        stretch.end = std::min(stretch.end, std::max(a, b));
    }
    if (!(stretch.begin < stretch.end)) return {};
    return stretch;
}

OwnMedia::OwnMedia(const scene::FrameScene& scene) {
    water_phase_.emplace(scene.state.water ? scene.state.water->phase : scene::PhaseFunction{});
    if (scene.state.water) {
        water_extinction_ = scene.state.water->extinction();
        water_scattering_ = scene.state.water->scattering;
    }
    for (std::size_t i = 0; i < scene.state.media.size(); ++i) {
        const scene::Medium& medium = scene.state.media[i];
        const glm::dvec3 extinction = medium.density * medium.extinction;
        if (!any(extinction)) continue;
        Bounded bounded{medium.side != scene::MediumSide::water, medium.side != scene::MediumSide::air,
                        extinction, extinction * medium.albedo, OwnPhase(medium.phase)};
        glm::dmat4 relative_from_local = scene::relative_from_object(medium.transform, scene.origin);
        if (medium.type == scene::MediumType::grid) {
            if (i >= scene.medium_grids.size() || !scene.medium_grids[i] || scene.medium_grids[i]->empty())
                continue;
            bounded.grid = scene.medium_grids[i];
            if (medium.z_up) relative_from_local *= stood_up();
            relative_from_local *= bounded.grid->file_from_index();
            bounded.low = glm::dvec3(bounded.grid->low()) - 1.0;
            bounded.high = glm::dvec3(bounded.grid->high()) + 1.0;
        } else {
            relative_from_local = glm::scale(relative_from_local, medium.size);
        }
        const double volume = determinant(glm::dmat3(relative_from_local));
        if (!(std::abs(volume) > 0)) continue;
        bounded.local_from_relative = inverse(relative_from_local);
        if (bounded.grid) bounded.bounds.emplace(*bounded.grid);
        bounded_.push_back(std::move(bounded));
    }
}

bool OwnMedia::any_bounded(bool in_water) const {
    return std::any_of(bounded_.begin(), bounded_.end(), [&](const Bounded& b) { return b.on(in_water); });
}

bool OwnMedia::scatters(bool in_water) const {
    return (in_water && any(water_scattering_)) ||
           std::any_of(bounded_.begin(), bounded_.end(),
                       [&](const Bounded& b) { return b.on(in_water) && any(b.scattering); });
}

glm::dvec3 OwnMedia::through_water(double distance) const {
    glm::dvec3 result(1);
    for (int channel = 0; channel < 3; ++channel)
        if (water_extinction_[channel] > 0)
            result[channel] = std::exp(-water_extinction_[channel] * distance);
    return result;
}

std::optional<Stretch> OwnMedia::scattering_stretch(const glm::dvec3& origin, const glm::dvec3& direction,
                                                    double length, bool in_water) const {
    Stretch hull{kInfinity, 0};
    if (in_water) {
        const double farthest = farthest_lit(water_extinction_, water_scattering_);
        if (farthest > 0) hull = {0, std::min(length, farthest)};
    }
    for (const Bounded& medium : bounded_) {
        if (!medium.on(in_water) || !any(medium.scattering)) continue;
        if (const auto stretch = medium.inside(origin, direction, length)) {
            const double lit = medium.grid ? kInfinity : farthest_lit(medium.extinction, medium.scattering);
            hull.begin = std::min(hull.begin, stretch->begin);
            hull.end = std::max(hull.end, std::min(stretch->end, stretch->begin + lit));
        }
    }
    if (!(hull.begin < hull.end)) return {};
    return hull;
}

MediaProbe::MediaProbe(const OwnMedia& media) : media_(media) {
    for (const OwnMedia::Bounded& medium : media.bounded()) {
        readers_.push_back(medium.grid ? std::make_unique<grids::DensityGrid::Reader>(*medium.grid)
                                       : nullptr);
    }
}

double MediaProbe::density(std::size_t medium, const glm::dvec3& position) {
    const OwnMedia::Bounded& bounded = media_.bounded()[medium];
    const auto at = glm::dvec3(bounded.local_from_relative * glm::dvec4(position, 1));
    for (int axis = 0; axis < 3; ++axis)
        if (at[axis] < bounded.low[axis] || at[axis] > bounded.high[axis]) return 0;
    return bounded.grid ? static_cast<double>(readers_[medium]->density(at)) : 1;
}

glm::dvec3 MediaProbe::scattering(const glm::dvec3& position, double cosine, bool in_water) {
    glm::dvec3 sum(0);
    if (in_water && any(media_.water_scattering()))
        sum = media_.water_phase()(cosine) * media_.water_scattering();
    for (std::size_t i = 0; i < media_.bounded().size(); ++i) {
        const OwnMedia::Bounded& medium = media_.bounded()[i];
        if (!medium.on(in_water)) continue;
        const double there = density(i, position);
        if (there > 0) sum += there * medium.phase(cosine) * medium.scattering;
    }
    return sum;
}

glm::dvec3 MediaProbe::extinction(const glm::dvec3& position, bool in_water) {
    glm::dvec3 sum = in_water ? media_.water_extinction() : glm::dvec3(0);
    for (std::size_t i = 0; i < media_.bounded().size(); ++i) {
        const OwnMedia::Bounded& medium = media_.bounded()[i];
        if (medium.on(in_water)) sum += density(i, position) * medium.extinction;
    }
    return sum;
}

glm::dvec3 MediaProbe::transmittance(const glm::dvec3& origin, const glm::dvec3& direction, double distance,
                                     bool in_water, RandomStream& random) {
    start(origin, direction, in_water);
    return transmittance_to(distance, random);
}

void MediaProbe::start(const glm::dvec3& origin, const glm::dvec3& direction, bool in_water) {
    in_water_ = in_water;
    slabs_.clear();
    walks_.clear();
    for (std::size_t i = 0; i < media_.bounded().size(); ++i) {
        const OwnMedia::Bounded& medium = media_.bounded()[i];
        if (!medium.on(in_water)) continue;
        const auto stretch = medium.inside(origin, direction, kInfinity);
        if (!stretch) continue;
        if (medium.grid)
            start_walk(i, origin, direction, *stretch);
        else
            slabs_.push_back({*stretch, medium.extinction});
    }
}

void MediaProbe::start_walk(std::size_t medium, const glm::dvec3& origin, const glm::dvec3& direction,
                            const Stretch& stretch) {
    Walk walk;
    walk.medium = &media_.bounded()[medium];
    walk.reader = readers_[medium].get();
    walk.origin = glm::dvec3(walk.medium->local_from_relative * glm::dvec4(origin, 1));
    walk.direction = glm::dvec3(walk.medium->local_from_relative * glm::dvec4(direction, 0));
    walk.at = stretch.begin;
    walk.end = stretch.end;
    const double edge = walk.medium->bounds->edge;
    for (int axis = 0; axis < 3; ++axis) {
        const double place = walk.origin[axis] + walk.at * walk.direction[axis];
        const double rate = walk.direction[axis];
        walk.block[axis] = static_cast<int>(std::floor(place / edge));
        walk.step[axis] = rate > 0 ? 1 : -1;
        const double side = edge * (walk.block[axis] + (rate > 0 ? 1 : 0));
        walk.next[axis] = rate == 0 ? kInfinity : (side - walk.origin[axis]) / rate;
        walk.width[axis] = rate == 0 ? kInfinity : edge / std::abs(rate);
    }
    walks_.push_back(walk);
}

void MediaProbe::Walk::advance(double to, RandomStream& random) {
    const double largest = std::max({medium->extinction.x, medium->extinction.y, medium->extinction.z});
    const double goal = std::min(to, end);
    while (at < goal && any(weight)) {
        const int axis = next.x <= next.y ? (next.x <= next.z ? 0 : 2) : (next.y <= next.z ? 1 : 2);
        const double leave = std::min(goal, next[axis]);
        const double majorant = largest * static_cast<double>(medium->bounds->at(block));
        if (majorant * (leave - at) > kMostSteps) {
            cross_cells(leave);
        } else if (majorant > 0) {
            track(leave, majorant, random);
        }
        at = leave;
        if (next[axis] <= goal) {
            block[axis] += step[axis];
            next[axis] += width[axis];
        }
    }
}

void MediaProbe::Walk::track(double leave, double majorant, RandomStream& random) {
    while (any(weight)) {
        at -= std::log1p(-random.next()) / majorant;
        if (at >= leave) return;
        weight *= glm::max(glm::dvec3(0), 1.0 - density() / majorant * medium->extinction);
    }
}

/// Along a line density is a cubic in each cell, for which Simpson's rule is exact.
void MediaProbe::Walk::cross_cells(double leave) {
    const auto place = [&](int axis, double plane) {
        return direction[axis] == 0 ? kInfinity : (plane - origin[axis]) / direction[axis];
    };
    const glm::dvec3 start = origin + at * direction;
    glm::dvec3 plane, side;  // the next that the ray meets, an axis, and m to it
    for (int axis = 0; axis < 3; ++axis) {
        plane[axis] = step[axis] > 0 ? std::floor(start[axis]) + 1 : std::ceil(start[axis]) - 1;
        side[axis] = place(axis, plane[axis]);
    }
    double column = 0, first = density();
    while (at < leave) {
        const int axis = side.x <= side.y ? (side.x <= side.z ? 0 : 2) : (side.y <= side.z ? 1 : 2);
        const double from = at, to = std::clamp(side[axis], at, leave);
        plane[axis] += step[axis];
        side[axis] = place(axis, plane[axis]);
        at = 0.5 * (from + to);
        const double middle = density();
        at = to;
        const double last = density();
        column += (to - from) / 6 * (first + 4 * middle + last);
        first = last;
    }
    weight *= glm::exp(-column * medium->extinction);
}

glm::dvec3 MediaProbe::transmittance_to(double distance, RandomStream& random) {
    glm::dvec3 result = in_water_ ? media_.through_water(distance) : glm::dvec3(1);
    for (const Slab& slab : slabs_) {
        const double way = std::clamp(distance, slab.stretch.begin, slab.stretch.end) - slab.stretch.begin;
        if (way > 0) result *= glm::exp(-way * slab.extinction);
    }
    for (Walk& walk : walks_) {
        if (!any(result)) break;  // nor will there be light farther on
        walk.advance(distance, random);
        result *= walk.weight;
    }
    return result;
}

}  // namespace dapple::reference
