#include "methods/sliced_beams/scatter_sheet.h"

#include <algorithm>

#include "methods/sliced_beams/scatter_query.h"

namespace dapple::methods::sliced_beams {

void ScatterCounts::add(const ScatterCounts& other) {
    clusters += other.clusters;
    beams += other.beams;
    intervals += other.intervals;
    peaks += other.peaks;
    cut += other.cut;
    shadow_tests += other.shadow_tests;
    shadow_rays += other.shadow_rays;
    foci += other.foci;
    dropped += other.dropped;
}

void ScatterCounts::report(FrameStats& stats) const {
    stats.count("segments times clusters", static_cast<double>(clusters));
    stats.count("segments times beams", static_cast<double>(beams));
    stats.count("intervals in beams", static_cast<double>(intervals));
    stats.count("intervals that peak", static_cast<double>(peaks));
    stats.count("intervals cut", static_cast<double>(cut));
    stats.count("volume shadow tests", static_cast<double>(shadow_tests));
    stats.count("volume shadow rays", static_cast<double>(shadow_rays));
    if (foci > 0) stats.count("intervals through foci", static_cast<double>(foci));
    if (dropped > 0) stats.count("intervals not finite", static_cast<double>(dropped));
}

template <class Real>
ScatterSheet<Real>::ScatterSheet(const SheetCoverage<Real>& sheet)
    : coverage_(sheet),
      ways_(sheet),
      bounds_(sheet.sheet(), sheet.pyramid(), sheet.triangles(), ways_.last_depths()),
      clusters_(beam_clusters(sheet, ways_)),
      shapes_(sheet.scene(), sheet.sheet()) {}

template <class Real>
bool ScatterSheet<Real>::keep_mixed() {
    std::vector<std::uint8_t> left_out(clusters_.size());
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
        BeamCluster<Real>& cluster = clusters_[i];
        auto* const end = std::remove_if(cluster.beam, cluster.beam + cluster.beams, [](const auto& beam) {
            return (beam.shade & (BeamWays<Real>::kMixedAfter | BeamWays<Real>::kMixedBefore)) == 0;
        });
        cluster.beams = static_cast<std::uint8_t>(end - cluster.beam);
        left_out[i] = cluster.beams == 0 ? 1 : 0;
    }
    const bool any = std::find(left_out.begin(), left_out.end(), 0) != left_out.end();
    bounds_.leave_out(std::move(left_out));
    return any;
}

template <class Real>
LightDirection<Real> ScatterSheet<Real>::direction(glm::dvec2 disc) const {
    const light::BeamSheet<Real>& sheet = coverage_.sheet();
    return {glm::vec<2, Real>(disc.x * sheet.disc_u + disc.y * sheet.disc_v),
            glm::vec3(coverage_.to_sun(disc))};
}

template <class Real>
glm::dvec3 ScatterSheet<Real>::collapsed() const {
    const light::BeamSheet<Real>& sheet = coverage_.sheet();
    glm::dvec3 power(0);
    for (std::size_t i = 0; i < sheet.flux.size(); ++i) {
        if (!(sheet.flux[i] > 0)) continue;
        const glm::uvec3& t = coverage_.triangles()[i];
        const auto &p = sheet.rays[t.x], &q = sheet.rays[t.y], &r = sheet.rays[t.z];
        const glm::vec<2, Real> e0(q.a - p.a, q.b - p.b), e1(q.slope_a - p.slope_a, q.slope_b - p.slope_b);
        const glm::vec<2, Real> f0(r.a - p.a, r.b - p.b), f1(r.slope_a - p.slope_a, r.slope_b - p.slope_b);
        const auto cross = [](const glm::vec<2, Real>& x, const glm::vec<2, Real>& y) {
            return x.x * y.y - y.x * x.y;
        };
        if (cross(e0, f0) == 0 && cross(e1, f0) + cross(e0, f1) == 0 && cross(e1, f1) == 0)
            power += sheet.power(i);
    }
    return power;
}

template <class Real>
SegmentLanes<Real> ScatterSheet<Real>::in_sheet(const SegmentGroup<Real>& group) const {
    const glm::mat<3, 3, Real> world_from_sheet(coverage_.sheet().world_from_mesh);
    const auto along = [&](const Lanes<Real>(&v)[3], int axis) {
        return world_from_sheet[axis].x * v[0] + world_from_sheet[axis].y * v[1] +
               world_from_sheet[axis].z * v[2];
    };
    return {along(group.origin, 0),
            along(group.origin, 1),
            along(group.origin, 2),
            along(group.direction, 0),
            along(group.direction, 1),
            along(group.direction, 2),
            group.length};
}

template <class Real>
void ScatterSheet<Real>::add(const SegmentGroup<Real>& segments, const LightDirection<Real>& direction,
                             const EvenMedium<Real>& medium, const UnevenGroup<Real>* uneven,
                             Lanes<Real> (&radiance)[3], ScatterCounts& counts) const {
    if (coverage_.pyramid().empty()) return;
    SegmentLanes<Real> lanes = in_sheet(segments);
    if (medium.least > 0) lanes.length = lesser(lanes.length, splat(Real(media::kOpaque) / medium.least));
    if (uneven) {
        for (int lane = 0; lane < kLanes<Real>; ++lane) {
            if (!uneven->uneven[lane]) continue;
            const SegmentScatter& scatter = uneven->scatter[lane];
            // A little more: what is taken is cut by the scattering itself.
            lanes.first[lane] = static_cast<Real>(scatter.first()) * (1 - Real(1e-6));
            lanes.length[lane] = scatter.first() < scatter.last()
                                     ? static_cast<Real>(scatter.last()) * (1 + Real(1e-6))
                                     : Real(-1);
        }
    }
    ScatterQuery<Real>(*this, lanes, direction, medium, uneven, radiance, counts).run();
}

template class ScatterSheet<float>;
template class ScatterSheet<double>;

}  // namespace dapple::methods::sliced_beams
