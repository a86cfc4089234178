#pragma once
#include "base/lanes.h"

namespace dapple::methods::sliced_beams {

using lanes::any;
using lanes::bits;
using lanes::decay;
using lanes::greater;
using lanes::inverse_root;
using lanes::kLanes;
using lanes::Lanes;
using lanes::lesser;
using lanes::magnitude;
using lanes::Mask;
using lanes::multiply_add;
using lanes::splat;
using lanes::square_root;
using lanes::sum;

/// Beams are worked on eight at a time.
constexpr int kClusterBeams = 8;

template <class Real>
constexpr int kChunks = kClusterBeams / kLanes<Real>;

}  // namespace dapple::methods::sliced_beams
