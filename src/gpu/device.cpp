#include "gpu/device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "base/large_pages.h"
#include "gpu/device_state.h"

namespace dapple::gpu {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr const char* kNoDriver =
    "no Vulkan driver is installed; on Debian mesa-vulkan-drivers has one that needs no graphics card";

struct Features {
    vk::PhysicalDeviceFeatures core;
    vk::PhysicalDeviceVulkan12Features v12;
    vk::PhysicalDeviceVulkan13Features v13;
};

struct Feature {
    const char* name;
    vk::Bool32& (*field)(Features&);
};

/// All that a device has to offer beyond Vulkan 1.3 itself; the one list that is both checked and switched
/// on.
constexpr std::array kRequiredFeatures = {
    Feature{"scalarBlockLayout", [](Features& f) -> vk::Bool32& { return f.v12.scalarBlockLayout; }},
    Feature{"hostQueryReset", [](Features& f) -> vk::Bool32& { return f.v12.hostQueryReset; }},
    Feature{"dynamicRendering", [](Features& f) -> vk::Bool32& { return f.v13.dynamicRendering; }},
    Feature{"synchronization2", [](Features& f) -> vk::Bool32& { return f.v13.synchronization2; }},
    // The GLSL compiler states work group sizes by id.
    Feature{"maintenance4", [](Features& f) -> vk::Bool32& { return f.v13.maintenance4; }},
    // `discard` in GLSL for Vulkan 1.3 becomes one of these two.
    Feature{"shaderTerminateInvocation",
            [](Features& f) -> vk::Bool32& { return f.v13.shaderTerminateInvocation; }},
    Feature{"shaderDemoteToHelperInvocation",
            [](Features& f) -> vk::Bool32& { return f.v13.shaderDemoteToHelperInvocation; }},
};

struct RequiredFormat {
    const char* name;
    vk::Format format;
    vk::FormatFeatureFlags features;
};

const std::array kRequiredFormats = {
    RequiredFormat{
        "blending into 32-bit float RGBA images", vk::Format::eR32G32B32A32Sfloat,
        vk::FormatFeatureFlagBits::eColorAttachmentBlend | vk::FormatFeatureFlagBits::eSampledImage},
    RequiredFormat{
        "32-bit float depth images", vk::Format::eD32Sfloat,
        vk::FormatFeatureFlagBits::eDepthStencilAttachment | vk::FormatFeatureFlagBits::eSampledImage},
};

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

DeviceType device_type(vk::PhysicalDeviceType type) {
    switch (type) {
        case vk::PhysicalDeviceType::eDiscreteGpu:
            return DeviceType::discrete;
        case vk::PhysicalDeviceType::eIntegratedGpu:
            return DeviceType::integrated;
        case vk::PhysicalDeviceType::eCpu:
            return DeviceType::cpu;
        default:
            return DeviceType::other;
    }
}

int speed_rank(DeviceType type) {
    switch (type) {
        case DeviceType::discrete:
            return 3;
        case DeviceType::integrated:
            return 2;
        case DeviceType::cpu:
            return 1;
        case DeviceType::other:
            break;
    }
    return 0;
}

DeviceInfo describe(const vk::raii::PhysicalDevice& physical) {
    const auto properties = physical.getProperties();
    DeviceInfo info;
    info.name = properties.deviceName.data();
    info.api_version = std::to_string(VK_API_VERSION_MAJOR(properties.apiVersion)) + "." +
                       std::to_string(VK_API_VERSION_MINOR(properties.apiVersion)) + "." +
                       std::to_string(VK_API_VERSION_PATCH(properties.apiVersion));
    info.type = device_type(properties.deviceType);
    if (properties.apiVersion >= VK_API_VERSION_1_2) {
        const auto chain =
            physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
        const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
        info.driver = std::string(driver.driverName.data()) + " " + driver.driverInfo.data();
    }
    return info;
}

/// One queue that draws and computes, with timestamps.
std::optional<std::uint32_t> find_queue_family(const vk::raii::PhysicalDevice& physical) {
    const auto families = physical.getQueueFamilyProperties();
    constexpr auto kNeeded = vk::QueueFlagBits::eGraphics | vk::QueueFlagBits::eCompute;
    for (std::uint32_t i = 0; i < families.size(); ++i)
        if ((families[i].queueFlags & kNeeded) == kNeeded && families[i].timestampValidBits > 0) return i;
    return std::nullopt;
}

Features offered_features(const vk::raii::PhysicalDevice& physical) {
    const auto chain = physical.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                                             vk::PhysicalDeviceVulkan13Features>();
    return {chain.get<vk::PhysicalDeviceFeatures2>().features,
            chain.get<vk::PhysicalDeviceVulkan12Features>(), chain.get<vk::PhysicalDeviceVulkan13Features>()};
}

/// What the device lacks, as a list for people; empty if it is fit.
std::string lacking(const vk::raii::PhysicalDevice& physical) {
    if (physical.getProperties().apiVersion < VK_API_VERSION_1_3) return "Vulkan 1.3";
    std::string missing;
    const auto add = [&missing](const std::string& name) { missing += (missing.empty() ? "" : ", ") + name; };
    Features offered = offered_features(physical);
    for (const Feature& feature : kRequiredFeatures)
        if (!feature.field(offered)) add(feature.name);
    for (const RequiredFormat& required : kRequiredFormats) {
        const auto features = physical.getFormatProperties(required.format).optimalTilingFeatures;
        if ((features & required.features) != required.features) add(required.name);
    }
    if (!find_queue_family(physical)) add("a queue for graphics and compute with timestamps");
    return missing;
}

/// Messages that are no faults, each with the reason.
bool known_false_alarm(VkDebugUtilsMessageTypeFlagsEXT type, std::string_view id) {
    // Advice to move images to a layout a use. Ours stay in GENERAL, which every use permits: a CPU driver
    // gains nothing by others. The same id as an error, not as advice, counts.
    return (type & VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT) != 0 &&
           id == "UNASSIGNED-CoreValidation-DrawState-InvalidImageLayout";
}

VKAPI_ATTR VkBool32 VKAPI_CALL collect_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                               VkDebugUtilsMessageTypeFlagsEXT type,
                                               const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    if (known_false_alarm(type, data->pMessageIdName ? data->pMessageIdName : "")) return VK_FALSE;
    auto& log = *static_cast<ValidationLog*>(user);
    const std::lock_guard lock(log.mutex);
    log.messages.push_back(clipped(data->pMessage));
    return VK_FALSE;  // the call that is complained about goes on
}

