#pragma once
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace dapple::scene {

/// world = translation * rotation(y, then x, then z; degrees in the file) * scale, applied to the shape at
/// the origin.
struct Transform {
    glm::dvec3 position{0, 0, 0};
    glm::dvec3 rotation{0, 0,
                        0};  ///< rad about x, y, z; applied in the order y * x * z (heading, pitch, roll)
    glm::dvec3 scale{1, 1, 1};
};

/// translation * rotation(y) * rotation(x) * rotation(z) * scale; rotations are right-handed.
inline glm::dmat4 world_from_object(const Transform& transform) {
    glm::dmat4 matrix = glm::translate(glm::dmat4(1), transform.position);
    matrix = glm::rotate(matrix, transform.rotation.y, glm::dvec3(0, 1, 0));
    matrix = glm::rotate(matrix, transform.rotation.x, glm::dvec3(1, 0, 0));
    matrix = glm::rotate(matrix, transform.rotation.z, glm::dvec3(0, 0, 1));
    return glm::scale(matrix, transform.scale);
}

/// The same into positions relative to `origin` (FrameScene::origin), rounded nowhere but in double.
inline glm::dmat4 relative_from_object(const Transform& transform, const glm::dvec3& origin) {
    Transform moved = transform;
    moved.position -= origin;
    return world_from_object(moved);
}

}  // namespace dapple::scene
