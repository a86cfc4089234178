#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "scene/frame_scene.h"

namespace dapple::view {

constexpr std::uint32_t kNoBody = 0xffffffffu;

/// The bodies of glass of a frame: which of them a point lies in. Thread-safe.
class GlassBodies {
public:
    explicit GlassBodies(const scene::FrameScene& scene);

    bool any() const { return !bodies_.empty(); }
    /// Index into FrameState::objects, or kNoBody. `point` is relative to FrameScene::origin. Of a mesh by
    /// the solid angle of its triangles (Van Oosterom and Strackee 1983): costs all of them within its
    /// bounds.
    std::uint32_t at(const glm::dvec3& point) const;

private:
    struct Body {
        std::uint32_t object;
        scene::Shape shape;
        glm::dmat4 object_from_relative;
        glm::dvec3 lower, upper;  ///< m, in the object's space
        std::shared_ptr<const scene::TriangleMesh> mesh;
    };
    static bool holds(const Body& body, const glm::dvec3& local);

    std::vector<Body> bodies_;
};

}  // namespace dapple::view
