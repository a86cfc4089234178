#pragma once
#include <memory>

#include "methods/caustic_method.h"
#include "methods/raster_backend.h"

namespace dapple::methods {

/// The procedural caustic mesh of Ouyang & Yang 2020 on a caustic map: rays that are neighbours on the map
/// span cells, whose landed images are rasterised from the camera; their brightness is what they carry over
/// their area. A mesh each for refraction and reflection, and for each cascade.
///
/// As the paper has it (`paper_faithful`) a triangle is of one brightness, seen at the pixel's point, and
/// left out where its corners land on different surfaces: a black edge about objects. Else
/// * brightness is linear on a cell, and the cell's flux is kept exactly;
/// * pixels get the mean over their part of the picture, by exact coverage, so that slender cells count too;
///   cells thinner than a fiftieth of a pixel are drawn that wide;
/// * cells at edges of objects are cut finer, by rays of their own, and laid onto each of the surfaces.
class CausticMesh final : public CausticMethod {
public:
    explicit CausticMesh(RasterBackend backend = RasterBackend::automatic);
    ~CausticMesh() override;
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
