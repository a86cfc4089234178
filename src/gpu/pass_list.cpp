#include "gpu/pass_list.h"

#include <algorithm>
#include <array>
#include <utility>

#include "gpu/barrier_tracker.h"
#include "gpu/device_state.h"

namespace dapple::gpu {
namespace {

using Stage = vk::PipelineStageFlagBits2;
using Access = vk::AccessFlagBits2;

enum class Kind { compute, draw, image_to_buffer, buffer_to_image };

struct Pass {
    std::string name;
    Kind kind;
    std::vector<Use> uses;
    const PipelineState* pipeline = nullptr;
    std::vector<Buffer::State*> buffers;
    std::vector<Image::State*> images;
    std::vector<std::byte> push;
    std::array<std::uint32_t, 3> groups{};
    std::vector<Image::State*> colors;
    Image::State* depth = nullptr;
    bool clear = true;
    std::uint32_t vertices = 0;
    Buffer::State* indices = nullptr;
    vk::BufferImageCopy copied{};
};

const PipelineState& checked_pipeline(const std::string& name, const PipelineState& pipeline,
                                      const Bindings& bindings) {
    require(bindings.buffers.size() == pipeline.interface.storage_buffers &&
                bindings.images.size() == pipeline.interface.sampled_images &&
                bindings.push.size() == pipeline.interface.push_bytes,
            "pass '" + name + "' binds " + std::to_string(bindings.buffers.size()) + " buffers, " +
                std::to_string(bindings.images.size()) + " images and " +
                std::to_string(bindings.push.size()) + " push bytes; the interface of '" + pipeline.name +
                "' has " + std::to_string(pipeline.interface.storage_buffers) + ", " +
                std::to_string(pipeline.interface.sampled_images) + " and " +
                std::to_string(pipeline.interface.push_bytes));
    for (const Buffer* written : bindings.writes)
        require(
            std::find(bindings.buffers.begin(), bindings.buffers.end(), written) != bindings.buffers.end(),
            "pass '" + name + "' declares a write to a buffer that it does not bind");
    return pipeline;
}

/// Fills the parts that all passes with a pipeline share.
Pass bound_pass(const Device::State& device, std::string_view name, Kind kind, const PipelineState& pipeline,
                Bindings bindings, vk::PipelineStageFlags2 shader_stages) {
    Pass pass;
    pass.name = name;
    pass.kind = kind;
    pass.pipeline = &checked_pipeline(pass.name, pipeline, bindings);
    for (const Buffer* buffer : bindings.buffers) {
        Buffer::State& state = buffer->state();
        const auto largest = device.limits.maxStorageBufferRange;
        if (state.bytes > largest)
            throw Error(ExitCode::device, "pass '" + pass.name + "' cannot bind buffer '" + state.name +
                                              "' of " + std::to_string(state.bytes) +
                                              " bytes: the device takes " + std::to_string(largest) +
                                              " at most");
        const bool written =
            std::find(bindings.writes.begin(), bindings.writes.end(), buffer) != bindings.writes.end();
        pass.buffers.push_back(&state);
        pass.uses.push_back({&state, shader_stages, Access::eShaderStorageRead,
                             written ? vk::AccessFlags2(Access::eShaderStorageWrite) : vk::AccessFlags2()});
    }
    for (const Image* image : bindings.images) {
        pass.images.push_back(&image->state());
        pass.uses.push_back({&image->state(), shader_stages, Access::eShaderSampledRead, {}});
    }
    pass.push = std::move(bindings.push);
    return pass;
}

vk::BufferImageCopy whole_image(const Image::State& image) {
    return {.imageSubresource = {.aspectMask = image.aspect, .layerCount = 1},
            .imageExtent = {static_cast<std::uint32_t>(image.width), static_cast<std::uint32_t>(image.height),
                            static_cast<std::uint32_t>(image.depth)}};
}

Pass copy_pass(std::string_view name, Kind kind, Image::State& image, Buffer::State& buffer,
               const vk::BufferImageCopy& copied) {
    Pass pass;
    pass.name = name;
    pass.kind = kind;
    pass.images = {&image};
    pass.buffers = {&buffer};
    pass.copied = copied;
    const auto& [columns, rows, slices] = copied.imageExtent;
    require(std::size_t{columns} * rows * slices * bytes_per_texel(image.format) <= buffer.bytes,
            "pass '" + pass.name + "': the buffer is smaller than the image");
    if (kind == Kind::image_to_buffer)
        pass.uses = {{&image, Stage::eCopy, Access::eTransferRead, {}},
                     {&buffer, Stage::eCopy, {}, Access::eTransferWrite}};
    else
        pass.uses = {{&buffer, Stage::eCopy, Access::eTransferRead, {}},
                     {&image, Stage::eCopy, {}, Access::eTransferWrite}};
    return pass;
}

vk::RenderingAttachmentInfo attachment(const Image::State& image, bool clear, const vk::ClearValue& value) {
    return {.imageView = *image.view,
            .imageLayout = vk::ImageLayout::eGeneral,
            .loadOp = clear ? vk::AttachmentLoadOp::eClear : vk::AttachmentLoadOp::eLoad,
            .storeOp = vk::AttachmentStoreOp::eStore,
            .clearValue = value};
}

void record_draw(const vk::raii::CommandBuffer& commands, const Pass& pass) {
    const Image::State& size = pass.colors.empty() ? *pass.depth : *pass.colors.front();
    const vk::Rect2D area{
        .extent = {static_cast<std::uint32_t>(size.width), static_cast<std::uint32_t>(size.height)}};
    std::vector<vk::RenderingAttachmentInfo> colors;
    const vk::ClearValue zero(
        vk::ClearColorValue(std::array<std::uint32_t, 4>{}));  // 0 in floats and integers
    for (const Image::State* image : pass.colors) colors.push_back(attachment(*image, pass.clear, zero));
    vk::RenderingAttachmentInfo depth;
    if (pass.depth)
        depth = attachment(*pass.depth, pass.clear, vk::ClearValue(vk::ClearDepthStencilValue{.depth = 1}));
    commands.beginRendering({.renderArea = area,
                             .layerCount = 1,
                             .colorAttachmentCount = static_cast<std::uint32_t>(colors.size()),
                             .pColorAttachments = colors.data(),
                             .pDepthAttachment = pass.depth ? &depth : nullptr});
    commands.setViewport(0, vk::Viewport{.width = static_cast<float>(size.width),
                                         .height = static_cast<float>(size.height),
                                         .minDepth = 0,
                                         .maxDepth = 1});
    commands.setScissor(0, area);
    if (pass.indices) {
        commands.bindIndexBuffer(*pass.indices->buffer, 0, vk::IndexType::eUint32);
        commands.drawIndexed(pass.vertices, 1, 0, 0, 0);
    } else {
        commands.draw(pass.vertices, 1, 0, 0);
    }
    commands.endRendering();
}

}  // namespace

struct PassList::State {
    Device::State& device;
    std::vector<Pass> passes;

