#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "gpu/pass_list.h"
#include "methods/draw_list.h"

/// What methods that draw parallelograms of the picture with the rasteriser of a device do alike.
namespace dapple::methods {

/// Sums into `layers` pictures at once, of what `images` textures a layer say of its receivers.
template <class Push>
gpu::RasterDescription additive(gpu::Topology topology, std::uint32_t layers, std::uint32_t images) {
    gpu::RasterDescription description;
    description.interface = {
        .storage_buffers = 1, .sampled_images = images * layers, .push_bytes = sizeof(Push)};
    description.topology = topology;
    description.blend = gpu::Blend::add;
    description.color_formats.assign(layers, gpu::Format::rgba32f);
    return description;
}

/// Primitives in buffers of the device that a storage binding takes: points, each a vertex, and quads of six.
template <class Primitive>
class DevicePrimitives {
public:
    /// `largest_buffer`: bytes.
    DevicePrimitives(gpu::Device& device, std::string name, std::uint64_t largest_buffer)
        : device_(device),
          name_(std::move(name)),
          points_(std::min(largest_buffer, device.largest_storage_range()) / sizeof(Primitive)),
          quads_(std::min(largest_buffer, device.largest_storage_range()) / sizeof(Primitive)) {}

    void clear() {
        points_.clear();
        quads_.clear();
    }
    template <class Band>
    void add(const std::vector<Band>& points, const std::vector<Band>& quads) {
        const auto make = [&](std::size_t room) {
            return Piece{
                gpu::Buffer(device_, name_.c_str(), room * sizeof(Primitive), gpu::BufferMemory::device)};
        };
        points_.add(points, make);
        quads_.add(quads, make);
    }
    std::size_t points() const { return points_.size(); }
    std::size_t quads() const { return quads_.size(); }

    /// All points, then all quads, each list in its order.
    template <class Push>
    void draw(gpu::PassList& passes, const char* pass, const gpu::RasterPipeline& with_points,
              const gpu::RasterPipeline& with_quads, const std::vector<const gpu::Image*>& receivers,
              const Push& push, gpu::Targets targets) const {
        const auto draw_all = [&](const gpu::RasterPipeline& pipeline, const DrawList<Primitive, Piece>& list,
                                  std::uint32_t vertices) {
            for (const auto& chunk : list.chunks()) {
                if (chunk.count == 0) continue;
                gpu::Bindings bindings{
                    .buffers = {&chunk.memory.buffer}, .images = receivers, .writes = {}, .push = {}};
                bindings.set_push(push);
                passes.draw(pass, pipeline, std::move(bindings), targets,
                            {.vertices = vertices * static_cast<std::uint32_t>(chunk.count)});
                targets.clear = false;
            }
        };
        draw_all(with_points, points_, 1);
        draw_all(with_quads, quads_, 6);
    }

private:
    struct Piece {
        gpu::Buffer buffer;
        std::span<Primitive> room() { return buffer.as<Primitive>(); }
    };
    gpu::Device& device_;
    std::string name_;
    DrawList<Primitive, Piece> points_, quads_;
};

}  // namespace dapple::methods
