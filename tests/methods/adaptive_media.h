#pragma once
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "grids/density_grid.h"
#include "scene/frame_scene.h"

/// Bounded media for frames of adaptive beams.
namespace dapple::test::adaptive_frame {

inline scene::Medium medium(scene::MediumType type, glm::dvec3 size = glm::dvec3(1)) {
    scene::Medium medium;
    medium.name = "fog";
    medium.type = type;
    medium.size = size;
    medium.extinction = {0.7, 1, 1.6};
    medium.albedo = {0.9, 0.5, 0.2};
    return medium;
}

inline std::shared_ptr<const grids::DensityGrid> grid_of(glm::ivec3 low, glm::ivec3 size, double voxel,
                                                         const std::function<double(glm::ivec3)>& value) {
    std::vector<float> values;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                values.push_back(static_cast<float>(value(low + glm::ivec3(x, y, z))));
    glm::dmat4 transform(voxel);
    transform[3][3] = 1;
    return grids::DensityGrid::from_values(low, size, values, transform);
}

}  // namespace dapple::test::adaptive_frame
