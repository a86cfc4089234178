#pragma once
#include "scene/schema.h"

namespace dapple::scene {

/// The keys of a Denoise.
const Structure& denoise_schema();

}  // namespace dapple::scene
