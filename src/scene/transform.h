#pragma once
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/frame_state.h"

namespace dapple::scene {

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
