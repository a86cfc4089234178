#pragma once
#include <cstddef>

#include "base/lane_vectors.h"

/// Vectors of eight photons at once, a lane each.
namespace dapple::methods {

inline constexpr std::size_t kPhotons = lanes::kLanes<float>;

using lanes::all;
using lanes::choose;
using lanes::cross;
using lanes::dot;
using lanes::finite;
using lanes::first_of;
using lanes::Flags;
using lanes::Floats;
using lanes::lane;
using lanes::load;
using lanes::normalized;
using lanes::set_lane;
using lanes::store;
using lanes::Vectors2;
using lanes::Vectors3;

}  // namespace dapple::methods