    vk::raii::DescriptorPool make_descriptor_pool() const;
    vk::raii::DescriptorSet make_set(const vk::raii::DescriptorPool& pool, const Pass& pass) const;
    void record(const vk::raii::CommandBuffer& commands, const vk::raii::QueryPool& times,
                const std::vector<vk::raii::DescriptorSet>& sets) const;
    std::vector<double> device_seconds(const vk::raii::QueryPool& times) const;
};

PassList::PassList(Device& device) : state_(new State{device.state(), {}}) {}
PassList::~PassList() = default;

void PassList::compute(std::string_view name, const ComputePipeline& pipeline, Bindings bindings,
                       std::array<std::uint32_t, 3> groups) {
    const auto& limits = state_->device.limits;
    for (std::size_t axis = 0; axis < 3; ++axis)
        require(groups[axis] <= limits.maxComputeWorkGroupCount[axis],
                "pass '" + std::string(name) + "' has more work groups along an axis than the device takes");
    Pass pass = bound_pass(state_->device, name, Kind::compute, pipeline.state(), std::move(bindings),
                           Stage::eComputeShader);
    pass.groups = groups;
    state_->passes.push_back(std::move(pass));
}

void PassList::draw(std::string_view name, const RasterPipeline& pipeline, Bindings bindings, Targets targets,
                    Draw draw) {
    require(bindings.writes.empty(), "pass '" + std::string(name) + "': draws write to their targets only");
    const RasterDescription& description = pipeline.state().description;
    Pass pass = bound_pass(state_->device, name, Kind::draw, pipeline.state(), std::move(bindings),
                           Stage::eVertexShader | Stage::eFragmentShader);
    require(!targets.colors.empty() || targets.depth, "pass '" + pass.name + "' has no target");
    require(targets.colors.size() == description.color_formats.size() &&
                (targets.depth != nullptr) == description.depth_test,
            "pass '" + pass.name + "': the targets are not those of the pipeline's description");
    const auto add_target = [&](const Image& image, Format format, vk::PipelineStageFlags2 stages,
                                vk::AccessFlags2 reads, vk::AccessFlags2 writes) {
        const Image& first = targets.colors.empty() ? *targets.depth : *targets.colors.front();
        require(image.format() == format && !image.state().volume && image.width() == first.width() &&
                    image.height() == first.height(),
                "pass '" + pass.name + "': target '" + image.state().name +
                    "' has another format than the pipeline, or another size than the first");
        require(std::find(pass.images.begin(), pass.images.end(), &image.state()) == pass.images.end(),
                "pass '" + pass.name + "' reads its own target '" + image.state().name + "'");
        pass.uses.push_back({&image.state(), stages, reads, writes});
    };
    for (std::size_t i = 0; i < targets.colors.size(); ++i) {
        add_target(*targets.colors[i], description.color_formats[i], Stage::eColorAttachmentOutput,
                   Access::eColorAttachmentRead, Access::eColorAttachmentWrite);
        pass.colors.push_back(&targets.colors[i]->state());
    }
    if (targets.depth) {
        add_target(*targets.depth, Format::depth32f, Stage::eEarlyFragmentTests | Stage::eLateFragmentTests,
                   Access::eDepthStencilAttachmentRead, Access::eDepthStencilAttachmentWrite);
        pass.depth = &targets.depth->state();
    }
    if (draw.index_buffer) {
        pass.indices = &draw.index_buffer->state();
        require(std::size_t{draw.vertices} * sizeof(std::uint32_t) <= pass.indices->bytes,
                "pass '" + pass.name + "' draws more indices than its index buffer has");
        pass.uses.push_back({pass.indices, Stage::eIndexInput, Access::eIndexRead, {}});
    }
    pass.clear = targets.clear;
    pass.vertices = draw.vertices;
    state_->passes.push_back(std::move(pass));
}

void PassList::copy(std::string_view name, const Image& from, const Buffer& to) {
    state_->passes.push_back(
        copy_pass(name, Kind::image_to_buffer, from.state(), to.state(), whole_image(from.state())));
}

void PassList::copy(std::string_view name, const Buffer& from, const Image& to) {
    state_->passes.push_back(
        copy_pass(name, Kind::buffer_to_image, to.state(), from.state(), whole_image(to.state())));
}

void PassList::copy(std::string_view name, const Image& from, const Texels& texels, const Buffer& to) {
    const auto& [left, top, columns, rows] = texels;
    require(left >= 0 && top >= 0 && columns > 0 && rows > 0 && left + columns <= from.width() &&
                top + rows <= from.height(),
            "pass '" + std::string(name) + "': the texels do not lie in the image");
    vk::BufferImageCopy copied = whole_image(from.state());
    copied.imageOffset = vk::Offset3D{left, top, 0};
    copied.imageExtent =
        vk::Extent3D{static_cast<std::uint32_t>(columns), static_cast<std::uint32_t>(rows), 1};
    state_->passes.push_back(copy_pass(name, Kind::image_to_buffer, from.state(), to.state(), copied));
}

vk::raii::DescriptorPool PassList::State::make_descriptor_pool() const {
    std::uint32_t sets = 0;
    std::uint32_t buffers = 0;
    std::uint32_t images = 0;
    for (const Pass& pass : passes) {
        if (!pass.pipeline) continue;
        ++sets;
        buffers += pass.pipeline->interface.storage_buffers;
        images += pass.pipeline->interface.sampled_images;
    }
    const std::array sizes = {
        vk::DescriptorPoolSize{vk::DescriptorType::eStorageBuffer, std::max(buffers, 1u)},
        vk::DescriptorPoolSize{vk::DescriptorType::eCombinedImageSampler, std::max(images, 1u)}};
    return {device.device,
            {.flags = vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
             .maxSets = std::max(sets, 1u),
             .poolSizeCount = static_cast<std::uint32_t>(sizes.size()),
             .pPoolSizes = sizes.data()}};
}

vk::raii::DescriptorSet PassList::State::make_set(const vk::raii::DescriptorPool& pool,
                                                  const Pass& pass) const {
    const vk::DescriptorSetLayout layout = *pass.pipeline->set_layout;
    vk::raii::DescriptorSets sets(device.device,
                                  {.descriptorPool = *pool, .descriptorSetCount = 1, .pSetLayouts = &layout});
    std::vector<vk::DescriptorBufferInfo> buffers;
    buffers.reserve(pass.buffers.size());
    for (const Buffer::State* buffer : pass.buffers) buffers.push_back({*buffer->buffer, 0, VK_WHOLE_SIZE});
    std::vector<vk::DescriptorImageInfo> images;
    images.reserve(pass.images.size());
    for (const Image::State* image : pass.images)
        images.push_back(
            {image->volume ? *device.linear : *device.nearest, *image->view, vk::ImageLayout::eGeneral});
    std::vector<vk::WriteDescriptorSet> writes;
    writes.reserve(buffers.size() + images.size());
    for (const auto& buffer : buffers)
        writes.push_back({.dstSet = *sets.front(),
                          .dstBinding = static_cast<std::uint32_t>(writes.size()),
                          .descriptorCount = 1,
                          .descriptorType = vk::DescriptorType::eStorageBuffer,
                          .pBufferInfo = &buffer});
    for (const auto& image : images)
        writes.push_back({.dstSet = *sets.front(),
                          .dstBinding = static_cast<std::uint32_t>(writes.size()),
                          .descriptorCount = 1,
                          .descriptorType = vk::DescriptorType::eCombinedImageSampler,
                          .pImageInfo = &image});
    device.device.updateDescriptorSets(writes, nullptr);
    return std::move(sets.front());
}

void PassList::State::record(const vk::raii::CommandBuffer& commands, const vk::raii::QueryPool& times,
                             const std::vector<vk::raii::DescriptorSet>& sets) const {
    const auto order = [&commands](const vk::MemoryBarrier2& barrier) {
        commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &barrier});
    };
    constexpr auto kAnyAccess = Access::eMemoryRead | Access::eMemoryWrite;
    // What earlier lists wrote is seen here.
    order({.srcStageMask = Stage::eAllCommands,
           .srcAccessMask = Access::eMemoryWrite,
           .dstStageMask = Stage::eAllCommands,
           .dstAccessMask = kAnyAccess});
    BarrierTracker tracker;
    std::size_t set = 0;
    std::uint32_t query = 0;
    for (const Pass& pass : passes) {
        if (device.debug_utils) commands.beginDebugUtilsLabelEXT({.pLabelName = pass.name.c_str()});
        if (const auto barrier = tracker.before(pass.uses)) order(*barrier);
        commands.writeTimestamp2(Stage::eAllCommands, *times, query++);
        if (pass.pipeline) {
            const auto bind_point = pass.kind == Kind::compute ? vk::PipelineBindPoint::eCompute
                                                               : vk::PipelineBindPoint::eGraphics;
            commands.bindPipeline(bind_point, *pass.pipeline->pipeline);
            commands.bindDescriptorSets(bind_point, *pass.pipeline->layout, 0, *sets[set++], nullptr);
            if (!pass.push.empty())
                commands.pushConstants<std::byte>(*pass.pipeline->layout, pass.pipeline->stages, 0,
                                                  pass.push);
        }
        switch (pass.kind) {
            case Kind::compute:
                commands.dispatch(pass.groups[0], pass.groups[1], pass.groups[2]);
                break;
            case Kind::draw:
                record_draw(commands, pass);
                break;
            case Kind::image_to_buffer:
                commands.copyImageToBuffer(*pass.images[0]->image, vk::ImageLayout::eGeneral,
                                           *pass.buffers[0]->buffer, pass.copied);
                break;
            case Kind::buffer_to_image:
                commands.copyBufferToImage(*pass.buffers[0]->buffer, *pass.images[0]->image,
                                           vk::ImageLayout::eGeneral, pass.copied);
                break;
        }
        commands.writeTimestamp2(Stage::eAllCommands, *times, query++);
        if (device.debug_utils) commands.endDebugUtilsLabelEXT();
    }
    // The host reads results once the fence is signalled.
    order({.srcStageMask = Stage::eAllCommands,
           .srcAccessMask = Access::eMemoryWrite,
           .dstStageMask = Stage::eHost,
           .dstAccessMask = Access::eHostRead});
}

