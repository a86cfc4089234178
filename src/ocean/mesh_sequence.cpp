#include "ocean/mesh_sequence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/number_pattern.h"
#include "input/mesh_file.h"

namespace dapple::ocean {
namespace {

/// Step between neighbouring floats at the largest coordinate, unit of the file; 0 where some coordinate is
/// no float, so that the file holds more digits.
double float_step(const scene::TriangleMesh& mesh) {
    float largest = 0;
    for (const glm::dvec3& p : mesh.positions) {
        if (glm::dvec3(glm::vec3(p)) != p) return 0;
        largest = std::max({largest, std::abs(static_cast<float>(p.x)), std::abs(static_cast<float>(p.y)),
                            std::abs(static_cast<float>(p.z))});
    }
    return static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest);
}

/// m, side of the squares that pairs of the triangles would be.
double mean_edge(const scene::TriangleMesh& mesh) {
    double area = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3& a = mesh.positions[t.x];
        area += 0.5 * glm::length(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a));
    }
    return mesh.triangles.empty() ? 0 : std::sqrt(2 * area / static_cast<double>(mesh.triangles.size()));
}

std::string existing_file(const scene::MeshSequence& sequence, std::int64_t number) {
    const auto name = [&](std::int64_t n) { return scene::file_path(sequence, n); };
    if (sequence.missing == scene::MissingFrames::error) return name(number);
    return held_file(number, sequence.first_file, name);
}

}  // namespace

bool orient_upwards(scene::TriangleMesh& mesh) {
    mesh.normals.assign(mesh.positions.size(), glm::dvec3(0));
    double upward = 0;
    double area = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3& a = mesh.positions[t.x];
        const glm::dvec3 twice_area = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
        for (const std::uint32_t v : {t.x, t.y, t.z}) mesh.normals[v] += twice_area;
        upward += twice_area.y;
        area += glm::length(twice_area);
    }
    if (!(std::abs(upward) > 1e-6 * area)) return false;
    const double sign = upward > 0 ? 1 : -1;
    if (sign < 0) {
        for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
    }
    for (glm::dvec3& normal : mesh.normals) {
        const double length = glm::length(normal);
        // A vertex of no triangle, or of triangles without area.
        normal = length > 0 ? normal * (sign / length) : glm::dvec3(0, 1, 0);
    }
    return true;
}

scene::WaterMesh sequence_mesh(const scene::MeshSequence& sequence, double time) {
    if (find_number(sequence.pattern).length == 0) {
        throw Error(ExitCode::timeline_invalid,
                    clipped(sequence.pattern) + ": write the number of the file once, as %04d or ####");
    }
    const std::string path = existing_file(sequence, scene::file_number(sequence, time));
    scene::WaterMesh water;
    water.mesh = input::read_mesh(path);
    water.mesh.uv.clear();
    water.float_step = sequence.scale * float_step(water.mesh);
    for (glm::dvec3& p : water.mesh.positions) {
        if (sequence.up == scene::UpAxis::z) p = {p.x, p.z, -p.y};
        p = sequence.scale * p + sequence.offset;
        water.largest_height = std::max(water.largest_height, std::abs(p.y));
    }
    water.mean_edge = mean_edge(water.mesh);
    if (!orient_upwards(water.mesh)) {
        throw Error(
            ExitCode::input_unreadable,
            clipped(path) + ": the mesh faces neither up nor down; a water surface is one open sheet");
    }
    for (const glm::dvec3& normal : water.mesh.normals) water.folded_vertices += normal.y > 0 ? 0 : 1;
    // Known of this file only. Its displacement is part of the positions: there is no grid that it is off.
    water.height_bound = water.largest_height;
    return water;
}

}  // namespace dapple::ocean
