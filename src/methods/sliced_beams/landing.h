#pragma once
#include <cmath>
#include <glm/glm.hpp>

#include "methods/sliced_beams/beam_pyramid.h"
#include "methods/sliced_beams/coverage.h"

namespace dapple::methods::sliced_beams {

template <class Real>
using Vec3 = glm::vec<3, Real>;

/// A receiver: a footprint of edges u and v about a point, on its tangent plane. m, relative to
/// FrameScene::origin, in world axes or in a sheet's.
template <class Real>
struct Receiver {
    Vec3<Real> position, u, v;
    Vec3<Real> normal;  ///< unit, towards the side that is looked at
};

/// Landing points on a receiver's plane in its footprint coordinates: x = along_x . (point - position).
template <class Real>
struct LandingFrame {
    Vec3<Real> position, normal, along_x, along_y;

    LandingFrame() = default;
    explicit LandingFrame(const Receiver<Real>& r) : position(r.position), normal(r.normal) {
        const Vec3<Real> across = glm::cross(r.u, r.v);
        const Real scale = 1 / glm::dot(across, r.normal);
        along_x = scale * glm::cross(r.v, r.normal);
        along_y = scale * glm::cross(r.normal, r.u);
    }
};

/// From one receiver's footprint coordinates to those of another one on the same plane: x' = to_x . (x -
/// centre).
template <class Real>
struct PlaneMove {
    glm::vec<2, Real> centre, to_x, to_y;
    Real half_x, half_y;  ///< half the extent of the other footprint in the first one's coordinates

    PlaneMove(const LandingFrame<Real>& frame, const Receiver<Real>& r) {
        const Vec3<Real> offset = r.position - frame.position;
        centre = {glm::dot(frame.along_x, offset), glm::dot(frame.along_y, offset)};
        const Real ux = glm::dot(frame.along_x, r.u), uy = glm::dot(frame.along_y, r.u);
        const Real vx = glm::dot(frame.along_x, r.v), vy = glm::dot(frame.along_y, r.v);
        const Real scale = 1 / (ux * vy - uy * vx);
        to_x = {scale * vy, -scale * vx};
        to_y = {-scale * uy, scale * ux};
        half_x = Real(0.5) * (std::abs(ux) + std::abs(vx));
        half_y = Real(0.5) * (std::abs(uy) + std::abs(vy));
    }
    LandedBeams<Real> operator()(const LandedBeams<Real>& landed) const {
        LandedBeams<Real> moved;
        for (int k = 0; k < 3; ++k) {
            const Lanes<Real> dx = landed.x[k] - centre.x, dy = landed.y[k] - centre.y;
            moved.x[k] = to_x.x * dx + to_x.y * dy;
            moved.y[k] = to_y.x * dx + to_y.y * dy;
        }
        return moved;
    }
};

/// The rays of up to eight beams, a lane each.
template <class Real>
struct ClusterRays {
    struct Corner {
        Lanes<Real> a, b, slope_a, slope_b, start;
    };
    Corner corner[3][kChunks<Real>];
    Lanes<Real> flux[kChunks<Real>];
    std::array<std::uint32_t, kClusterBeams> beam;
};

template <class Real>
inline void load(const light::BeamSheet<Real>& sheet, std::span<const glm::uvec3> triangles,
                 const std::array<std::uint32_t, kClusterBeams>& beams, ClusterRays<Real>& rays) {
    rays.beam = beams;
    for (int i = 0; i < kClusterBeams; ++i) {
        const int chunk = i / kLanes<Real>, lane = i % kLanes<Real>;
        // A missing beam repeats a neighbour's rays, with no flux.
        const std::uint32_t beam = beams[static_cast<std::size_t>(i)];
        const std::uint32_t shown = beam == kNoBeam ? beams[0] : beam;
        rays.flux[chunk][lane] = beam == kNoBeam ? Real(0) : sheet.flux[beam];
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t vertex = triangles[shown][k];
            const auto& ray = sheet.rays[vertex];
            auto& corner = rays.corner[k][chunk];
            corner.a[lane] = ray.a;
            corner.b[lane] = ray.b;
            corner.slope_a[lane] = ray.slope_a;
            corner.slope_b[lane] = ray.slope_b;
            corner.start[lane] = sheet.start[vertex];
        }
    }
}

/// A beam's three landing points, and how far below the water they lie.
template <class Real>
struct LandedChunk {
    LandedBeams<Real> beams;
    Lanes<Real> past_start[3];  ///< m of depth from where the ray leaves the water; < 0: not in the light
    Lanes<Real> way;            ///< m, mean length of the ways from the water
    Mask<Real> lands;           ///< all three rays meet the plane from its front
};

template <class Real>
inline void land(const ClusterRays<Real>& rays, int chunk, const LandingFrame<Real>& frame,
                 LandedChunk<Real>& landed) {
    using L = Lanes<Real>;
    L way{};
    // Rays within 1e-4 of the plane's direction land too far off to say anything of it.
    const L grazing = splat<Real>(Real(-1e-4));
    landed.lands = rays.flux[chunk] > 0;
    for (int k = 0; k < 3; ++k) {
        const auto& ray = rays.corner[k][chunk];
        const L a = ray.a + frame.position.z * ray.slope_a - frame.position.x;
        const L b = ray.b + frame.position.z * ray.slope_b - frame.position.y;
        const L facing = frame.normal.x * ray.slope_a + frame.normal.y * ray.slope_b + frame.normal.z;
        const auto meets = facing < grazing;
        const L further = (frame.normal.x * a + frame.normal.y * b) / (meets ? -facing : splat<Real>(1));
        landed.lands &= meets;
        landed.beams.x[k] =
            frame.along_x.x * a + frame.along_x.y * b +
            further * (frame.along_x.x * ray.slope_a + frame.along_x.y * ray.slope_b + frame.along_x.z);
        landed.beams.y[k] =
            frame.along_y.x * a + frame.along_y.y * b +
            further * (frame.along_y.x * ray.slope_a + frame.along_y.y * ray.slope_b + frame.along_y.z);
        landed.past_start[k] = frame.position.z + further - ray.start;
        const L stretch =
            square_root<Real>(splat<Real>(1) + ray.slope_a * ray.slope_a + ray.slope_b * ray.slope_b);
        way += landed.past_start[k] * stretch;
    }
    landed.way = way / Real(3);
}

}  // namespace dapple::methods::sliced_beams
