#pragma once
#include "gpu/device.h"

namespace dapple::methods {

/// What draws the splats or cells of a caustic map into pictures.
enum class RasterBackend {
    automatic,  ///< by the type of the device, never by timing, so that bits repeat
    host,
    device,
};

/// On lavapipe the rasteriser costs five to nine times what the host's code does
/// (tests/benchmarks/light/bench_caustic_map.cpp).
inline bool draws_on_device(gpu::DeviceType type, RasterBackend backend) {
    return backend == RasterBackend::device ||
           (backend == RasterBackend::automatic && type != gpu::DeviceType::cpu);
}

}  // namespace dapple::methods
