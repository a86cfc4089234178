#include "methods/sliced_beams/beam_ways.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {
namespace {

constexpr std::size_t kPart = 4096;

}  // namespace

template <class Real>
BeamWays<Real>::BeamWays(const SheetCoverage<Real>& sheet) {
    if (!sheet.rays().has_objects() || sheet.pyramid().empty()) return;
    trace_before(sheet);
    trace_after(sheet);
    judge(sheet);
}

/// Which object hides all of the light from each vertex.
template <class Real>
void BeamWays<Real>::trace_before(const SheetCoverage<Real>& coverage) {
    const light::BeamSheet<Real>& sheet = coverage.sheet();
    const std::vector<glm::dvec3>& positions = coverage.scene().water->mesh.positions;
    const glm::dvec3 origin = coverage.scene().origin;
    const glm::vec3 lamp(coverage.lamp());
    // A convex object that hides the corners of a square about the disc hides all of the disc.
    std::vector<glm::vec3> to_sun;
    if (coverage.disc_radius() > 0)
        for (const glm::dvec2& corner : {glm::dvec2(1, 1), {1, -1}, {-1, 1}, {-1, -1}})
            to_sun.emplace_back(coverage.to_sun(corner));
    else
        to_sun.emplace_back(coverage.to_sun({0, 0}));
    hidden_by_.assign(sheet.rays.size(), kNoObject);
    parallel_for(sheet.rays.size(), kPart, [&](std::size_t begin, std::size_t end) {
        std::vector<rays::Ray> rays(end - begin);
        std::vector<rays::Hit> hits(rays.size());
        for (const glm::vec3& direction : to_sun) {
            for (std::size_t i = begin; i < end; ++i) {
                const glm::vec3 from(positions[i] - origin);
                const bool sun = direction != glm::vec3(0);
                rays[i - begin] = {from, 0, sun ? direction : lamp - from,
                                   sun ? std::numeric_limits<float>::infinity() : 1.0f};
            }
            coverage.rays().intersect_objects(rays, hits);
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t object = hits[i - begin].object;
                const bool same = &direction == &to_sun.front() || object == hidden_by_[i];
                hidden_by_[i] = same ? object : kNoObject;
            }
        }
    });
}

/// Where each vertex's ray ends.
template <class Real>
void BeamWays<Real>::trace_after(const SheetCoverage<Real>& coverage) {
    const light::BeamSheet<Real>& sheet = coverage.sheet();
    stop_.assign(sheet.rays.size(), std::numeric_limits<Real>::infinity());
    stopped_by_.assign(sheet.rays.size(), kNoObject);
    parallel_for(sheet.rays.size(), kPart, [&](std::size_t begin, std::size_t end) {
        std::vector<rays::Ray> rays;
        for (std::size_t i = begin; i < end; ++i) {
            const auto& ray = sheet.rays[i];
            const glm::dvec3 slope(ray.slope_a, ray.slope_b, 1);
            const glm::dvec3 from = glm::dvec3(ray.a, ray.b, 0) + static_cast<double>(sheet.start[i]) * slope;
            rays.push_back({glm::vec3(sheet.world_from_mesh * from), 0,
                            glm::vec3(sheet.world_from_mesh * slope),
                            std::numeric_limits<float>::infinity()});
        }
        std::vector<rays::Hit> hits(rays.size());
        coverage.rays().intersect_objects(rays, hits);
        for (std::size_t i = begin; i < end; ++i) {
            const rays::Hit& hit = hits[i - begin];
            if (hit.object == rays::kNoHit || !sheet.valid[i]) continue;
            stopped_by_[i] = hit.object;
            stop_[i] = sheet.start[i] + static_cast<Real>(hit.distance);
        }
    });
}

template <class Real>
void BeamWays<Real>::judge(const SheetCoverage<Real>& coverage) {
    const light::BeamSheet<Real>& sheet = coverage.sheet();
    const BeamPyramid<Real>& pyramid = coverage.pyramid();
    const std::span<const glm::uvec3> triangles = coverage.triangles();
    const Occluders& occluders = coverage.occluders();
    constexpr Real infinity = std::numeric_limits<Real>::infinity();
    // A disc's rays lean from those of its middle by its radius before the water, by its ellipse after it.
    const double lean = glm::length(sheet.disc_u) + glm::length(sheet.disc_v);
    const double spread = coverage.disc_radius();
    const double deepest = static_cast<double>(pyramid.farthest());
    shade_.assign(triangles.size(), 0);
    free_depth_.assign(triangles.size(), infinity);
    last_depth_.assign(triangles.size(), infinity);
    blockers_.assign(triangles.size(), {});

    struct Volume {
        Bounds surface[2], ends[2];
    };
    const auto widen = [&](Volume& volume, std::uint32_t vertex, bool to_stop) {
        const auto& ray = sheet.rays[vertex];
        const glm::dvec3 slope(ray.slope_a, ray.slope_b, 1), zero(ray.a, ray.b, 0);
        const auto start = static_cast<double>(sheet.start[vertex]);
        const double end = to_stop && std::isfinite(stop_[vertex]) ? static_cast<double>(stop_[vertex])
                                                                   : std::max(deepest, start);
        const auto add = [&](Bounds(&bounds)[2], double depth, double room) {
            const glm::dvec3 point = zero + depth * slope;
            for (const double side : {-room, room}) {
                for (const glm::dvec3& p :
                     {point + glm::dvec3(side, side, 0), point + glm::dvec3(side, -side, 0)}) {
                    bounds[0].widen(p);
                    bounds[1].widen(sheet.world_from_mesh * p);
                }
            }
        };
        add(volume.surface, start, 0);
        add(volume.ends, end, lean * (end - start));
    };
    /// The object that stops or hides all, kNoObject where none does; false: they differ.
    const auto common = [](const std::vector<std::uint32_t>& objects, std::span<const std::uint32_t> vertices,
                           std::uint32_t& object) {
        object = objects[vertices.front()];
        return std::all_of(vertices.begin(), vertices.end(),
                           [&](std::uint32_t v) { return objects[v] == object; });
    };
    const auto shade_of = [&](const Volume& volume, std::span<const std::uint32_t> vertices) {
        std::uint8_t shade = 0;
        std::uint32_t object;
        if (common(hidden_by_, vertices, object) && object != kNoObject && occluders.convex(object))
            return static_cast<std::uint8_t>(kDark);
        if (object != kNoObject || !occluders.free_before_water(volume.surface[1], spread))
            shade |= kMixedBefore;
        const bool one = common(stopped_by_, vertices, object);
        if (!one || (object != kNoObject && !occluders.convex(object)) ||
            !occluders.free_after_water(volume.surface, volume.ends, object))
            shade |= kMixedAfter;
        else if (object != kNoObject)
            shade |= kCut;
        return shade;
    };
    using NodeId = typename BeamPyramid<Real>::NodeId;
    const std::size_t columns = pyramid.columns(0), clusters = pyramid.rows(0) * columns;
    parallel_for(clusters, kPart / 8, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> vertices;
        for (std::size_t i = begin; i < end; ++i) {
            const NodeId node{0, static_cast<std::uint32_t>(i / columns),
                              static_cast<std::uint32_t>(i % columns)};
            if (pyramid.dark(node)) continue;
            const auto beams = pyramid.beams(node);
            vertices.clear();
            Volume all;
            for (const std::uint32_t beam : beams) {
                if (beam == kNoBeam || !(sheet.flux[beam] > 0)) continue;
                for (int k = 0; k < 3; ++k) {
                    vertices.push_back(triangles[beam][k]);
                    widen(all, vertices.back(), true);
                }
            }
            const std::uint8_t together = shade_of(all, vertices);
            for (const std::uint32_t beam : beams) {
                if (beam == kNoBeam || !(sheet.flux[beam] > 0)) continue;
                const glm::uvec3& t = triangles[beam];
                const std::uint32_t corners[3] = {t.x, t.y, t.z};
                std::uint8_t& shade = shade_[beam];
                shade = together;
                if (together & (kMixedAfter | kMixedBefore)) {
                    Volume own;
                    for (const std::uint32_t v : corners) widen(own, v, true);
                    shade = shade_of(own, corners);
                    if (shade & kMixedAfter) {
                        // Objects may stand deeper than the vertices' rays get.
                        for (const std::uint32_t v : corners) widen(own, v, false);
                        free_depth_[beam] = static_cast<Real>(occluders.first_depth(own.surface, own.ends));
                        blockers_[beam].after = occluders.after_water(own.surface, own.ends);
                    }
                    if (shade & kMixedBefore)
                        blockers_[beam].before = occluders.before_water(own.surface[1], spread);
                }
                if (shade & kDark) last_depth_[beam] = -infinity;
                if (shade & kCut) last_depth_[beam] = std::max({stop_[t.x], stop_[t.y], stop_[t.z]});
            }
        }
    });
    if (std::all_of(shade_.begin(), shade_.end(), [](std::uint8_t shade) { return shade == 0; })) *this = {};
}

template <class Real>
void BeamWays<Real>::report(FrameStats& stats) const {
    std::size_t cut = 0, mixed = 0, dark = 0;
    for (const std::uint8_t shade : shade_) {
        cut += (shade & kCut) != 0;
        dark += (shade & kDark) != 0;
        mixed += (shade & (kMixedAfter | kMixedBefore)) != 0;
    }
    stats.count("beams cut by objects", static_cast<double>(cut));
    stats.count("beams in shadow", static_cast<double>(dark));
    stats.count("beams tested by shadow rays", static_cast<double>(mixed));
}

template class BeamWays<float>;
template class BeamWays<double>;

}  // namespace dapple::methods::sliced_beams
