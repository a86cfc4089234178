#include "methods/sliced_beams/beam_pyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {
namespace {

template <class Real>
Box<Real> no_box() {
    constexpr Real infinity = std::numeric_limits<Real>::infinity();
    return {infinity, -infinity, infinity, -infinity};
}

template <class Real>
void widen(Box<Real>& box, Real a, Real b) {
    box.low_a = std::min(box.low_a, a);
    box.high_a = std::max(box.high_a, a);
    box.low_b = std::min(box.low_b, b);
    box.high_b = std::max(box.high_b, b);
}

/// By the box of other beams, which may be empty: where none of them carries light.
template <class Real>
void widen(Box<Real>& box, const Box<Real>& other) {
    box.low_a = std::min(box.low_a, other.low_a);
    box.high_a = std::max(box.high_a, other.high_a);
    box.low_b = std::min(box.low_b, other.low_b);
    box.high_b = std::max(box.high_b, other.high_b);
}

template <class Real>
Real size(const Box<Real>& box) {
    return box.high_a - box.low_a + box.high_b - box.low_b;
}

/// Spreads the lower 16 bits to the even places.
std::uint32_t spread(std::uint32_t x) {
    x &= 0xffff;
    x = (x | x << 8) & 0x00ff00ff;
    x = (x | x << 4) & 0x0f0f0f0f;
    x = (x | x << 2) & 0x33333333;
    return (x | x << 1) & 0x55555555;
}

}  // namespace

template <class Real>
BeamPyramid<Real>::BeamPyramid(const light::BeamSheet<Real>& sheet, std::span<const glm::uvec3> triangles,
                               Real nearest, Real farthest)
    : sheet_(sheet), nearest_(nearest), farthest_(std::max(nearest, farthest)) {
    if (triangles.empty()) return;
    if (sheet_.rows == 0) order_indexed(triangles);
    build_finest(triangles);
    while (levels_.back().rows * levels_.back().columns > 1) levels_.push_back(coarser(levels_.back()));
}

/// Morton order of the triangles' centres where their rays leave the water.
template <class Real>
void BeamPyramid<Real>::order_indexed(std::span<const glm::uvec3> triangles) {
    const auto centre = [&](const glm::uvec3& t) {
        glm::dvec2 sum(0);
        for (int k = 0; k < 3; ++k) {
            const auto& ray = sheet_.rays[t[k]];
            const double depth = static_cast<double>(sheet_.start[t[k]]);
            sum += glm::dvec2(static_cast<double>(ray.a) + depth * static_cast<double>(ray.slope_a),
                              static_cast<double>(ray.b) + depth * static_cast<double>(ray.slope_b));
        }
        return sum / 3.0;
    };
    glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::uvec3& t : triangles) {
        low = glm::min(low, centre(t));
        high = glm::max(high, centre(t));
    }
    const glm::dvec2 scale = 65535.0 / glm::max(high - low, glm::dvec2(1e-30));
    std::vector<std::uint64_t> keys(triangles.size());
    parallel_for(triangles.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::dvec2 place = glm::clamp((centre(triangles[i]) - low) * scale, 0.0, 65535.0);
            const std::uint64_t code = spread(static_cast<std::uint32_t>(place.x)) |
                                       spread(static_cast<std::uint32_t>(place.y)) << 1;
            keys[i] = code << 32 | i;
        }
    });
    std::sort(keys.begin(), keys.end());
    order_.resize(keys.size());
    std::transform(keys.begin(), keys.end(), order_.begin(),
                   [](std::uint64_t key) { return static_cast<std::uint32_t>(key); });
}

template <class Real>
std::array<std::uint32_t, kClusterBeams> BeamPyramid<Real>::beams(NodeId node) const {
    std::array<std::uint32_t, kClusterBeams> result;
    if (sheet_.rows == 0) {
        const std::size_t first = std::size_t{kClusterBeams} * node.column;
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = first + i < order_.size() ? order_[first + i] : kNoBeam;
        return result;
    }
    const auto rows = static_cast<std::uint32_t>(sheet_.rows - 1);
    const auto columns = static_cast<std::uint32_t>(sheet_.columns - 1);
    for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t r = 2 * node.row + i / 2, c = 2 * node.column + i % 2;
        const bool inside = r < rows && c < columns;
        for (std::uint32_t half = 0; half < 2; ++half)
            result[2 * i + half] = inside ? 2 * (r * columns + c) + half : kNoBeam;
    }
    return result;
}

