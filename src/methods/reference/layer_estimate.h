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

/// Passes of equal size, whose pixel means are independent estimates of one layer, and what they say so far.
/// Rounds follow one another: the first is small, and one that does not reach the standard error that is
/// asked for is thrown away for another of more strata. (In a stratified pass errors fall faster than by the
/// root of the number of rays, so few large passes beat many small ones.)
struct RoundEstimate {
    std::uint64_t strata = 0;           ///< a pass and light
    std::uint64_t passes = 0;           ///< done in this round
    std::uint64_t rays = 0;             ///< a light, of all rounds
    bool done = false;                  ///< the last round is complete
    std::vector<glm::dvec3> mean;       ///< of E [W/m^2], a pixel, over the passes
    std::vector<glm::dvec3> deviation;  ///< sum of squared deviations from it (Welford 1962)

    /// Empties it for a round of that size.
    void start(std::uint64_t strata_a_pass, std::size_t pixels);
    void add_pass(const std::vector<glm::dvec3>& irradiance);
    /// Squared standard error of the mean, of one pixel; passes >= 2.
    glm::dvec3 variance(std::size_t pixel) const;
    /// Mean over the covered pixels of the standard error, over that of E (means of the channels); 0 where E
    /// is 0.
    double relative_error(const std::vector<std::uint16_t>& paths) const;
};

}  // namespace dapple::reference
