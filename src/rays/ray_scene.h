#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "base/lanes.h"
#include "scene/frame_scene.h"

namespace dapple::rays {

/// A ray in float, relative to FrameScene::origin. `direction` need not be unit: distances are in its
/// lengths.
struct Ray {
    glm::vec3 origin;
    float near = 0;
    glm::vec3 direction;
    float far = std::numeric_limits<float>::infinity();
};

/// Of the library in use: "3.13.5".
std::string embree_version();

constexpr std::uint32_t kNoHit = 0xffffffffu;

struct Hit {
    float distance = std::numeric_limits<float>::infinity();  ///< in lengths of the ray's direction
    std::uint32_t object = kNoHit;     ///< index into FrameState::objects; 0 for the water
    std::uint32_t primitive = kNoHit;  ///< triangle of the mesh; kNoHit where nothing was hit
    glm::vec2 barycentric{0, 0};
    glm::vec3 normal{0, 1, 0};  ///< geometric, not normalised, outward
};

struct RayLanes;
struct HitLanes;

/// Embree's view of one frame: the objects and the water, apart. The only user of Embree; fixed instruction
/// set (avx2), robust traversal. Thread-safe once built. Rays with a component that is not finite (but for an
/// infinite `far`), without a direction or with near > far hit nothing.
///
/// Primitives: planes and boxes are the triangles of rays/shape_mesh.h, meshes those of the file, a sphere is
/// primitive 0 with barycentric (0, 0), the water those of WaterMesh. barycentric = (u, v) means the point
/// (1 - u - v) v0 + u v1 + v v2.
class RayScene {
public:
    /// Throws Error(failure) where Embree cannot build it (out of memory, no AVX2). Shapes that a scale of 0
    /// or a vertex that is not finite makes meaningless are left out.
    explicit RayScene(const scene::FrameScene& scene);
    ~RayScene();
    RayScene(RayScene&&) noexcept;
    RayScene& operator=(RayScene&&) noexcept;

    /// Nearest hits of a few hundred to thousands of coherent rays, in packets; called from within
    /// parallel_for.
    void intersect_objects(std::span<const Ray> rays, std::span<Hit> hits) const;
    void intersect_water(std::span<const Ray> rays, std::span<Hit> hits) const;
    /// 1 where an object lies between `near` and `far`.
    void occluded_by_objects(std::span<const Ray> rays, std::span<std::uint8_t> occluded) const;
    // The same of eight that are lanes already (rays/ray_lanes.h).
    void intersect_objects(const RayLanes& rays, HitLanes& hits) const;
    lanes::Mask<float> occluded_by_objects(const RayLanes& rays) const;

    bool has_objects() const;
    /// Bounds of the objects, m, relative to the origin; empty scene: lower > upper.
    void object_bounds(glm::vec3& lower, glm::vec3& upper) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::rays
