#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::view {

/// The surface about a hit, in double; positions relative to FrameScene::origin.
struct SurfacePoint {
    double distance = 0;                    ///< m, along the ray's unit direction
    glm::dvec3 position{0, 0, 0};           ///< m, on the ray and on the surface
    glm::dvec3 geometric_normal{0, 1, 0};   ///< unit, outward (water: to the air)
    glm::dvec3 shading_normal{0, 1, 0};     ///< unit, outward; interpolated where vertices have normals
    glm::dmat3 shading_normal_change{0.0};  ///< d(shading normal)/d(position) along the tangent plane, /m
};

struct TexturePoint {
    glm::dvec2 uv{0, 0};
    glm::dvec3 u_gradient{0, 0, 0};  ///< d(u)/d(position) along the tangent plane, /m
    glm::dvec3 v_gradient{0, 0, 0};
};

/// Places what a RayScene hit back on the exact geometry of the frame. Thread-safe.
class SurfaceGeometry {
public:
    explicit SurfaceGeometry(const scene::FrameScene& scene);

    /// `direction` is unit; the hit's distance only says which crossing is meant, the exact one is found
    /// anew.
    SurfacePoint object_point(const rays::Hit& hit, const glm::dvec3& origin,
                              const glm::dvec3& direction) const;
    SurfacePoint water_point(const rays::Hit& hit, const glm::dvec3& origin,
                             const glm::dvec3& direction) const;

    /// Texture coordinates, where `point` is that of the same hit. Planes and boxes: metres along the face
    /// from its middle over Material::texture_size (+-x faces: z, y; +-y: x, z; +-z: x, y). Spheres: metres
    /// along the equator (from +x towards +z) and up the meridian, over the same. Meshes: their own; without,
    /// 0.
    TexturePoint texture_point(const rays::Hit& hit, const SurfacePoint& point) const;

private:
    struct PlacedObject {
        glm::dmat4 relative_from_object{1.0};
        glm::dmat4 object_from_relative{1.0};
        glm::dmat3 normal_from_object{1.0};
        double side = 1;  ///< -1 where the transform turns triangles inside out
        std::shared_ptr<const scene::TriangleMesh> mesh;  ///< null: a sphere
    };
    const scene::FrameScene& scene_;
    std::vector<PlacedObject> objects_;
};

}  // namespace dapple::view
