#include "view/surface_point.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rays/shape_mesh.h"
#include "scene/transform.h"

namespace dapple::view {
namespace {

/// Corners of a triangle and the gradients of the weights of the second and third.
struct Triangle {
    std::array<glm::dvec3, 3> corner;
    glm::dvec3 normal;  ///< not normalised
    glm::dvec3 u_gradient;
    glm::dvec3 v_gradient;

    Triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) : corner{a, b, c} {
        const glm::dvec3 ab = b - a;
        const glm::dvec3 ac = c - a;
        normal = cross(ab, ac);
        const double inverse = 1 / dot(normal, normal);
        u_gradient = inverse * cross(ac, normal);
        v_gradient = inverse * cross(normal, ab);
    }
    glm::dvec2 weights(const glm::dvec3& position) const {
        return {dot(u_gradient, position - corner[0]), dot(v_gradient, position - corner[0])};
    }
};

/// Where the ray meets the triangle's plane; the tracer's own distance where triangles so thin that float and
/// double disagree about their plane make it useless.
void place_on_triangle(const Triangle& triangle, const rays::Hit& hit, const glm::dvec3& origin,
                       const glm::dvec3& direction, SurfacePoint& point) {
    const auto traced = static_cast<double>(hit.distance);
    const double distance =
        dot(triangle.corner[0] - origin, triangle.normal) / dot(direction, triangle.normal);
    const bool agrees = std::abs(distance - traced) <= 0.01 * traced + 1e-4;
    point.distance = agrees ? distance : traced;
    point.position = origin + point.distance * direction;
    point.geometric_normal = normalize(triangle.normal);
}

/// Interpolated normal of the point and its derivative.
void interpolate_normal(const Triangle& triangle, const std::array<glm::dvec3, 3>& normals,
                        SurfacePoint& point) {
    const glm::dvec2 weight = triangle.weights(point.position);
    const glm::dvec3 along_u = normals[1] - normals[0];
    const glm::dvec3 along_v = normals[2] - normals[0];
    const glm::dvec3 sum = normals[0] + weight.x * along_u + weight.y * along_v;
    const double size = length(sum);
    if (!(size > 1e-6)) {
        point.shading_normal = point.geometric_normal;
        return;
    }
    point.shading_normal = sum / size;
    const glm::dmat3 change =
        outerProduct(along_u, triangle.u_gradient) + outerProduct(along_v, triangle.v_gradient);
    const glm::dmat3 across = glm::dmat3(1) - outerProduct(point.shading_normal, point.shading_normal);
    point.shading_normal_change = (1 / size) * (across * change);
}

constexpr std::array<std::array<int, 2>, 3> kFaceAxes{{{2, 1}, {0, 2}, {0, 1}}};  // u and v of faces x, y, z

}  // namespace

SurfaceGeometry::SurfaceGeometry(const scene::FrameScene& scene) : scene_(scene) {
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) {
        const scene::Object& object = scene.state.objects[i];
        PlacedObject placed;
        placed.relative_from_object = scene::relative_from_object(object.transform, scene.origin);
        if (object.shape == scene::Shape::sphere) {
            placed.relative_from_object =
                glm::scale(placed.relative_from_object, glm::dvec3(object.radius));  // from the unit sphere
        } else if (object.shape == scene::Shape::mesh) {
            if (i < scene.object_meshes.size()) placed.mesh = scene.object_meshes[i];
        } else {
            placed.mesh = std::make_shared<scene::TriangleMesh>(object.shape == scene::Shape::plane
                                                                    ? rays::plane_mesh(object.size)
                                                                    : rays::box_mesh(object.size));
        }
        const glm::dmat3 linear(placed.relative_from_object);
        placed.object_from_relative = inverse(placed.relative_from_object);
        placed.normal_from_object = inverse(transpose(linear));
        placed.side = determinant(linear) < 0 ? -1 : 1;
        objects_.push_back(std::move(placed));
    }
}

