#pragma once
#include <memory>

#include "methods/caustic_method.h"

namespace dapple::methods {

/// Where the coverage of receivers, and the light that even water scatters out of beams, are computed.
enum class CoverageBackend {
    automatic,  ///< by the type of the device
    cpu,
    compute,  ///< on the device, but for meshes that it cannot bind and what the passes leave to the CPU
};

/// Exact up to the mesh, without noise: every triangle of the water is a beam of light; what part of a landed
/// beam lies within a receiver's footprint is found by clipping, for all beams that can reach it. Beams are
/// found through a min/max pyramid over their landing points, which are linear in depth.
class SlicedBeams : public CausticMethod {
public:
    explicit SlicedBeams(CoverageBackend coverage = CoverageBackend::automatic);
    ~SlicedBeams() override;
    Support supports_surface(const scene::FrameState& state) const override;
    bool serves_behind_specular() const override { return true; }
    bool serves_any_layer() const override { return true; }
    std::size_t bytes(const scene::FrameState& state, std::size_t pixels) const override;
    std::size_t bytes_on(gpu::DeviceType type, const scene::FrameState& state) const override;
    void begin(FrameContext& context) override;
    void irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                    std::span<LayerResult> results) override;
    Support supports_volume(const scene::FrameState& state) const override;
    void in_scatter(FrameContext& context, const view::SegmentLayer& layer,
                    std::span<glm::vec3> radiance) override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods
