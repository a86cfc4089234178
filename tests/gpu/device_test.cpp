#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <optional>

#include "base/error.h"
#include "gpu/validated_device.h"

namespace dapple::gpu {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Sets an environment variable for the length of a scope.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name) {
        if (const char* old = std::getenv(name)) old_ = old;
        ::setenv(name, value, 1);
    }
    ~Variable() {
        if (old_)
            ::setenv(name_, old_->c_str(), 1);
        else
            ::unsetenv(name_);
    }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    const char* name_;
    std::optional<std::string> old_;
};

std::string message_of_failure(const DeviceOptions& options) {
    try {
        const Device device(options);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::device);
        return error.what();
    }
    ADD_FAILURE() << "the device opened";
    return {};
}

TEST(Devices, TheDefaultIsListedAndSaysWhatItIs) {
    const Device& device = test::validated_device();
    const std::vector<DeviceInfo> devices = list_devices();
    ASSERT_THAT(devices, Not(IsEmpty()));
    EXPECT_TRUE(std::any_of(devices.begin(), devices.end(), [&](const DeviceInfo& info) {
        return info.name == device.info().name && info.driver == device.info().driver;
    }));
    EXPECT_THAT(device.info().api_version, HasSubstr("1."));
    EXPECT_GE(device.largest_point_size(), 1);
    EXPECT_GE(device.largest_storage_range(), 1u << 27);  // Vulkan's least
    EXPECT_TRUE(device.validation_active());
}

TEST(Devices, APartOfTheNameInAnyCaseChooses) {
    std::string part = list_devices().at(0).name.substr(0, 6);
    std::transform(part.begin(), part.end(), part.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    const Device device({.name = part});
    EXPECT_EQ(device.info().name, list_devices().at(0).name);
}

TEST(Devices, AnUnknownNameListsThoseThatArePresent) {
    const std::string message = message_of_failure({.name = "no such card"});
    EXPECT_THAT(message, HasSubstr("no Vulkan device is named 'no such card'; present: "));
    EXPECT_THAT(message, HasSubstr(list_devices().at(0).name));
}

TEST(Devices, WithoutADriverTheMessageNamesThePackage) {
    const Variable none("VK_DRIVER_FILES", "/nonexistent.json");
    const Variable old_name("VK_ICD_FILENAMES", "/nonexistent.json");
    EXPECT_THAT(list_devices(), IsEmpty());
    EXPECT_THAT(message_of_failure({}), HasSubstr("mesa-vulkan-drivers"));
}

TEST(Devices, WithoutTheValidationLayerTheMessageNamesThePackage) {
    const Variable none("VK_LAYER_PATH", "/nonexistent");
    EXPECT_THAT(message_of_failure({.validation = true}), HasSubstr("vulkan-validationlayers"));
}

TEST(Devices, TheEnvironmentSwitchesValidationOn) {
    const Variable on("DAPPLE_VALIDATION", "1");
    EXPECT_TRUE(Device({}).validation_active());
    const Variable off("DAPPLE_VALIDATION", "0");
    EXPECT_FALSE(Device({}).validation_active());
}

TEST(Devices, ThreadsReachTheCpuDriver) {
    if (std::getenv("LP_NUM_THREADS")) GTEST_SKIP() << "the user's own choice holds";
    const Device one({.threads = 1});
    EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "1");
    const Device two({.threads = 2});
    EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "2");
}

}  // namespace
}  // namespace dapple::gpu
