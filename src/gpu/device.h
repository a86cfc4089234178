#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace dapple::gpu {

enum class DeviceType { cpu, integrated, discrete, other };

struct DeviceInfo {
    std::string name;         ///< "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::string driver;       ///< "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)"
    std::string api_version;  ///< "1.3.230"
    DeviceType type = DeviceType::other;
};

struct DeviceOptions {
    std::string name{};  ///< part of a device's name, any case; empty: the fastest present
    bool validation =
        false;        ///< validation layer with synchronization checks; also on when $DAPPLE_VALIDATION is 1
    int threads = 0;  ///< worker threads of a CPU driver; 0: its own choice
};

/// All Vulkan devices of the machine that satisfy the program's needs (1.3, features of device.cpp).
std::vector<DeviceInfo> list_devices();

/// One headless Vulkan device with one queue. The header is thin on purpose: Vulkan stays in gpu/*.cpp.
class Device {
public:
    explicit Device(const DeviceOptions& options);  // throws Error(device)
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    const DeviceInfo& info() const;
    /// Messages of the validation layer so far (warnings and errors); 0 where validation is off.
    const std::vector<std::string>& validation_messages() const;
    /// The same list, which outlives the device: it also has the messages of the device's destruction.
    std::shared_ptr<const std::vector<std::string>> validation_log() const;
    bool validation_active() const;
    float largest_point_size() const;             ///< pixels
    std::uint64_t largest_storage_range() const;  ///< bytes of one storage-buffer binding
    int largest_volume() const;                   ///< texels a side of 3-D images

    struct State;  // gpu/device_state.h, for gpu/*.cpp only
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace dapple::gpu
