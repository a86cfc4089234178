#pragma once
#include <cmath>
#include <memory>
#include <vector>

#include "light/beam_mesh.h"
#include "ocean/water_surface.h"
#include "scene/frame_scene.h"
#include "spiral_sea.h"

/// What grids of beams are compared on: the sun over a pool of 6 m by 6 m, 2 m deep, of murky water, whose
/// floor is seen by an eye in the water.
namespace dapple::bench {

/// A sphere of 0.5 m, 512 by 256, with dents of `depth` of its radius.
inline scene::TriangleMesh dented_ball(double depth) {
    constexpr int kColumns = 512, kRows = 256;
    constexpr double kPi = 3.141592653589793;
    scene::TriangleMesh mesh;
    const auto point = [&](double u, double v) {
        const double a = 2 * kPi * u, b = kPi * v;
        const double radius =
            0.5 * (1 + depth * std::cos(64 * a) * std::cos(64 * b) * std::pow(std::sin(b), 2));
        return radius * glm::dvec3(std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a));
    };
    for (int row = 0; row <= kRows; ++row)
        for (int column = 0; column <= kColumns; ++column) {
            const double u = static_cast<double>(column) / kColumns, v = static_cast<double>(row) / kRows;
            mesh.positions.push_back(point(u, v));
            const double step = 1e-5;
            const glm::dvec3 normal =
                glm::cross(point(u, v + step) - point(u, v - step), point(u + step, v) - point(u - step, v));
            const glm::dvec3 out = row == 0 || row == kRows ? mesh.positions.back() : normal;
            mesh.normals.push_back(glm::normalize(glm::dot(out, mesh.positions.back()) < 0 ? -out : out));
        }
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            const auto at = [&](int r, int c) { return static_cast<unsigned>(r * (kColumns + 1) + c); };
            if (row > 0)
                mesh.triangles.emplace_back(at(row, column), at(row, column + 1), at(row + 1, column));
            if (row < kRows - 1)
                mesh.triangles.emplace_back(at(row, column + 1), at(row + 1, column + 1),
                                            at(row + 1, column));
        }
    return mesh;
}

constexpr std::array<const char*, 3> kGridScenes = {"waves", "a ball of glass over flat water",
                                                    "a ball of glass with 2000 dents over flat water"};

/// One of kGridScenes, and the chains that are followed in it.
struct GridScene {
    std::unique_ptr<scene::FrameScene> frame = std::make_unique<scene::FrameScene>();
    std::vector<light::Chain> chains;
};

inline GridScene grid_scene(int number) {
    GridScene made;
    scene::FrameScene& frame = *made.frame;
    scene::FrameState& state = frame.state;
    scene::Light sun;
    sun.direction = glm::normalize(glm::dvec3(0.4, -0.9, 0.1));
    sun.irradiance = {1, 1, 1};
    sun.angular_diameter = 0;
    state.lights.push_back(sun);
    scene::Object floor;
    floor.size = {40, 1, 40};
    floor.transform.position = {0, -2, 0};
    state.objects.push_back(floor);
    scene::Water& water = state.water.emplace();
    water.extent.size = {6, 6};
    water.mesh_cells = number == 0 ? 768 : 64;
    water.absorption = {0.3, 0.06, 0.03};
    water.scattering = {0.1, 0.1, 0.1};
    water.phase.type = scene::PhaseType::henyey_greenstein;
    water.phase.anisotropy = 0.6;
    if (number == 0) add_waves(water, 0.3, 1.5, 0.0032);
    frame.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    state.camera.position = {-1.2, -0.5, 2.6};
    state.camera.target = {0.6, -1.6, 0};
    state.camera.field_of_view = 45 * scene::kDegree;
    frame.object_meshes = {nullptr};
    using light::Event;
    if (number == 0) {
        made.chains = {{0, Event::transmission}};
        return made;
    }
    scene::Object ball;
    ball.material.glass = true;
    ball.transform.position = {0, 0.6, 0};
    ball.shape = number == 1 ? scene::Shape::sphere : scene::Shape::mesh;
    state.objects.push_back(ball);
    frame.object_meshes.push_back(number == 1 ? nullptr
                                              : std::make_shared<scene::TriangleMesh>(dented_ball(0.01)));
    made.chains = {{0, Event::transmission, 1}};
    return made;
}

}  // namespace dapple::bench
