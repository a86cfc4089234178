#include "gpu/resource.h"

#include <algorithm>

#include "gpu/device_state.h"

namespace dapple::gpu {

vk::Format vulkan_format(Format format) {
    switch (format) {
        case Format::rgba32f:
            return vk::Format::eR32G32B32A32Sfloat;
        case Format::rg32f:
            return vk::Format::eR32G32Sfloat;
        case Format::r32f:
            return vk::Format::eR32Sfloat;
        case Format::r16f:
            return vk::Format::eR16Sfloat;
        case Format::r32u:
            return vk::Format::eR32Uint;
        case Format::depth32f:
            return vk::Format::eD32Sfloat;
    }
    return vk::Format::eUndefined;
}

std::size_t bytes_per_texel(Format format) {
    switch (format) {
        case Format::rgba32f:
            return 16;
        case Format::rg32f:
            return 8;
        case Format::r16f:
            return 2;
        default:
            return 4;
    }
}

Buffer::Buffer(Device& device, std::string_view name, std::size_t bytes, BufferMemory memory)
    : state_(std::make_unique<State>()) {
    constexpr std::size_t kSmallest = 16;  // Vulkan has no empty buffers
    const std::string what = "buffer '" + std::string(name) + "' of " + std::to_string(bytes) + " bytes";
    if (bytes > device.state().largest_buffer)
        throw Error(ExitCode::device, what + " cannot be made: the device takes " +
                                          std::to_string(device.state().largest_buffer) + " at most");
    guarded("cannot make " + what, [&] {
        State& s = *state_;
        s.device = &device.state();
        s.name = name;
        s.bytes = bytes;
        using Usage = vk::BufferUsageFlagBits;
        s.buffer = vk::raii::Buffer(
            s.device->device, {.size = std::max(bytes, kSmallest),
                               .usage = Usage::eStorageBuffer | Usage::eVertexBuffer | Usage::eIndexBuffer |
                                        Usage::eIndirectBuffer | Usage::eTransferSrc | Usage::eTransferDst});
        using Memory = vk::MemoryPropertyFlagBits;
        s.memory =
            s.device->allocate(s.buffer.getMemoryRequirements(), Memory::eHostVisible | Memory::eHostCoherent,
                               memory == BufferMemory::device ? Memory::eDeviceLocal : Memory::eHostCached);
        s.buffer.bindMemory(*s.memory, 0);
        s.mapped = s.memory.mapMemory(0, VK_WHOLE_SIZE);
        s.device->set_name(*s.buffer, name);
    });
}

Buffer::~Buffer() = default;
Buffer::Buffer(Buffer&&) noexcept = default;
Buffer& Buffer::operator=(Buffer&&) noexcept = default;
std::size_t Buffer::bytes() const {
    return state_->bytes;
}
void* Buffer::data() {
    return state_->mapped;
}

namespace {

/// The Vulkan objects of an image whose size is set.
void make(Image::State& s, std::string_view name, vk::ImageUsageFlags use) {
    const bool depth = s.format == Format::depth32f;
    s.name = name;
    s.aspect = depth ? vk::ImageAspectFlagBits::eDepth : vk::ImageAspectFlagBits::eColor;
    using Usage = vk::ImageUsageFlagBits;
    s.image =
        vk::raii::Image(s.device->device,
                        {.imageType = s.volume ? vk::ImageType::e3D : vk::ImageType::e2D,
                         .format = vulkan_format(s.format),
                         .extent = {static_cast<std::uint32_t>(s.width), static_cast<std::uint32_t>(s.height),
                                    static_cast<std::uint32_t>(s.depth)},
                         .mipLevels = 1,
                         .arrayLayers = 1,
                         .samples = vk::SampleCountFlagBits::e1,
                         .tiling = vk::ImageTiling::eOptimal,
                         .usage = use | Usage::eSampled | Usage::eTransferSrc | Usage::eTransferDst,
                         .initialLayout = vk::ImageLayout::eUndefined});
    s.memory =
        s.device->allocate(s.image.getMemoryRequirements(), {}, vk::MemoryPropertyFlagBits::eDeviceLocal);
    s.image.bindMemory(*s.memory, 0);
    s.device->set_name(*s.image, name);
    const vk::ImageSubresourceRange whole{.aspectMask = s.aspect, .levelCount = 1, .layerCount = 1};
    s.view = vk::raii::ImageView(s.device->device,
                                 {.image = *s.image,
                                  .viewType = s.volume ? vk::ImageViewType::e3D : vk::ImageViewType::e2D,
                                  .format = vulkan_format(s.format),
                                  .subresourceRange = whole});
    // Once and for all into the layout that every use permits.
    s.device->submit_once([&](const vk::raii::CommandBuffer& commands) {
        const vk::ImageMemoryBarrier2 to_general{
            .dstStageMask = vk::PipelineStageFlagBits2::eAllCommands,
            .dstAccessMask = vk::AccessFlagBits2::eMemoryRead | vk::AccessFlagBits2::eMemoryWrite,
            .oldLayout = vk::ImageLayout::eUndefined,
            .newLayout = vk::ImageLayout::eGeneral,
            .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
            .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
            .image = *s.image,
            .subresourceRange = whole};
        commands.pipelineBarrier2({.imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &to_general});
    });
}

}  // namespace

Image::Image(Device& device, std::string_view name, int width, int height, Format format)
    : state_(std::make_unique<State>()) {
    const std::string what = "image '" + std::string(name) + "' of " + std::to_string(width) + " x " +
                             std::to_string(height) + " pixels";
    const auto largest = static_cast<int>(device.state().limits.maxImageDimension2D);
    if (width < 1 || height < 1 || width > largest || height > largest)
        throw Error(ExitCode::device,
                    what + " cannot be made: the device takes 1 to " + std::to_string(largest) + " a side");
    guarded("cannot make " + what, [&] {
        State& s = *state_;
        s.device = &device.state();
        s.width = width;
        s.height = height;
        s.format = format;
        make(s, name,
             format == Format::depth32f ? vk::ImageUsageFlagBits::eDepthStencilAttachment
                                        : vk::ImageUsageFlagBits::eColorAttachment);
    });
}

Image::Image(Device& device, std::string_view name, Extent size) : state_(std::make_unique<State>()) {
    const std::string what = "3-D image '" + std::string(name) + "' of " + std::to_string(size.width) +
                             " x " + std::to_string(size.height) + " x " + std::to_string(size.depth) +
                             " texels";
    const int largest = device.largest_volume();
    if (std::min({size.width, size.height, size.depth}) < 1 ||
        std::max({size.width, size.height, size.depth}) > largest)
        throw Error(ExitCode::device,
                    what + " cannot be made: the device takes 1 to " + std::to_string(largest) + " a side");
    guarded("cannot make " + what, [&] {
        State& s = *state_;
        s.device = &device.state();
        s.width = size.width;
        s.height = size.height;
        s.depth = size.depth;
        s.volume = true;
        s.format = Format::r16f;
        make(s, name, {});
    });
}

Image::~Image() = default;
Image::Image(Image&&) noexcept = default;
Image& Image::operator=(Image&&) noexcept = default;
int Image::width() const {
    return state_->width;
}
int Image::height() const {
    return state_->height;
}
int Image::depth() const {
    return state_->depth;
}
Format Image::format() const {
    return state_->format;
}

}  // namespace dapple::gpu
