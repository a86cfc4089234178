#pragma once
#include <cmath>
#include <functional>
#include <memory>

#include "scene/mesh.h"

namespace dapple::test {

using HeightFunction = std::function<double(double x, double z)>;

/// A square grid of cells * cells over [-size / 2, size / 2]^2 with heights and normals of a function;
/// `slope` gives (dh/dx, dh/dz). `other_diagonal` splits the cells the other way.
inline std::shared_ptr<scene::WaterMesh> grid_water(int cells, double size, const HeightFunction& height,
                                                    const std::function<glm::dvec2(double, double)>& slope,
                                                    bool other_diagonal = false) {
    auto water = std::make_shared<scene::WaterMesh>();
    const int side = cells + 1;
    water->rows = side;
    water->columns = side;
    for (int row = 0; row < side; ++row) {
        for (int column = 0; column < side; ++column) {
            const double x = size * (static_cast<double>(column) / cells - 0.5);
            const double z = size * (static_cast<double>(row) / cells - 0.5);
            water->mesh.positions.emplace_back(x, height(x, z), z);
            water->height_bound = std::max(water->height_bound, std::abs(height(x, z)));
            const glm::dvec2 dh = slope(x, z);
            water->mesh.normals.push_back(glm::normalize(glm::dvec3(-dh.x, 1, -dh.y)));
        }
    }
    for (int row = 0; row < cells; ++row) {
        for (int column = 0; column < cells; ++column) {
            const auto a = static_cast<glm::uint>(row * side + column);
            const auto b = a + static_cast<glm::uint>(side);
            if (other_diagonal) {
                water->mesh.triangles.emplace_back(a, b, b + 1);
                water->mesh.triangles.emplace_back(a, b + 1, a + 1);
            } else {
                water->mesh.triangles.emplace_back(a, b, a + 1);
                water->mesh.triangles.emplace_back(a + 1, b, b + 1);
            }
        }
    }
    return water;
}

inline std::shared_ptr<scene::WaterMesh> flat_water(double size, int cells = 4, double level = 0) {
    return grid_water(
        cells, size, [level](double, double) { return level; }, [](double, double) { return glm::dvec2(0); });
}

/// Two crossed sinusoids, steep enough to matter: slopes up to 0.35.
inline std::shared_ptr<scene::WaterMesh> wavy_water(double size, int cells, bool other_diagonal = false) {
    return grid_water(
        cells, size, [](double x, double z) { return 0.05 * std::sin(3 * x) * std::cos(4 * z); },
        [](double x, double z) {
            return glm::dvec2(0.15 * std::cos(3 * x) * std::cos(4 * z),
                              -0.2 * std::sin(3 * x) * std::sin(4 * z));
        },
        other_diagonal);
}

}  // namespace dapple::test
