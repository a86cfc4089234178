#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/glass_bodies.h"
#include "view/surface_point.h"

namespace dapple::reference {

/// A rectangle on a plane.
struct Rectangle {
    glm::dvec2 low{0}, high{0};
    glm::dvec2 size() const { return high - low; }
};

/// The objects of glass. Spheres (and ellipsoids) are met in double, by the roots themselves, since a focus
/// lies where their exact normals send it; boxes and meshes as view/ places them, meshes with the
/// interpolated normals of their vertices where the file gives any. Positions are m, relative to the frame's
/// origin.
class GlassBodies {
public:
    /// `scene` outlives it.
    explicit GlassBodies(const scene::FrameScene& scene);

    bool any() const { return any_; }
    bool is_glass(std::uint32_t object) const { return scene_.state.objects[object].material.glass; }
    double index(std::uint32_t object) const {
        return scene_.state.objects[object].material.refractive_index;
    }
    /// Whether a point of the water's surface, with its unit normal, lies in a body or on a face of one,
    /// where there is no surface of the water.
    bool replace_water(const glm::dvec3& position, const glm::dvec3& normal) const;
    /// What is left of light after a way inside.
    glm::dvec3 through(std::uint32_t object, double distance) const;

    /// Where a ray (unit direction) that hit a body meets it; `inside`: it comes from inside the body.
    view::SurfacePoint point(const rays::Hit& hit, const glm::dvec3& origin, const glm::dvec3& direction,
                             bool inside) const;

    glm::dvec3 middle(std::uint32_t object) const { return outlines_[object].middle; }
    /// Of a ball about the middle that holds the body, m.
    double radius(std::uint32_t object) const { return outlines_[object].radius; }
    /// Bounds of dot(position - from, u) and dot(position - from, v).
    Rectangle across(std::uint32_t object, const glm::dvec3& from, const glm::dvec3& u,
                     const glm::dvec3& v) const;
    /// Bounds of the same over dot(position - from, w), for a body that lies wholly before `from` along w.
    Rectangle in_perspective(std::uint32_t object, const glm::dvec3& from, const glm::dvec3& u,
                             const glm::dvec3& v, const glm::dvec3& w) const;

private:
    /// Of an ellipsoid its matrix, of others their corners.
    struct Outline {
        bool sphere = false;
        glm::dvec3 middle{0};
        glm::dmat3 offset_from_unit{1.0}, unit_from_offset{1.0};
        std::vector<glm::dvec3> corners;
        double radius = 0;
    };

    const scene::FrameScene& scene_;
    view::SurfaceGeometry geometry_;
    view::GlassBodies bodies_;
    std::vector<Outline> outlines_;  ///< an object; empty for those that are not of glass
    bool any_ = false;
};

}  // namespace dapple::reference
