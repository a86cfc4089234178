#pragma once
#include "scene/schema.h"

namespace dapple::scene {

/// The keys of a Water.
const Structure& water_schema();

}  // namespace dapple::scene