std::vector<double> PassList::State::device_seconds(const vk::raii::QueryPool& times) const {
    const auto count = static_cast<std::uint32_t>(2 * passes.size());
    const auto [result, ticks] =
        times.getResults<std::uint64_t>(0, count, count * sizeof(std::uint64_t), sizeof(std::uint64_t),
                                        vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait);
    if (result != vk::Result::eSuccess) throw Error(ExitCode::device, "the device gave no timestamps");
    const std::uint64_t mask =
        device.timestamp_bits < 64 ? (std::uint64_t{1} << device.timestamp_bits) - 1 : ~std::uint64_t{0};
    std::vector<double> seconds;
    for (std::size_t i = 0; i < passes.size(); ++i)
        seconds.push_back(static_cast<double>((ticks[2 * i + 1] - ticks[2 * i]) & mask) *
                          static_cast<double>(device.limits.timestampPeriod) * 1e-9);
    return seconds;
}

void PassList::run(FrameStats& stats) {
    State& s = *state_;
    if (s.passes.empty()) return;
    const double wall_start = wall_seconds();
    const double cpu_start = cpu_seconds();
    std::vector<double> device_s;
    guarded("the Vulkan device failed in a list of passes that starts with '" + s.passes.front().name + "'",
            [&] {
                const vk::raii::DescriptorPool pool = s.make_descriptor_pool();
                std::vector<vk::raii::DescriptorSet> sets;
                for (const Pass& pass : s.passes)
                    if (pass.pipeline) sets.push_back(s.make_set(pool, pass));
                const auto queries = static_cast<std::uint32_t>(2 * s.passes.size());
                const vk::raii::QueryPool times(
                    s.device.device, {.queryType = vk::QueryType::eTimestamp, .queryCount = queries});
                times.reset(0, queries);
                s.device.submit_once(
                    [&](const vk::raii::CommandBuffer& commands) { s.record(commands, times, sets); });
                device_s = s.device_seconds(times);
            });
    // The host sees the list as a whole: its wall and CPU time are shared out in proportion to device time.
    const double wall_s = wall_seconds() - wall_start;
    const double cpu_s = cpu_seconds() - cpu_start;
    double total_s = 0;
    for (const double seconds : device_s) total_s += seconds;
    for (std::size_t i = 0; i < s.passes.size(); ++i) {
        const double share = total_s > 0 ? device_s[i] / total_s : 1.0 / static_cast<double>(s.passes.size());
        stats.add_pass({s.passes[i].name, wall_s * share, cpu_s * share, device_s[i]});
    }
    s.passes.clear();
}

}  // namespace dapple::gpu