template <class Real>
void BeamPyramid<Real>::build_finest(std::span<const glm::uvec3> triangles) {
    Level level;
    if (sheet_.rows == 0) {
        level.rows = 1;
        level.columns = static_cast<std::uint32_t>((triangles.size() + kClusterBeams - 1) / kClusterBeams);
    } else {
        level.rows = static_cast<std::uint32_t>(sheet_.rows) / 2;
        level.columns = static_cast<std::uint32_t>(sheet_.columns) / 2;
    }
    const std::size_t count = static_cast<std::size_t>(level.rows) * level.columns;
    level.ends.resize(count);
    level.sums.resize(count);
    const auto node = [&](std::size_t i) {
        return NodeId{0, static_cast<std::uint32_t>(i / level.columns),
                      static_cast<std::uint32_t>(i % level.columns)};
    };
    constexpr std::size_t kPart = 4096;
    std::vector<Real> steepest(count / kPart + 1, 0);
    parallel_for(count, kPart, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Ends ends{no_box<Real>(), no_box<Real>()};
            Box<Real> slopes = no_box<Real>();
            Sums sums;
            for (const std::uint32_t beam : beams(node(i))) {
                if (beam == kNoBeam || !(sheet_.flux[beam] > 0)) continue;
                const Real third = sheet_.flux[beam] / 3;
                for (int k = 0; k < 3; ++k) {
                    const std::uint32_t vertex = triangles[beam][k];
                    const auto& ray = sheet_.rays[vertex];
                    widen(ends.near, ray.a + nearest_ * ray.slope_a, ray.b + nearest_ * ray.slope_b);
                    widen(ends.far, ray.a + farthest_ * ray.slope_a, ray.b + farthest_ * ray.slope_b);
                    const Real stretch = std::sqrt(1 + ray.slope_a * ray.slope_a + ray.slope_b * ray.slope_b);
                    sums += {0,
                             third * ray.a,
                             third * ray.b,
                             third * ray.slope_a,
                             third * ray.slope_b,
                             third * sheet_.start[vertex],
                             third * stretch,
                             sheet_.start[vertex],
                             sheet_.start[vertex],
                             0,
                             {}};
                    widen(slopes, ray.slope_a, ray.slope_b);
                }
                sums.flux += sheet_.flux[beam];
                sums.tinted += sheet_.flux[beam] * sheet_.tint_of(beam);
            }
            if (sums.flux > 0) {
                sums.bend = std::max(size(ends.near), size(ends.far)) * size(slopes);
                steepest[i / kPart] =
                    std::max({steepest[i / kPart], std::abs(slopes.low_a), std::abs(slopes.high_a),
                              std::abs(slopes.low_b), std::abs(slopes.high_b)});
            }
            level.ends[i] = ends;
            level.sums[i] = sums;
        }
    });
    steepest_ = *std::max_element(steepest.begin(), steepest.end());
    levels_.push_back(std::move(level));
}

template <class Real>
typename BeamPyramid<Real>::Level BeamPyramid<Real>::coarser(const Level& finer) const {
    Level level;
    level.rows = (finer.rows + 1) / 2;
    level.columns = (finer.columns + 1) / 2;
    const std::size_t count = static_cast<std::size_t>(level.rows) * level.columns;
    level.ends.resize(count);
    level.sums.resize(count);
    parallel_for(
        level.rows, std::max<std::size_t>(1, 4096 / level.columns), [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                for (std::size_t c = 0; c < level.columns; ++c) {
                    Ends ends{no_box<Real>(), no_box<Real>()};
                    Sums sums;
                    for (std::size_t row = 2 * r; row < std::min<std::size_t>(finer.rows, 2 * r + 2); ++row) {
                        for (std::size_t column = 2 * c;
                             column < std::min<std::size_t>(finer.columns, 2 * c + 2); ++column) {
                            const std::size_t child = row * finer.columns + column;
                            widen(ends.near, finer.ends[child].near);
                            widen(ends.far, finer.ends[child].far);
                            sums += finer.sums[child];
                        }
                    }
                    level.ends[r * level.columns + c] = ends;
                    level.sums[r * level.columns + c] = sums;
                }
            }
        });
    return level;
}

template <class Real>
Box<Real> BeamPyramid<Real>::box(NodeId node, Real low, Real high, Real lean) const {
    const Ends& ends = levels_[node.level].ends[index(node)];
    if (!(ends.near.low_a <= ends.near.high_a)) return no_box<Real>();
    const Real range = farthest_ - nearest_;
    const Real t0 = range > 0 ? std::clamp((low - nearest_) / range, Real(0), Real(1)) : Real(0);
    const Real t1 = range > 0 ? std::clamp((high - nearest_) / range, Real(0), Real(1)) : Real(0);
    const auto at = [](Real near, Real far, Real t) { return near + t * (far - near); };
    // A few roundings of room: a corner of the node must never fall outside.
    // Beyond the farthest depth (a footprint may reach there) the bounds grow as fast as any ray can move.
    const Real room =
        lean * levels_[node.level].sums[index(node)].bend + std::max(Real(0), high - farthest_) * steepest_ +
        Real(8) * std::numeric_limits<Real>::epsilon() *
            std::max({std::abs(ends.near.low_a), std::abs(ends.near.high_a), std::abs(ends.near.low_b),
                      std::abs(ends.near.high_b), std::abs(ends.far.low_a), std::abs(ends.far.high_a),
                      std::abs(ends.far.low_b), std::abs(ends.far.high_b), std::abs(farthest_)});
    Box<Real> box;
    box.low_a =
        std::min(at(ends.near.low_a, ends.far.low_a, t0), at(ends.near.low_a, ends.far.low_a, t1)) - room;
    box.high_a =
        std::max(at(ends.near.high_a, ends.far.high_a, t0), at(ends.near.high_a, ends.far.high_a, t1)) + room;
    box.low_b =
        std::min(at(ends.near.low_b, ends.far.low_b, t0), at(ends.near.low_b, ends.far.low_b, t1)) - room;
    box.high_b =
        std::max(at(ends.near.high_b, ends.far.high_b, t0), at(ends.near.high_b, ends.far.high_b, t1)) + room;
    return box;
}

template <class Real>
typename BeamPyramid<Real>::Meets BeamPyramid<Real>::meets(NodeId node, const glm::vec<3, Real>& point,
                                                           const glm::vec<3, Real>& normal) const {
    const Ends& ends = levels_[node.level].ends[index(node)];
    // Extremes of the height over the plane.
    const auto height = [&](const Box<Real>& box, Real depth, Real& low, Real& high) {
        const auto span = [&](Real n, Real from, Real to) {
            low += std::min(n * from, n * to);
            high += std::max(n * from, n * to);
        };
        low = high = normal.z * (depth - point.z);
        span(normal.x, box.low_a - point.x, box.high_a - point.x);
        span(normal.y, box.low_b - point.y, box.high_b - point.y);
    };
    Real near_low, near_high, far_low, far_high;
    height(ends.near, nearest_, near_low, near_high);
    height(ends.far, farthest_, far_low, far_high);
    // Rounding of points and of receivers that are taken to share a plane.
    const Real room =
        Real(64) * std::numeric_limits<Real>::epsilon() *
        (std::max({std::abs(point.x), std::abs(point.y), std::abs(point.z)}) +
         std::max({std::abs(near_low), std::abs(near_high), std::abs(far_low), std::abs(far_high)}));
    if (near_low > room && far_high < -room) return Meets::all;
    if (near_high < -room || far_low > room) return Meets::none;
    return Meets::some;
}

template class BeamPyramid<float>;
template class BeamPyramid<double>;

}  // namespace dapple::methods::sliced_beams
