#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "methods/caustic_method.h"
#include "methods/reference/deposit_cells.h"
#include "methods/reference/receiver_charts.h"
#include "view/receiver_layer.h"

namespace dapple::reference {

/// Sub-pixel camera paths along each side of the part of a pixel that a sample stands for.
constexpr int kPathsAcross = 16;

/// The pixels of one receiver layer and the cells in which their light is counted.
struct LayerCells {
    DepositCells cells;
    std::vector<std::uint16_t> paths;  ///< a pixel: camera paths that count; 0: not covered
};

/// Traces kPathsAcross^2 camera paths a pixel over the sample's cell. Those count that end on a receiver of
/// the medium of the layer's own path; a pixel is covered where that one has a receiver and some path counts.
LayerCells layer_cells(const scene::FrameScene& scene, const rays::RayScene& rays,
                       const ReceiverCharts& charts, const view::ReceiverLayer& layer);

}  // namespace dapple::reference