vk::DebugUtilsMessengerCreateInfoEXT messenger_info(ValidationLog& log) {
    using Severity = vk::DebugUtilsMessageSeverityFlagBitsEXT;
    using Type = vk::DebugUtilsMessageTypeFlagBitsEXT;
    // Not eGeneral: the loader uses it to comment on other drivers and layers of the machine.
    return {.messageSeverity = Severity::eWarning | Severity::eError,
            .messageType = Type::eValidation | Type::ePerformance,
            .pfnUserCallback = collect_message,
            .pUserData = &log};
}

bool offers_layer(const vk::raii::Context& context, const char* name) {
    const auto layers = context.enumerateInstanceLayerProperties();
    return std::any_of(layers.begin(), layers.end(),
                       [name](const auto& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

bool offers_extension(const vk::raii::Context& context, const char* name) {
    const auto extensions = context.enumerateInstanceExtensionProperties();
    return std::any_of(extensions.begin(), extensions.end(), [name](const auto& extension) {
        return std::strcmp(extension.extensionName, name) == 0;
    });
}

vk::raii::Context make_context() {
    try {
        return {};
    } catch (const std::runtime_error&) {
        throw Error(ExitCode::device, "the Vulkan loader is not installed; on Debian it is in libvulkan1");
    }
}

/// `log` null: without validation.
vk::raii::Instance make_instance(const vk::raii::Context& context, bool debug_utils, ValidationLog* log) {
    const vk::ApplicationInfo application{.pApplicationName = "dapple", .apiVersion = VK_API_VERSION_1_3};
    std::vector<const char*> layers;
    std::vector<const char*> extensions;
    if (debug_utils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    vk::InstanceCreateInfo info{.pApplicationInfo = &application};

    const vk::ValidationFeatureEnableEXT synchronization =
        vk::ValidationFeatureEnableEXT::eSynchronizationValidation;
    vk::ValidationFeaturesEXT features{.enabledValidationFeatureCount = 1,
                                       .pEnabledValidationFeatures = &synchronization};
    vk::DebugUtilsMessengerCreateInfoEXT messenger;
    if (log) {
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
        messenger = messenger_info(*log);  // for messages of the instance's own creation and destruction
        features.pNext = &messenger;
        info.pNext = &features;
    }
    info.enabledLayerCount = static_cast<std::uint32_t>(layers.size());
    info.ppEnabledLayerNames = layers.data();
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    try {
        return {context, info};
    } catch (const vk::IncompatibleDriverError&) {
        throw Error(ExitCode::device, kNoDriver);
    }
}

vk::raii::PhysicalDevice choose(const vk::raii::Instance& instance, const std::string& name) {
    std::string present;
    std::string unfit;
    std::optional<vk::raii::PhysicalDevice> best;
    int best_rank = -1;
    for (auto& physical : vk::raii::PhysicalDevices(instance)) {
        const DeviceInfo info = describe(physical);
        present += (present.empty() ? "" : "; ") + info.name;
        if (lower(info.name).find(lower(name)) == std::string::npos) continue;
        if (const std::string missing = lacking(physical); !missing.empty()) {
            unfit += (unfit.empty() ? "" : "; ") + info.name + " lacks " + missing;
            continue;
        }
        if (speed_rank(info.type) > best_rank) {
            best_rank = speed_rank(info.type);
            best = std::move(physical);
        }
    }
    if (best) return std::move(*best);
    if (present.empty()) throw Error(ExitCode::device, kNoDriver);
    if (!unfit.empty()) throw Error(ExitCode::device, "no Vulkan device is fit: " + clipped(unfit));
    throw Error(ExitCode::device, "no Vulkan device is named '" + name + "'; present: " + clipped(present));
}

bool validation_asked_for(const DeviceOptions& options) {
    const char* variable = std::getenv("DAPPLE_VALIDATION");
    return options.validation || (variable && std::strcmp(variable, "1") == 0);
}

/// Threads of Mesa's CPU driver: read from the environment when an instance is made. A value of the user's
/// wins.
void set_driver_threads(int threads) {
    constexpr const char* kVariable = "LP_NUM_THREADS";
    static const bool users_choice = std::getenv(kVariable) != nullptr;
    if (threads > 0 && !users_choice) ::setenv(kVariable, std::to_string(threads).c_str(), 1);
}

}  // namespace

void require(bool condition, const std::string& sentence) {
    if (!condition) throw std::logic_error(sentence);
}

std::vector<DeviceInfo> list_devices() {
    std::vector<DeviceInfo> devices;
    try {
        const vk::raii::Context context = make_context();
        const vk::raii::Instance instance = make_instance(context, false, nullptr);
        for (const auto& physical : vk::raii::PhysicalDevices(instance))
            if (lacking(physical).empty()) devices.push_back(describe(physical));
    } catch (const Error&) {            // no loader or no driver: no devices
    } catch (const vk::SystemError&) {  // the loader found drivers and none that works
    }
    return devices;
}

Device::Device(const DeviceOptions& options) {
    set_driver_threads(options.threads);
    guarded("cannot open the Vulkan device", [&] {
        state_.reset(new State{.context = make_context()});
        State& s = *state_;
        s.validation = validation_asked_for(options);
        if (s.validation && !offers_layer(s.context, kValidationLayer))
            throw Error(ExitCode::device, std::string("the layer ") + kValidationLayer +
                                              " is asked for and not installed; on Debian it is in "
                                              "vulkan-validationlayers");
        s.debug_utils = offers_extension(s.context, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        s.instance =
            make_instance(s.context, s.debug_utils || s.validation, s.validation ? s.log.get() : nullptr);
        if (s.validation) s.messenger = vk::raii::DebugUtilsMessengerEXT(s.instance, messenger_info(*s.log));

        s.physical = choose(s.instance, options.name);
        s.info = describe(s.physical);
        s.memory = s.physical.getMemoryProperties();
        s.limits = s.physical.getProperties().limits;
        const auto sizes =
            s.physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceVulkan11Properties,
                                      vk::PhysicalDeviceVulkan13Properties>();
        s.largest_buffer = std::min(sizes.get<vk::PhysicalDeviceVulkan11Properties>().maxMemoryAllocationSize,
                                    sizes.get<vk::PhysicalDeviceVulkan13Properties>().maxBufferSize);
        s.queue_family = find_queue_family(s.physical).value();
        s.timestamp_bits = s.physical.getQueueFamilyProperties()[s.queue_family].timestampValidBits;
        s.large_points = offered_features(s.physical).core.largePoints;

        Features enabled;
        for (const Feature& feature : kRequiredFeatures) feature.field(enabled) = VK_TRUE;
        enabled.core.largePoints = s.large_points;
        enabled.v12.pNext = &enabled.v13;
        const vk::PhysicalDeviceFeatures2 features{.pNext = &enabled.v12, .features = enabled.core};
        const float priority = 1;
        const vk::DeviceQueueCreateInfo queue{
            .queueFamilyIndex = s.queue_family, .queueCount = 1, .pQueuePriorities = &priority};
        s.device = vk::raii::Device(
            s.physical, {.pNext = &features, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue});
        s.queue = vk::raii::Queue(s.device, s.queue_family, 0);
        s.nearest = vk::raii::Sampler(s.device, vk::SamplerCreateInfo{});
        constexpr auto kClamp = vk::SamplerAddressMode::eClampToEdge;
        s.linear = vk::raii::Sampler(s.device, vk::SamplerCreateInfo{.magFilter = vk::Filter::eLinear,
                                                                     .minFilter = vk::Filter::eLinear,
                                                                     .addressModeU = kClamp,
                                                                     .addressModeV = kClamp,
                                                                     .addressModeW = kClamp});
    });
}

Device::~Device() = default;

const DeviceInfo& Device::info() const {
    return state_->info;
}
const std::vector<std::string>& Device::validation_messages() const {
    return state_->log->messages;
}
std::shared_ptr<const std::vector<std::string>> Device::validation_log() const {
    return {state_->log, &state_->log->messages};
}
bool Device::validation_active() const {
    return state_->validation;
}
float Device::largest_point_size() const {
    return state_->large_points ? state_->limits.pointSizeRange[1] : 1.0f;
}
std::uint64_t Device::largest_storage_range() const {
    return state_->limits.maxStorageBufferRange;
}
int Device::largest_volume() const {
    return static_cast<int>(state_->limits.maxImageDimension3D);
}

vk::raii::DeviceMemory Device::State::allocate(const vk::MemoryRequirements& requirements,
                                               vk::MemoryPropertyFlags required,
                                               vk::MemoryPropertyFlags preferred) const {
    const auto allocated = [&](vk::MemoryPropertyFlags wanted) -> std::optional<vk::raii::DeviceMemory> {
        for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i)
            if ((requirements.memoryTypeBits >> i & 1u) &&
                (memory.memoryTypes[i].propertyFlags & wanted) == wanted) {
                vk::raii::DeviceMemory made(device,
                                            {.allocationSize = requirements.size, .memoryTypeIndex = i});
                // The memory of a device that is the processor is the process's own.
                if (info.type == DeviceType::cpu &&
                    (memory.memoryTypes[i].propertyFlags & vk::MemoryPropertyFlagBits::eHostVisible)) {
                    prefer_large_pages(made.mapMemory(0, VK_WHOLE_SIZE), requirements.size);
                    made.unmapMemory();
                }
                return made;
            }
        return std::nullopt;
    };
    try {
        if (auto found = allocated(required | preferred)) return std::move(*found);
    } catch (const vk::OutOfDeviceMemoryError&) {
        // The heap that is preferred may be a small window into the device; the required one is not.
    }
    if (auto found = allocated(required)) return std::move(*found);
    throw Error(ExitCode::device, "the Vulkan device has no memory of the kind that is needed");
}

void Device::State::submit_and_wait(vk::CommandBuffer commands) const {
    const vk::raii::Fence fence(device, vk::FenceCreateInfo{});
    const vk::CommandBufferSubmitInfo buffer{.commandBuffer = commands};
    queue.submit2(vk::SubmitInfo2{.commandBufferInfoCount = 1, .pCommandBufferInfos = &buffer}, *fence);
    while (device.waitForFences(*fence, VK_TRUE, UINT64_MAX) == vk::Result::eTimeout) {
    }
}

}  // namespace dapple::gpu
