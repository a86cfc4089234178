#pragma once
#include <glm/glm.hpp>
#include <optional>
#include <span>

#include "methods/reference/true_surface.h"
#include "rays/ray_scene.h"
#include "view/surface_point.h"

namespace dapple::reference {

/// A few roundings of a float position, m.
double rounding_of(const glm::dvec3& position);

/// Water nearer than this to a face of glass is that face, m: no film of water lies on it.
double face_margin(const glm::dvec3& position);

/// `direction` as it is, float; `near` and `far` in its lengths.
rays::Ray float_ray(const glm::dvec3& origin, const glm::dvec3& direction, double near, float far);

/// Where a ray meets the water.
struct WaterCrossing {
    double distance = 0;  ///< m along the ray
    glm::dvec3 position{0};
    glm::dvec3 geometric_normal{0}, shading_normal{0};  ///< unit, to the air
};

/// The true surface, and rays that meet it: Embree finds the triangle of a finer mesh than the frame's, and
/// the point is then moved to the surface itself. Positions are m, relative to the frame's origin.
class WaterRays {
public:
    explicit WaterRays(const scene::FrameScene& scene);

    bool exists() const { return surface_.has_value(); }
    /// Where there is water.
    const TrueSurface& surface() const { return *surface_; }
    /// Builds the mesh and its tree; without, nothing meets the water.
    void build();
    bool built() const { return rays_.has_value(); }
    /// Whether a point that is not in an object lies in the water: below the surface, and outside the
    /// rectangle below the rest plane of open water. Needs build() where the surface is no height field.
    bool in_water(const glm::dvec3& position) const;
    /// Whether a point is over or below open water outside the rectangle.
    bool beyond_rectangle(const glm::dvec3& position) const;
    const scene::TriangleMesh& mesh() const { return fine_scene_->water->mesh; }

    /// Whether a ray from a point of the surface may come back to it, from the bound of the slope.
    bool may_return(const glm::dvec3& direction) const;
    /// Along a ray from a point of the true surface, the way after which it is clear of the triangles about
    /// it, m.
    double clear_of_water(const glm::dvec3& position, const glm::dvec3& direction,
                          const glm::dvec3& normal) const;
    void intersect(std::span<const rays::Ray> rays, std::span<rays::Hit> hits) const {
        rays_->intersect_water(rays, hits);
    }
    /// For height fields by Newton's method along the ray, whose direction is unit.
    WaterCrossing crossing(const glm::dvec3& origin, const glm::dvec3& direction, const rays::Hit& hit) const;

private:
    bool over_rectangle(const glm::dvec3& world) const;

    const scene::FrameScene& scene_;
    std::optional<TrueSurface> surface_;  ///< none where there is no water
    std::optional<scene::FrameScene> fine_scene_;
    std::optional<rays::RayScene> rays_;
    std::optional<view::SurfaceGeometry> geometry_;
    double chord_error_ = 0;  ///< m, of the mesh
};

}  // namespace dapple::reference
