#pragma once
#include <memory>

#include "methods/caustic_method.h"
#include "methods/raster_backend.h"

namespace dapple::methods {

/// Photon splatting from a caustic map (Kougianos & Moustakas 2021, section 3). The vertices of the beam
/// meshes are photons; each lights the receivers about its landing point by a footprint that the timeline
/// names (scene::PhotonFootprint, footprint.h). By default that is a kernel which sums to one over the
/// photon's lattice, so flat water comes out flat and flux is kept.
class PhotonSplatting final : public CausticMethod {
public:
    explicit PhotonSplatting(RasterBackend backend = RasterBackend::automatic);
    ~PhotonSplatting() override;
    Support supports_surface(const scene::FrameState& state) const override;
    std::size_t bytes(const scene::FrameState& state, std::size_t pixels) const override;
    std::size_t bytes_on(gpu::DeviceType type, const scene::FrameState& state) const override;
    void begin(FrameContext& context) override;
    void irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                    std::span<LayerResult> results) override;

private:
    struct State;
    RasterBackend backend_;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods
