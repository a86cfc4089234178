#include "gpu/pipeline.h"

#include <algorithm>

#include "gpu/device_state.h"

namespace dapple::gpu {
namespace {

vk::raii::ShaderModule make_module(const Device::State& device, std::span<const std::uint32_t> spirv) {
    return {device.device, {.codeSize = spirv.size_bytes(), .pCode = spirv.data()}};
}

/// Set layout and pipeline layout of an interface that all of `stages` see.
void make_layout(const Device::State& device, PipelineState& pipeline) {
    const Interface& interface = pipeline.interface;
    constexpr std::uint32_t kLargestPush = 128;  // what every device has
    require(interface.push_bytes <= kLargestPush && interface.push_bytes % 4 == 0,
            "pipeline '" + pipeline.name + "': push constants take at most 128 bytes, in whole words");
    require(interface.storage_buffers <= device.limits.maxPerStageDescriptorStorageBuffers &&
                interface.sampled_images <= device.limits.maxPerStageDescriptorSampledImages,
            "pipeline '" + pipeline.name + "': more bindings than the device has");
    std::vector<vk::DescriptorSetLayoutBinding> bindings;
    for (std::uint32_t i = 0; i < interface.storage_buffers + interface.sampled_images; ++i)
        bindings.push_back({.binding = i,
                            .descriptorType = i < interface.storage_buffers
                                                  ? vk::DescriptorType::eStorageBuffer
                                                  : vk::DescriptorType::eCombinedImageSampler,
                            .descriptorCount = 1,
                            .stageFlags = pipeline.stages});
    pipeline.set_layout = vk::raii::DescriptorSetLayout(
        device.device,
        {.bindingCount = static_cast<std::uint32_t>(bindings.size()), .pBindings = bindings.data()});
    const vk::PushConstantRange push{
        .stageFlags = pipeline.stages, .offset = 0, .size = interface.push_bytes};
    const vk::DescriptorSetLayout set = *pipeline.set_layout;
    pipeline.layout =
        vk::raii::PipelineLayout(device.device, {.setLayoutCount = 1,
                                                 .pSetLayouts = &set,
                                                 .pushConstantRangeCount = interface.push_bytes > 0 ? 1u : 0u,
                                                 .pPushConstantRanges = &push});
}

vk::PipelineColorBlendAttachmentState blend_state(Blend blend) {
    using Channel = vk::ColorComponentFlagBits;
    return {.blendEnable = blend == Blend::add ? VK_TRUE : VK_FALSE,
            .srcColorBlendFactor = vk::BlendFactor::eOne,
            .dstColorBlendFactor = vk::BlendFactor::eOne,
            .colorBlendOp = vk::BlendOp::eAdd,
            .srcAlphaBlendFactor = vk::BlendFactor::eOne,
            .dstAlphaBlendFactor = vk::BlendFactor::eOne,
            .alphaBlendOp = vk::BlendOp::eAdd,
            .colorWriteMask = Channel::eR | Channel::eG | Channel::eB | Channel::eA};
}

vk::CullModeFlagBits cull_mode(Cull cull) {
    return cull == Cull::front ? vk::CullModeFlagBits::eFront : vk::CullModeFlagBits::eNone;
}

}  // namespace

ComputePipeline::ComputePipeline(Device& device, std::string_view name, std::span<const std::uint32_t> spirv,
                                 Interface interface)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.name = name;
    s.interface = interface;
    s.stages = vk::ShaderStageFlagBits::eCompute;
    guarded("cannot make the pipeline '" + s.name + "'", [&] {
        const Device::State& d = device.state();
        make_layout(d, s);
        const vk::raii::ShaderModule module = make_module(d, spirv);
        s.pipeline = vk::raii::Pipeline(
            d.device, nullptr,
            vk::ComputePipelineCreateInfo{
                .stage = {.stage = vk::ShaderStageFlagBits::eCompute, .module = *module, .pName = "main"},
                .layout = *s.layout});
        d.set_name(*s.pipeline, name);
    });
}

ComputePipeline::~ComputePipeline() = default;
ComputePipeline::ComputePipeline(ComputePipeline&&) noexcept = default;
ComputePipeline& ComputePipeline::operator=(ComputePipeline&&) noexcept = default;

