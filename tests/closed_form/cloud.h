#pragma once
#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "grids/density_grid.h"

namespace dapple::test {

/// A cloud of 21^3 voxels 0.1 m apart about the origin: densest there, e^(-4 r^2), and less dense where
/// `ripple` of it, by a sine 0.7 m long, is taken off. `width`: voxels along x; those from the 21st on are
/// empty, but for the last one, which is next to nothing.
inline std::shared_ptr<const grids::DensityGrid> cloud(double ripple, int width = 21) {
    constexpr int n = 21;
    std::vector<float> values;
    for (int z = 0; z < n; ++z) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < width; ++x) {
                const glm::dvec3 p = 0.1 * glm::dvec3(x - 10, y - 10, z - 10);
                const double density = std::exp(-4 * glm::dot(p, p)) * (1 + ripple * std::sin(9 * p.x));
                values.push_back(x < n ? static_cast<float>(density) : 0.0f);
            }
        }
    }
    if (width > n) values.back() = 1e-6f;
    return grids::DensityGrid::from_values(glm::ivec3(-10), {width, n, n}, values,
                                           glm::dmat4(glm::dmat3(0.1)));
}

}  // namespace dapple::test