SurfacePoint SurfaceGeometry::object_point(const rays::Hit& hit, const glm::dvec3& origin,
                                           const glm::dvec3& direction) const {
    const PlacedObject& object = objects_[hit.object];
    SurfacePoint point;
    if (!object.mesh) {  // a sphere: one step of Newton's method from the float distance
        const glm::dvec3 d = glm::dmat3(object.object_from_relative) * direction;
        const glm::dvec3 o(object.object_from_relative * glm::dvec4(origin, 1));
        point.distance = static_cast<double>(hit.distance);
        const glm::dvec3 q = o + point.distance * d;
        const double slope = 2 * dot(q, d);
        if (std::abs(slope) > 1e-2 * length(d)) point.distance -= (dot(q, q) - 1) / slope;
        point.position = origin + point.distance * direction;
        const glm::dvec3 gradient = object.normal_from_object * (o + point.distance * d);
        const double size = length(gradient);
        point.geometric_normal = point.shading_normal = gradient / size;
        const glm::dmat3 across = glm::dmat3(1) - outerProduct(point.shading_normal, point.shading_normal);
        const glm::dmat3 change = object.normal_from_object * glm::dmat3(object.object_from_relative);
        point.shading_normal_change = (1 / size) * (across * change);
        return point;
    }
    const scene::TriangleMesh& mesh = *object.mesh;
    const glm::uvec3 corners = mesh.triangles[hit.primitive];
    const auto placed = [&](glm::uint vertex) {
        return glm::dvec3(object.relative_from_object * glm::dvec4(mesh.positions[vertex], 1));
    };
    const Triangle triangle(placed(corners.x), placed(corners.y), placed(corners.z));
    place_on_triangle(triangle, hit, origin, direction, point);
    point.geometric_normal *= object.side;
    if (mesh.normals.empty()) {
        point.shading_normal = point.geometric_normal;
    } else {
        const auto turned = [&](glm::uint vertex) {
            return normalize(object.normal_from_object * mesh.normals[vertex]);
        };
        interpolate_normal(triangle, {turned(corners.x), turned(corners.y), turned(corners.z)}, point);
    }
    return point;
}

SurfacePoint SurfaceGeometry::water_point(const rays::Hit& hit, const glm::dvec3& origin,
                                          const glm::dvec3& direction) const {
    const scene::TriangleMesh& mesh = scene_.water->mesh;
    const glm::uvec3 corners = mesh.triangles[hit.primitive];
    const glm::dvec3& shift = scene_.origin;
    const Triangle triangle(mesh.positions[corners.x] - shift, mesh.positions[corners.y] - shift,
                            mesh.positions[corners.z] - shift);
    SurfacePoint point;
    place_on_triangle(triangle, hit, origin, direction, point);
    interpolate_normal(triangle, {mesh.normals[corners.x], mesh.normals[corners.y], mesh.normals[corners.z]},
                       point);
    return point;
}

TexturePoint SurfaceGeometry::texture_point(const rays::Hit& hit, const SurfacePoint& point) const {
    const scene::Object& description = scene_.state.objects[hit.object];
    const PlacedObject& object = objects_[hit.object];
    const glm::dvec3 local(object.object_from_relative * glm::dvec4(point.position, 1));
    const glm::dmat3 rows = transpose(glm::dmat3(object.object_from_relative));  // gradients of local x, y, z
    TexturePoint texture;
    switch (description.shape) {
        case scene::Shape::plane:
        case scene::Shape::box: {
            const bool is_box = description.shape == scene::Shape::box;
            const auto [u, v] = kFaceAxes[is_box ? hit.primitive / 4 : 1];
            const glm::dvec3 repeats =
                glm::abs(description.transform.scale) / description.material.texture_size;
            texture.uv = {repeats[u] * local[u], repeats[v] * local[v]};
            texture.u_gradient = repeats[u] * rows[u];
            texture.v_gradient = repeats[v] * rows[v];
            break;
        }
        case scene::Shape::sphere: {
            const double repeats = description.radius * std::abs(description.transform.scale.x) /
                                   description.material.texture_size;
            // The longitude turns without bound at the poles: there its gradient is held at that of 1e-3
            // away.
            const double across = std::max(local.x * local.x + local.z * local.z, 1e-6);
            texture.uv = {repeats * std::atan2(local.z, local.x),
                          repeats * std::asin(std::clamp(local.y, -1.0, 1.0))};
            texture.u_gradient = (repeats / across) * (local.x * rows[2] - local.z * rows[0]);
            texture.v_gradient = (repeats / std::sqrt(across)) * rows[1];
            break;
        }
        case scene::Shape::mesh: {
            const scene::TriangleMesh& mesh = *object.mesh;
            if (mesh.uv.empty()) break;
            const glm::uvec3 corners = mesh.triangles[hit.primitive];
            const Triangle triangle(mesh.positions[corners.x], mesh.positions[corners.y],
                                    mesh.positions[corners.z]);
            const glm::dvec2 weight = triangle.weights(local);
            const glm::dvec2 along_u = mesh.uv[corners.y] - mesh.uv[corners.x];
            const glm::dvec2 along_v = mesh.uv[corners.z] - mesh.uv[corners.x];
            texture.uv = mesh.uv[corners.x] + weight.x * along_u + weight.y * along_v;
            const glm::dvec3 weight_x = rows * triangle.u_gradient;
            const glm::dvec3 weight_y = rows * triangle.v_gradient;
            texture.u_gradient = along_u.x * weight_x + along_v.x * weight_y;
            texture.v_gradient = along_u.y * weight_x + along_v.y * weight_y;
            break;
        }
    }
    return texture;
}

}  // namespace dapple::view
