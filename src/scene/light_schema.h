#pragma once
#include "scene/schema.h"

namespace dapple::scene {

/// The keys of a Light.
const Structure& light_schema();

}  // namespace dapple::scene
