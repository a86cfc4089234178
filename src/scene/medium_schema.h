#pragma once
#include "scene/schema.h"

namespace dapple::scene {

/// The keys of a PhaseFunction.
const Structure& phase_schema();
/// The keys of a Medium.
const Structure& medium_schema();

}  // namespace dapple::scene
