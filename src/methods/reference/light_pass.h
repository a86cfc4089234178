#pragma once
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "methods/reference/layer_estimate.h"
#include "methods/reference/light_tracer.h"

namespace dapple::reference {

/// Traces all lights of one pass and gives, for each of `layers`, the irradiance [W/m^2] of its pixels, in
/// `irradiance`. Deposits of fixed tiles of strata are added in the order of the tiles, so that the bits do
/// not depend on the number of threads, nor on which layers are served together. False, with `irradiance`
/// useless, as soon as `stop` says so.
bool run_pass(const LightTracer& tracer, const LightPass& pass, std::span<const LayerCells* const> layers,
              const std::function<bool()>& stop, std::vector<std::vector<glm::dvec3>>& irradiance);

}  // namespace dapple::reference
