#include "methods/reference/receiver_charts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "rays/shape_mesh.h"
#include "scene/transform.h"

namespace dapple::reference {
namespace {

/// The lower 32 bits at the even places.
std::uint64_t spread(std::uint64_t bits) {
    bits = (bits | bits << 16) & 0x0000ffff0000ffff;
    bits = (bits | bits << 8) & 0x00ff00ff00ff00ff;
    bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0f;
    bits = (bits | bits << 2) & 0x3333333333333333;
    return (bits | bits << 1) & 0x5555555555555555;
}

/// Digits of a point of the unit square.
std::uint64_t square_digits(double u, double v, int digits) {
    const double size = std::ldexp(1.0, digits);
    const auto whole = [&](double t) {
        return static_cast<std::uint64_t>(std::clamp(std::floor(t * size), 0.0, size - 1));
    };
    return spread(whole(u)) | spread(whole(v)) << 1;
}

/// Digits of a point of a triangle by the weights of its second and third corner: in each step the quarter at
/// a corner, or the middle one, which is turned around.
std::uint64_t triangle_digits(double u, double v, int digits) {
    std::uint64_t result = 0;
    for (int i = 0; i < digits; ++i) {
        u *= 2;
        v *= 2;
        std::uint64_t digit = 0;
        if (u >= 1) {
            digit = 1;
            u -= 1;
        } else if (v >= 1) {
            digit = 2;
            v -= 1;
        } else if (u + v > 1) {
            digit = 3;
            u = 1 - u;
            v = 1 - v;
        }
        result = result << 2 | digit;
    }
    return result;
}

}  // namespace

ReceiverCharts::ReceiverCharts(const scene::FrameScene& scene) {
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) {
        const scene::Object& object = scene.state.objects[i];
        const glm::dmat4 placed = scene::relative_from_object(object.transform, scene.origin);
        Placed result;
        result.first_chart = charts_;
        result.first_face = faces_.size();
        if (object.shape == scene::Shape::sphere) {
            const glm::dmat3 offset_from_unit = glm::dmat3(placed) * object.radius;
            result.sphere = true;
            result.center = glm::dvec3(placed[3]);
            result.stretch = std::abs(determinant(offset_from_unit));
            if (result.stretch > 0) result.unit_from_offset = inverse(offset_from_unit);
            charts_ += 2;
            objects_.push_back(result);
            continue;
        }
        const bool is_mesh = object.shape == scene::Shape::mesh;
        scene::TriangleMesh shape;
        if (object.shape == scene::Shape::plane) shape = rays::plane_mesh(object.size);
        if (object.shape == scene::Shape::box) shape = rays::box_mesh(object.size);
        const scene::TriangleMesh* mesh = &shape;
        if (is_mesh && i < scene.object_meshes.size() && scene.object_meshes[i])
            mesh = scene.object_meshes[i].get();
        result.triangles_a_face = is_mesh ? 1 : 2;
        const auto point = [&](glm::uint index) {
            return glm::dvec3(placed * glm::dvec4(mesh->positions[index], 1));
        };
        for (std::size_t t = 0; t < mesh->triangles.size(); t += result.triangles_a_face) {
            const glm::uvec3 first = mesh->triangles[t];
            // Rectangles come as (0, 1, 2), (0, 2, 3): their sides are 0 to 1 and 0 to 3.
            if (is_mesh)
                add_face(point(first.x), point(first.y), point(first.z), 0.5);
            else
                add_face(point(first.x), point(first.y), point(mesh->triangles[t + 1].z), 1);
        }
        charts_ += 2 * (faces_.size() - result.first_face);
        objects_.push_back(result);
    }
    const int chart_bits = static_cast<int>(std::bit_width(charts_));
    digits_ = std::min(30, (64 - chart_bits) / 2);
}

void ReceiverCharts::add_face(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double share) {
    Face face;
    face.corner = a;
    face.normal = cross(b - a, c - a);
    const double square = dot(face.normal, face.normal);
    if (square > 0 && std::isfinite(square)) {
        face.u = cross(c - a, face.normal) / square;
        face.v = cross(face.normal, b - a) / square;
        face.area = share * std::sqrt(square);
    }
    faces_.push_back(face);
}

std::uint64_t ReceiverCharts::key(std::size_t chart, std::uint64_t digits) const {
    return static_cast<std::uint64_t>(chart) << (2 * digits_) | digits;
}

ChartPlace ReceiverCharts::place(std::uint32_t object, std::uint32_t primitive, const glm::dvec3& position,
                                 const glm::dvec3& towards) const {
    const Placed& placed = objects_[object];
    if (placed.sphere) {
        if (!(placed.stretch > 0)) return {};
        const glm::dvec3 unit = normalize(placed.unit_from_offset * (position - placed.center));
        const glm::dvec3 normal = transpose(placed.unit_from_offset) * unit;
        const double u = std::atan2(unit.z, unit.x) / (2 * std::numbers::pi) + 0.5;
        const double v = 0.5 * unit.y + 0.5;
        const std::size_t side = dot(towards, normal) >= 0 ? 0 : 1;
        // A linear map stretches an area with normal n by |det| |inverse transposed n|.
        return {key(placed.first_chart + side, square_digits(u, v, digits_)),
                4 * std::numbers::pi * placed.stretch * length(normal)};
    }
    const std::size_t index = primitive / placed.triangles_a_face;
    const Face& face = faces_[placed.first_face + index];
    const glm::dvec3 offset = position - face.corner;
    const double u = dot(face.u, offset);
    const double v = dot(face.v, offset);
    const std::size_t side = dot(towards, face.normal) >= 0 ? 0 : 1;
    const std::uint64_t digits = placed.triangles_a_face == 1
                                     ? triangle_digits(std::max(u, 0.0), std::max(v, 0.0), digits_)
                                     : square_digits(u, v, digits_);
    return {key(placed.first_chart + 2 * index + side, digits), face.area};
}

}  // namespace dapple::reference
