#pragma once
#include <memory>

#include "methods/caustic_method.h"

namespace dapple::methods {

/// Adaptive beam tracing (Liktor and Dachsbacher 2011): a coarse grid projected from the light is refined by
/// an oracle; its triangles become caustic beams, whose bounding volumes are rasterised, and each fragment
/// adds what its beam sends towards the camera: E at the receiver, S along the segment.
class AdaptiveBeams : public CausticMethod {
public:
    AdaptiveBeams();
    ~AdaptiveBeams() override;
    Support supports_surface(const scene::FrameState& state) const override;
    Support supports_volume(const scene::FrameState& state) const override;
    bool follows_glass() const override { return true; }
    std::size_t bytes(const scene::FrameState& state, std::size_t pixels) const override;
    void begin(FrameContext& context) override;
    void irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                    std::span<LayerResult> results) override;
    void expect(const view::ReceiverLayer& layer) override;
    void in_scatter(FrameContext& context, const view::SegmentLayer& layer,
                    std::span<glm::vec3> radiance) override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods
