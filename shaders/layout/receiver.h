// What splats and cells of caustic maps ask of receivers.
#ifndef DAPPLE_LAYOUT_RECEIVER
#define DAPPLE_LAYOUT_RECEIVER
#include "layout/types.h"
LAYOUT_BEGIN

const float kSmallestNormalCosine = 0.7f;  // receivers that lean away more lie on another face

LAYOUT_END
#endif
