#pragma once
#include <algorithm>
#include <cstddef>
#include <glm/glm.hpp>

#include "base/lane_vectors.h"
#include "base/large_vector.h"
#include "light/beam_mesh.h"
#include "light/grid_blocks.h"

namespace dapple::light {

/// The vertices of a group of a mesh as lanes: whole groups are read and written by fours of a row. At the
/// edges of the grid lanes that are not on repeat others.
class RayGroup {
public:
    RayGroup(const GridBlocks::Group& group, const BeamMesh& mesh)
        : group_(group), columns_(static_cast<std::size_t>(mesh.columns)) {}

    std::size_t vertex(std::size_t lane) const {
        return group_.first + std::min(lane / 4, group_.rows - 1) * columns_ +
               std::min(lane % 4, group_.columns - 1);
    }
    /// Lanes whose vertices BeamMesh::lit holds of.
    lanes::Flags lit(const BeamMesh& mesh) const {
        lanes::Flags result = of(mesh.flux) > 0.0f;
        for (std::size_t k = 0; k < kLanes && !(mesh.weight.empty() && group_.whole()); ++k)
            result[k] = on(k) && mesh.lit(vertex(k)) ? -1 : 0;
        return result;
    }
    /// m, where the rays leave the water or the mirror.
    lanes::Vectors3 start(const BeamMesh& mesh) const {
        return of(mesh.origin) + of(mesh.start) * of(mesh.slope);
    }

    lanes::Floats of(const LargeVector<float>& all) const {
        const float* first = &all[group_.first];
        if (group_.whole()) return lanes::load(first, first + columns_);
        lanes::Floats result{};
        for (std::size_t k = 0; k < kLanes; ++k) result[k] = all[vertex(k)];
        return result;
    }
    lanes::Vectors3 of(const LargeVector<glm::vec3>& all) const {
        const glm::vec3* first = &all[group_.first];
        if (group_.whole()) return lanes::load(first, first + columns_);
        lanes::Vectors3 result;
        for (std::size_t k = 0; k < kLanes; ++k) set_lane(result, k, all[vertex(k)]);
        return result;
    }
    void put(LargeVector<float>& all, lanes::Floats values) const {
        float* first = &all[group_.first];
        if (group_.whole()) return lanes::store(first, first + columns_, values);
        for (std::size_t k = 0; k < kLanes; ++k)
            if (on(k)) all[vertex(k)] = values[k];
    }
    void put(LargeVector<glm::vec3>& all, lanes::Vectors3 values) const {
        glm::vec3* first = &all[group_.first];
        if (group_.whole()) return lanes::store(first, first + columns_, values);
        for (std::size_t k = 0; k < kLanes; ++k)
            if (on(k)) all[vertex(k)] = lane(values, k);
    }

private:
    static constexpr std::size_t kLanes = lanes::kLanes<float>;
    bool on(std::size_t lane) const { return lane / 4 < group_.rows && lane % 4 < group_.columns; }

    GridBlocks::Group group_;
    std::size_t columns_;
};

}  // namespace dapple::light