RasterPipeline::RasterPipeline(Device& device, std::string_view name,
                               std::span<const std::uint32_t> vertex_spirv,
                               std::span<const std::uint32_t> fragment_spirv,
                               const RasterDescription& description)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.name = name;
    s.interface = description.interface;
    s.description = description;
    s.stages = vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment;
    constexpr std::size_t kMostColors = 8;
    require(description.color_formats.size() <=
                std::min<std::size_t>(kMostColors, device.state().limits.maxColorAttachments),
            "pipeline '" + s.name + "': more colour targets than the device has");
    require(std::find(description.color_formats.begin(), description.color_formats.end(), Format::depth32f) ==
                description.color_formats.end(),
            "pipeline '" + s.name + "': depth32f is no colour format");
    require(description.blend == Blend::none ||
                std::find(description.color_formats.begin(), description.color_formats.end(), Format::r32u) ==
                    description.color_formats.end(),
            "pipeline '" + s.name + "': integers do not blend");
    guarded("cannot make the pipeline '" + s.name + "'", [&] {
        const Device::State& d = device.state();
        make_layout(d, s);
        const vk::raii::ShaderModule vertex = make_module(d, vertex_spirv);
        const vk::raii::ShaderModule fragment = make_module(d, fragment_spirv);
        const std::array stages = {
            vk::PipelineShaderStageCreateInfo{
                .stage = vk::ShaderStageFlagBits::eVertex, .module = *vertex, .pName = "main"},
            vk::PipelineShaderStageCreateInfo{
                .stage = vk::ShaderStageFlagBits::eFragment, .module = *fragment, .pName = "main"}};
        const vk::PipelineVertexInputStateCreateInfo
            vertices;  // none: shaders pull them from storage buffers
        const vk::PipelineInputAssemblyStateCreateInfo assembly{
            .topology = description.topology == Topology::points ? vk::PrimitiveTopology::ePointList
                                                                 : vk::PrimitiveTopology::eTriangleList};
        const vk::PipelineViewportStateCreateInfo viewport{.viewportCount = 1, .scissorCount = 1};
        const vk::PipelineRasterizationStateCreateInfo raster{.polygonMode = vk::PolygonMode::eFill,
                                                              .cullMode = cull_mode(description.cull),
                                                              .frontFace = vk::FrontFace::eCounterClockwise,
                                                              .lineWidth = 1};
        const vk::PipelineMultisampleStateCreateInfo samples{.rasterizationSamples =
                                                                 vk::SampleCountFlagBits::e1};
        const vk::Bool32 test = description.depth_test ? VK_TRUE : VK_FALSE;
        const vk::PipelineDepthStencilStateCreateInfo depth{
            .depthTestEnable = test, .depthWriteEnable = test, .depthCompareOp = vk::CompareOp::eLessOrEqual};
        const std::vector blends(description.color_formats.size(), blend_state(description.blend));
        const vk::PipelineColorBlendStateCreateInfo blend{
            .attachmentCount = static_cast<std::uint32_t>(blends.size()), .pAttachments = blends.data()};
        const std::array dynamic = {vk::DynamicState::eViewport, vk::DynamicState::eScissor};
        const vk::PipelineDynamicStateCreateInfo dynamics{
            .dynamicStateCount = static_cast<std::uint32_t>(dynamic.size()),
            .pDynamicStates = dynamic.data()};
        std::vector<vk::Format> formats;
        for (const Format format : description.color_formats) formats.push_back(vulkan_format(format));
        const vk::PipelineRenderingCreateInfo rendering{
            .colorAttachmentCount = static_cast<std::uint32_t>(formats.size()),
            .pColorAttachmentFormats = formats.data(),
            .depthAttachmentFormat =
                description.depth_test ? vk::Format::eD32Sfloat : vk::Format::eUndefined};
        s.pipeline = vk::raii::Pipeline(
            d.device, nullptr,
            vk::GraphicsPipelineCreateInfo{.pNext = &rendering,
                                           .stageCount = static_cast<std::uint32_t>(stages.size()),
                                           .pStages = stages.data(),
                                           .pVertexInputState = &vertices,
                                           .pInputAssemblyState = &assembly,
                                           .pViewportState = &viewport,
                                           .pRasterizationState = &raster,
                                           .pMultisampleState = &samples,
                                           .pDepthStencilState = &depth,
                                           .pColorBlendState = &blend,
                                           .pDynamicState = &dynamics,
                                           .layout = *s.layout});
        d.set_name(*s.pipeline, name);
    });
}

RasterPipeline::~RasterPipeline() = default;
RasterPipeline::RasterPipeline(RasterPipeline&&) noexcept = default;
RasterPipeline& RasterPipeline::operator=(RasterPipeline&&) noexcept = default;

}  // namespace dapple::gpu
