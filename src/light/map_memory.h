#pragma once
#include <algorithm>
#include <cstddef>

#include "scene/frame_state.h"

namespace dapple::light {

/// What caustic maps take, foreseen from the state alone. Borders of maps are left out, which are thin but
/// for low suns: at most four times as many texels in all. In double, since maps may be asked for of any
/// size.
struct MapMemory {
    /// Bytes of what CausticMapper::trace_each holds while `take` is called, and before: a map, its meshes,
    /// and the water on the device.
    double tracing = 0;
    double kept = 0;     ///< bytes of what it holds from then on
    double largest = 0;  ///< vertices of the largest of these meshes
    double photons = 0;  ///< of all lights' maps: at most so many carry light
    int events = 1;      ///< meshes a map
};

/// For methods that serve receivers which the camera sees directly. Needs FrameState::water.
MapMemory foresee_maps(const scene::FrameState& state);

/// At most 2^61: maps of absurd size must not wrap around to a small number.
inline std::size_t bounded_bytes(double bytes) {
    return static_cast<std::size_t>(std::min(0x1p61, bytes));
}

}  // namespace dapple::light
