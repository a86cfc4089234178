// What a tile's receivers miss of beams that meet their planes from both sides: cover() leaves those out, as
// what they land on has no end.
#include <array>

#include "methods/sliced_beams/tile.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Barycentric coordinates of the middles of equal parts of a beam, four to a side.
constexpr auto kParts = [] {
    constexpr int kSide = 4;
    std::array<std::array<double, 3>, kSide * kSide> parts{};
    std::size_t n = 0;
    const auto add = [&](double i, double j) { parts[n++] = {i / kSide, j / kSide, 1 - (i + j) / kSide}; };
    for (int i = 0; i < kSide; ++i) {
        for (int j = 0; i + j < kSide; ++j) {
            add(i + 1.0 / 3, j + 1.0 / 3);
            if (i + j + 1 < kSide) add(i + 2.0 / 3, j + 2.0 / 3);
        }
    }
    return parts;
}();

/// Where a part of a beam meets a plane from its front, in footprint coordinates; false: nowhere past the
/// water.
template <class Real>
bool land_part(const ClusterRays<Real>& rays, int chunk, int lane, const std::array<double, 3>& part,
               const LandingFrame<Real>& frame, glm::vec<2, Real>& landed) {
    Vec3<Real> through(0), way(0, 0, 1);
    Real start = 0;
    for (int k = 0; k < 3; ++k) {
        const auto weight = static_cast<Real>(part[static_cast<std::size_t>(k)]);
        const auto& ray = rays.corner[k][chunk];
        through += weight * Vec3<Real>(ray.a[lane], ray.b[lane], 0);
        way += weight * Vec3<Real>(ray.slope_a[lane], ray.slope_b[lane], 0);
        start += weight * ray.start[lane];
    }
    const Vec3<Real> from = through + frame.position.z * way - frame.position;
    const Real facing = glm::dot(frame.normal, way);
    if (!(facing < 0)) return false;
    const Real further = glm::dot(frame.normal, from) / -facing;
    if (frame.position.z + further < start) return false;
    const Vec3<Real> point = from + further * way;
    landed = {glm::dot(frame.along_x, point), glm::dot(frame.along_y, point)};
    return true;
}

}  // namespace

/// Counts that light; what stands in its way is not asked for.
template <class Real>
void Tile<Real>::count_parted() {
    if (whole_allowed_) return;  // no ray meets a plane from behind
    const glm::dvec3& color = sheet_.sheet_.color;
    const double watts = (color.r + color.g + color.b) / 3 / static_cast<double>(kParts.size());
    // `visit(x)` for the landing points of the parts of a cluster's beams that are left out, by their flux.
    const auto visit_parted = [&](NodeId node, const LandingFrame<Real>& frame, const auto& visit) {
        ClusterRays<Real> rays;
        load(sheet_.sheet_, sheet_.triangles(), pyramid_.beams(node), rays);
        for (int chunk = 0; chunk < kChunks<Real>; ++chunk) {
            LandedChunk<Real> landed;
            land(rays, chunk, frame, landed);
            unsigned left_out = bits((rays.flux[chunk] > 0) & ~landed.lands);
            for (; left_out != 0; left_out &= left_out - 1) {
                const int lane = __builtin_ctz(left_out);
                glm::vec<2, Real> point;
                for (const auto& part : kParts)
                    if (land_part(rays, chunk, lane, part, frame, point))
                        visit(point, watts * static_cast<double>(rays.flux[chunk][lane]));
            }
        }
    };
    const auto in_footprint = [](const glm::vec<2, Real>& x) {
        return std::abs(x.x) <= Real(0.5) && std::abs(x.y) <= Real(0.5);
    };
    if (planar_) {
        const LandingFrame<Real> frame(locals_.front().receiver);
        std::vector<PlaneMove<Real>> moves;
        for (const Local& local : locals_) moves.emplace_back(frame, local.receiver);
        for (const NodeId node : clusters_) {
            if (meets(node, locals_.front().receiver, high_) == Meets::all) continue;
            visit_parted(node, frame, [&](const glm::vec<2, Real>& point, double power) {
                for (std::size_t i = 0; i < moves.size(); ++i) {
                    const glm::vec<2, Real> x = point - moves[i].centre;
                    if (in_footprint({glm::dot(moves[i].to_x, x), glm::dot(moves[i].to_y, x)}))
                        counts_.parted += locals_[i].narrow * power;
                }
            });
        }
        return;
    }
    for (const NodeId node : clusters_) {
        const Box<Real> everywhere = box(node);
        for (const Local& local : locals_) {
            const Receiver<Real>& r = local.receiver;
            const Box<Real> own{r.position.x - local.half_a, r.position.x + local.half_a,
                                r.position.y - local.half_b, r.position.y + local.half_b};
            if (!overlap(everywhere, own) || meets(node, r, high_) != Meets::some) continue;
            visit_parted(node, LandingFrame<Real>(r), [&](const glm::vec<2, Real>& point, double power) {
                if (in_footprint(point)) counts_.parted += local.narrow * power;
            });
        }
    }
}

template void Tile<float>::count_parted();
template void Tile<double>::count_parted();

}  // namespace dapple::methods::sliced_beams
