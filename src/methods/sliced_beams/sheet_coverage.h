#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "base/stats.h"
#include "methods/sliced_beams/beam_pyramid.h"
#include "methods/sliced_beams/landing.h"
#include "methods/sliced_beams/occluders.h"
#include "methods/sliced_beams/ray_columns.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

/// At most so many receivers are asked for at one go.
constexpr int kTileReceivers = 64;

/// What a query cost.
struct QueryCounts {
    std::size_t clusters = 0;        ///< of beams, found by tiles
    std::size_t whole_nodes = 0;     ///< added by their sums
    std::size_t occluded_tiles = 0;  ///< with an object in their light volume: pairs are tested
    std::size_t shadow_rays = 0;
    /// W that no receiver gets of beams of which only some rays meet its plane from the front.
    double parted = 0;

    void add(const QueryCounts& other);
    void report(FrameStats& stats) const;
};

/// One beam sheet, ready to be asked for the irradiance of receivers: the sum over beams of flux times the
/// share of the landed beam that lies within the footprint, over the footprint's area. Exact up to the mesh
/// and the tangent plane; no sampling, so the same in every frame that shows the same.
template <class Real>
class SheetCoverage {
public:
    /// `deepest`: m along the sheet's axis, no receiver lies beyond. All references outlive this.
    SheetCoverage(const scene::FrameScene& scene, const rays::RayScene& rays, light::BeamSheet<Real> sheet,
                  Real deepest);

    const light::BeamSheet<Real>& sheet() const { return sheet_; }
    const BeamPyramid<Real>& pyramid() const { return *pyramid_; }
    std::span<const glm::uvec3> triangles() const { return scene_.water->mesh.triangles; }
    /// /m, of the water, which is everywhere the same; 0 in the air.
    glm::dvec3 extinction() const { return extinction_; }
    /// Of the bounded media.
    const RayColumns<Real>& columns() const { return columns_; }
    const scene::FrameScene& scene() const { return scene_; }
    const rays::RayScene& rays() const { return rays_; }
    const Occluders& occluders() const { return occluders_; }
    /// m, relative to FrameScene::origin, of a light that is no sun.
    glm::dvec3 lamp() const {
        return scene_.state.lights[static_cast<std::size_t>(sheet_.light)].position - scene_.origin;
    }
    /// rad, of the part of the sun's disc that the sheet stands for; 0: none.
    double disc_radius() const;
    /// Unit, towards a point of that part, in the unit disc whose axes' images are the sheet's disc_u and
    /// disc_v; 0: the light is no sun.
    glm::dvec3 to_sun(glm::dvec2 disc) const;

    /// Adds this sheet's irradiance [W/m^2] of up to kTileReceivers receivers near each other on one object,
    /// in world axes relative to FrameScene::origin. Thread-safe. `hidden`, if given, becomes 1 where an
    /// object keeps some of the light from a receiver.
    void add(std::span<const Receiver<Real>> receivers, std::uint32_t object,
             std::span<Vec3<Real>> irradiance, QueryCounts& counts,
             std::span<std::uint8_t> hidden = {}) const;

    /// How far a plane leans, m of depth a m across the axis, as rays see it that land within a beam: large
    /// where they run along it. `normal` is in the sheet's axes.
    Real lean(const Vec3<Real>& normal) const {
        const Real facing =
            std::abs(normal.z) - std::abs(normal.x) * steepest_a_ - std::abs(normal.y) * steepest_b_;
        return std::sqrt(normal.x * normal.x + normal.y * normal.y) / std::max(Real(0.01), facing);
    }
    /// Whether the sheet stands for a part of the sun's disc that widens footprints.
    bool blurs() const { return sheet_.disc_u != glm::dvec2(0) && sheet_.disc_v != glm::dvec2(0); }
    /// m along the axis from the rest plane of the water to a point (world axes, relative to
    /// FrameScene::origin).
    Real way(const Vec3<Real>& point) const {
        return (point.y + static_cast<Real>(scene_.origin.y)) /
               static_cast<Real>(sheet_.world_from_mesh[2].y);
    }
    /// The receiver in the sheet's axes.
    Receiver<Real> rotated(const Receiver<Real>& world) const;
    /// The same, its footprint widened by the sheet's part of the sun's disc.
    Receiver<Real> in_sheet(const Receiver<Real>& world) const;

private:
    template <class>
    friend class Tile;

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    light::BeamSheet<Real> sheet_;
    glm::mat<3, 3, Real> sheet_from_world_;
    std::unique_ptr<BeamPyramid<Real>> pyramid_;
    Occluders occluders_;
    Real steepest_a_ = 0, steepest_b_ = 0;  ///< largest slopes
    glm::dvec3 extinction_{0, 0, 0};
    RayColumns<Real> columns_;
};

extern template class SheetCoverage<float>;
extern template class SheetCoverage<double>;

}  // namespace dapple::methods::sliced_beams
