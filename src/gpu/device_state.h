#pragma once
// Private to gpu/*.cpp: the Vulkan objects behind the public headers. vk::raii costs 6 s and 400 MB a file,
// so no other file includes this one.
#define VULKAN_HPP_NO_STRUCT_CONSTRUCTORS
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "base/error.h"
#include "gpu/device.h"
#include "gpu/pipeline.h"
#include "gpu/resource.h"

namespace dapple::gpu {

/// What the validation layer said. It outlives the device, so that messages of its destruction are kept too.
struct ValidationLog {
    std::mutex mutex;
    std::vector<std::string> messages;
};

struct Device::State {
    std::shared_ptr<ValidationLog> log = std::make_shared<ValidationLog>();
    DeviceInfo info{};
    bool validation = false;
    bool debug_utils = false;
    bool large_points = false;
    vk::PhysicalDeviceLimits limits{};
    vk::PhysicalDeviceMemoryProperties memory{};
    std::uint64_t largest_buffer = 0;  // bytes
    std::uint32_t queue_family = 0;
    std::uint32_t timestamp_bits = 0;

    vk::raii::Context context;
    vk::raii::Instance instance = nullptr;
    vk::raii::DebugUtilsMessengerEXT messenger = nullptr;
    vk::raii::PhysicalDevice physical = nullptr;
    vk::raii::Device device = nullptr;
    vk::raii::Queue queue = nullptr;
    vk::raii::Sampler nearest = nullptr;  // for texelFetch, which ignores its settings
    vk::raii::Sampler linear = nullptr;   // of 3-D images

    /// Gives a Vulkan object the name that messages and capture tools show.
    template <class Handle>
    void set_name(const Handle& handle, std::string_view name) const {
        if (!debug_utils) return;
        using Native = typename Handle::CType;
        const std::string terminated(name);
        device.setDebugUtilsObjectNameEXT(
            {.objectType = Handle::objectType,
             .objectHandle = reinterpret_cast<std::uint64_t>(static_cast<Native>(handle)),
             .pObjectName = terminated.c_str()});
    }
    /// Memory for `requirements` with all of `required` and, where there is such, all of `preferred`
    /// properties.
    vk::raii::DeviceMemory allocate(const vk::MemoryRequirements& requirements,
                                    vk::MemoryPropertyFlags required,
                                    vk::MemoryPropertyFlags preferred) const;
    /// Records commands with `record(command_buffer)`, submits them and waits.
    template <class Record>
    void submit_once(Record&& record) const {
        const vk::raii::CommandPool pool(device, {.queueFamilyIndex = queue_family});
        const vk::raii::CommandBuffers buffers(device, {.commandPool = *pool, .commandBufferCount = 1});
        const vk::raii::CommandBuffer& commands = buffers.front();
        commands.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
        record(commands);
        commands.end();
        submit_and_wait(*commands);
    }
    void submit_and_wait(vk::CommandBuffer commands) const;
};

struct Buffer::State {
    Device::State* device = nullptr;
    std::string name;
    std::size_t bytes = 0;
    vk::raii::DeviceMemory memory = nullptr;  // before the buffer, so that it is freed after it
    vk::raii::Buffer buffer = nullptr;
    void* mapped = nullptr;
};

struct Image::State {
    Device::State* device = nullptr;
    std::string name;
    int width = 0;
    int height = 0;
    int depth = 1;
    bool volume = false;  // 3-D
    Format format = Format::rgba32f;
    vk::ImageAspectFlags aspect;
    vk::raii::DeviceMemory memory = nullptr;
    vk::raii::Image image = nullptr;
    vk::raii::ImageView view = nullptr;
};

struct PipelineState {
    std::string name;
    Interface interface;
    vk::ShaderStageFlags stages;
    vk::raii::DescriptorSetLayout set_layout = nullptr;
    vk::raii::PipelineLayout layout = nullptr;
    vk::raii::Pipeline pipeline = nullptr;
};
struct ComputePipeline::State : PipelineState {};
struct RasterPipeline::State : PipelineState {
    RasterDescription description;
};

vk::Format vulkan_format(Format format);
std::size_t bytes_per_texel(Format format);

/// Programming errors of callers: a sentence also in release builds, since a driver would answer with a
/// crash.
void require(bool condition, const std::string& sentence);

/// Runs `body`; Vulkan's exceptions become Error(device): "<what>: <clipped message>".
template <class Body>
auto guarded(const std::string& what, Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (const vk::SystemError& error) {
        throw Error(ExitCode::device, what + ": " + clipped(error.what()));
    }
}

}  // namespace dapple::gpu
