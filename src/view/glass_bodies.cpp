#include "view/glass_bodies.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "scene/transform.h"

namespace dapple::view {
namespace {

/// sr, positive for a triangle whose back is seen from `point`.
double solid_angle(const glm::dvec3& point, const glm::dvec3& corner_a, const glm::dvec3& corner_b,
                   const glm::dvec3& corner_c) {
    const glm::dvec3 a = corner_a - point, b = corner_b - point, c = corner_c - point;
    const double size_a = length(a), size_b = length(b), size_c = length(c);
    const double below =
        size_a * size_b * size_c + dot(a, b) * size_c + dot(b, c) * size_a + dot(c, a) * size_b;
    return 2 * std::atan2(dot(a, cross(b, c)), below);
}

}  // namespace

GlassBodies::GlassBodies(const scene::FrameScene& scene) {
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) {
        const scene::Object& object = scene.state.objects[i];
        if (!object.material.glass) continue;
        Body body{static_cast<std::uint32_t>(i),
                  object.shape,
                  inverse(scene::relative_from_object(object.transform, scene.origin)),
                  -0.5 * object.size,
                  0.5 * object.size,
                  nullptr};
        if (object.shape == scene::Shape::sphere) {
            body.lower = glm::dvec3(-object.radius);
            body.upper = glm::dvec3(object.radius);
        } else if (object.shape == scene::Shape::mesh) {
            if (i < scene.object_meshes.size()) body.mesh = scene.object_meshes[i];
            if (!body.mesh) continue;
            body.lower = glm::dvec3(std::numeric_limits<double>::infinity());
            body.upper = -body.lower;
            for (const glm::dvec3& position : body.mesh->positions) {
                body.lower = glm::min(body.lower, position);
                body.upper = glm::max(body.upper, position);
            }
        }
        bodies_.push_back(std::move(body));
    }
}

std::uint32_t GlassBodies::at(const glm::dvec3& point) const {
    for (const Body& body : bodies_) {
        if (holds(body, glm::dvec3(body.object_from_relative * glm::dvec4(point, 1)))) return body.object;
    }
    return kNoBody;
}

bool GlassBodies::holds(const Body& body, const glm::dvec3& local) {
    if (glm::any(glm::lessThan(local, body.lower)) || glm::any(glm::greaterThan(local, body.upper)))
        return false;
    if (body.shape == scene::Shape::sphere) return length(local) < body.upper.x;
    if (!body.mesh) return true;
    double sum = 0;  // 4 pi inside, 0 outside
    for (const glm::uvec3& corner : body.mesh->triangles) {
        const auto& positions = body.mesh->positions;
        sum += solid_angle(local, positions[corner.x], positions[corner.y], positions[corner.z]);
    }
    return sum > glm::two_pi<double>();
}

}  // namespace dapple::view
