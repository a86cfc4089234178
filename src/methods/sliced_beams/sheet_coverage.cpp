#include "methods/sliced_beams/sheet_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "methods/sliced_beams/tile.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Extremes over the vertices that have a ray.
template <class Real>
struct SheetExtremes {
    Real first_start = std::numeric_limits<Real>::infinity();
    Real last_start = -std::numeric_limits<Real>::infinity();
    Real steepest_a = 0, steepest_b = 0;
};

template <class Real>
SheetExtremes<Real> find_extremes(const light::BeamSheet<Real>& sheet) {
    constexpr std::size_t kPart = 1 << 14;
    std::vector<SheetExtremes<Real>> parts(sheet.rays.size() / kPart + 1);
    parallel_for(sheet.rays.size(), kPart, [&](std::size_t begin, std::size_t end) {
        SheetExtremes<Real> e;
        for (std::size_t i = begin; i < end; ++i) {
            if (!sheet.valid[i]) continue;
            e.first_start = std::min(e.first_start, sheet.start[i]);
            e.last_start = std::max(e.last_start, sheet.start[i]);
            e.steepest_a = std::max(e.steepest_a, std::abs(sheet.rays[i].slope_a));
            e.steepest_b = std::max(e.steepest_b, std::abs(sheet.rays[i].slope_b));
        }
        parts[begin / kPart] = e;
    });
    SheetExtremes<Real> all;
    for (const SheetExtremes<Real>& e : parts) {
        all.first_start = std::min(all.first_start, e.first_start);
        all.last_start = std::max(all.last_start, e.last_start);
        all.steepest_a = std::max(all.steepest_a, e.steepest_a);
        all.steepest_b = std::max(all.steepest_b, e.steepest_b);
    }
    return all;
}

/// Square root of a symmetric positive matrix (1 + positive): Cayley & Hamilton's theorem in two dimensions.
template <class Real>
glm::mat<2, 2, Real> square_root_of(const glm::mat<2, 2, Real>& m) {
    const Real determinant = std::sqrt(m[0][0] * m[1][1] - m[0][1] * m[1][0]);
    const Real trace = std::sqrt(m[0][0] + m[1][1] + 2 * determinant);
    return (m + glm::mat<2, 2, Real>(determinant)) / trace;
}

}  // namespace

void QueryCounts::add(const QueryCounts& other) {
    clusters += other.clusters;
    whole_nodes += other.whole_nodes;
    occluded_tiles += other.occluded_tiles;
    shadow_rays += other.shadow_rays;
    parted += other.parted;
}

void QueryCounts::report(FrameStats& stats) const {
    stats.count("beam clusters found", static_cast<double>(clusters));
    stats.count("nodes added whole", static_cast<double>(whole_nodes));
    stats.count("tiles with occluders", static_cast<double>(occluded_tiles));
    stats.count("caustic shadow rays", static_cast<double>(shadow_rays));
    if (parted > 0) stats.count("lost to planes met from both sides, W", parted);
}

template <class Real>
SheetCoverage<Real>::SheetCoverage(const scene::FrameScene& scene, const rays::RayScene& rays,
                                   light::BeamSheet<Real> sheet, Real deepest)
    : scene_(scene),
      rays_(rays),
      sheet_(std::move(sheet)),
      sheet_from_world_(glm::transpose(sheet_.world_from_mesh)),
      occluders_(scene, sheet_) {
    const SheetExtremes<Real> extremes = find_extremes(sheet_);
    const bool lit = extremes.first_start <= extremes.last_start;
    steepest_a_ = extremes.steepest_a;
    steepest_b_ = extremes.steepest_b;
    if (sheet_.in_water()) extinction_ = scene.state.water->extinction();
    const std::span<const glm::uvec3> beams =
        lit ? std::span<const glm::uvec3>(scene.water->mesh.triangles) : std::span<const glm::uvec3>();
    if (lit && !scene.state.media.empty())
        columns_ = RayColumns<Real>(std::make_shared<media::Media>(scene), sheet_, beams);
    pyramid_ = std::make_unique<BeamPyramid<Real>>(sheet_, beams, lit ? extremes.first_start : 0, deepest);
}

template <class Real>
double SheetCoverage<Real>::disc_radius() const {
    if (!blurs()) return 0;
    const double whole =
        std::tan(0.5 * scene_.state.lights[static_cast<std::size_t>(sheet_.light)].angular_diameter);
    return whole / std::sqrt(std::max(1, scene_.state.caustics.sliced_beams.sun_samples));
}

template <class Real>
glm::dvec3 SheetCoverage<Real>::to_sun(glm::dvec2 disc) const {
    const glm::dvec3 travel = sheet_.light_direction;
    if (travel == glm::dvec3(0)) return travel;
    // In the plane of incidence and across it.
    glm::dvec3 across = glm::cross(travel, glm::dvec3(0, 1, 0));
    across = glm::dot(across, across) > 1e-24 ? glm::normalize(across) : glm::dvec3(1, 0, 0);
    return -glm::normalize(travel + disc_radius() * (disc.x * glm::cross(across, travel) + disc.y * across));
}

template <class Real>
Receiver<Real> SheetCoverage<Real>::rotated(const Receiver<Real>& world) const {
    return {sheet_from_world_ * world.position, sheet_from_world_ * world.u, sheet_from_world_ * world.v,
            sheet_from_world_ * world.normal};
}

template <class Real>
Receiver<Real> SheetCoverage<Real>::in_sheet(const Receiver<Real>& world) const {
    Receiver<Real> r = rotated(world);
    if (sheet_.disc_u == glm::dvec2(0) && sheet_.disc_v == glm::dvec2(0)) return r;
    // Seen along the axis, the disc's image is an ellipse; footprint and ellipse together are replaced by the
    // parallelogram of the same second moments (that of the footprint is (u u^T + v v^T) / 12, that of an
    // ellipse of semi-axes e, f (e e^T + f f^T) / 4), which in footprint coordinates is a symmetric matrix.
    using Vec2 = glm::vec<2, Real>;
    using Mat2 = glm::mat<2, 2, Real>;
    const Real way = this->way(world.position);
    const Mat2 across(Vec2(r.u), Vec2(r.v));
    const Real determinant = glm::determinant(across);
    // A plane along the light has no image of the disc; it catches next to nothing of it.
    if (!(way > 0) || std::abs(determinant) < Real(1e-3) * glm::length(glm::cross(r.u, r.v))) return r;
    const Mat2 inverse = glm::inverse(across);
    const Vec2 e = inverse * (way * Vec2(sheet_.disc_u)), f = inverse * (way * Vec2(sheet_.disc_v));
    const Mat2 moments = Mat2(1) + Real(3) * (glm::outerProduct(e, e) + glm::outerProduct(f, f));
    const Mat2 widened = square_root_of(moments);
    const Vec3<Real> u = widened[0][0] * r.u + widened[0][1] * r.v;
    r.v = widened[1][0] * r.u + widened[1][1] * r.v;
    r.u = u;
    return r;
}

template <class Real>
void SheetCoverage<Real>::add(std::span<const Receiver<Real>> receivers, std::uint32_t object,
                              std::span<Vec3<Real>> irradiance, QueryCounts& counts,
                              std::span<std::uint8_t> hidden) const {
    if (pyramid_->empty()) return;
    Tile<Real>(*this, receivers, object, irradiance, counts, hidden).run();
}

template class SheetCoverage<float>;
template class SheetCoverage<double>;

}  // namespace dapple::methods::sliced_beams
