#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "gpu/device.h"

namespace dapple::test {

/// Holds the device that the tests of a program share, and fails the program at its end if the validation
/// layer had anything to say, the device's destruction included.
class ValidatedDevice : public ::testing::Environment {
public:
    void TearDown() override {
        device_.reset();
        if (!log_) return;
        for (const std::string& message : *log_) ADD_FAILURE() << "validation layer: " << message;
    }
    gpu::Device& device() {
        if (!device_) {
            gpu::DeviceOptions options;
            options.validation = true;
            device_ = std::make_unique<gpu::Device>(options);
            log_ = device_->validation_log();
        }
        return *device_;
    }

private:
    std::unique_ptr<gpu::Device> device_;
    std::shared_ptr<const std::vector<std::string>> log_;
};

inline ValidatedDevice* const validated_device_environment =
    static_cast<ValidatedDevice*>(::testing::AddGlobalTestEnvironment(new ValidatedDevice));

/// The device to test with: opened at the first call, with validation and synchronization checks. Resources
/// made with it must not outlive their test.
inline gpu::Device& validated_device() {
    return validated_device_environment->device();
}

}  // namespace dapple::test
