#pragma once
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "methods/reference/layer_estimate.h"
#include "methods/reference/light_tracer.h"

namespace dapple::reference {

/// What a pass found beside irradiance, and the rays of all sources.
struct PassResult {
    EnergyAccount account;
    std::size_t rays = 0;
};

/// Traces all sources of one pass and gives, for each of `layers`, the irradiance [W/m^2] of its pixels, in
/// `irradiance`. Deposits of fixed tiles of strata are added in the order of the tiles, so that the bits do
/// not depend on the number of threads, nor on which layers are served together. None, with `irradiance`
/// useless, as soon as `stop` says so.
std::optional<PassResult> run_pass(const LightTracer& tracer, const LightPass& pass,
                                   std::span<const LayerCells* const> layers,
                                   const std::function<bool()>& stop,
                                   std::vector<std::vector<glm::dvec3>>& irradiance);

}  // namespace dapple::reference
