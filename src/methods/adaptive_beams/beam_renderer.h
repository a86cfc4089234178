#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "methods/adaptive_beams/beam_set.h"
#include "methods/adaptive_beams/bounding_volume.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"
#include "view/segment_layer.h"

namespace dapple::methods::adaptive_beams {

/// Whether beams are drawn for a receiver: the camera sees it neither through nor by a specular surface, nor
/// from within glass, where no beam is.
inline bool seen_directly(std::uint32_t flags) {
    constexpr std::uint32_t relevant = view::kReceiver | view::kBehindSpecular | view::kInGlass;
    return (flags & relevant) == view::kReceiver;
}

/// How beams are shaded.
enum class Shading {
    exact,  ///< exact intervals along rays, densities continuous from beam to beam
    paper,  ///< as Liktor and Dachsbacher 2011, section 5; E is blurred by `paper_low_pass`
};

/// Sums of one layer, a value a pixel.
struct BeamSums {
    std::vector<glm::vec3> scattered;   ///< W/m^2/sr: S of the pixel's primary segment
    std::vector<glm::vec3> irradiance;  ///< W/m^2: E of its primary receiver
};

/// Rasterises beams: the volume of each is drawn, back faces only, so that each pixel that may see it is
/// shaded once, wherever the camera stands; what the beam sends to the pixel is added up in the order of the
/// beams. Surface and volume terms come from one rasterisation: S along the ray of the pixel's sample, E a
/// mean over the part of the pixel that the sample stands for, which volumes are wide enough to meet.
class BeamRenderer {
public:
    /// No buffer of beams has more bytes than `largest_buffer` or than the device can bind.
    explicit BeamRenderer(gpu::Device& device,
                          std::uint64_t largest_buffer = std::numeric_limits<std::uint64_t>::max());
    ~BeamRenderer();

    /// A frame's beams, before its layers. The scene must outlive them.
    void begin(const scene::FrameScene& scene, std::span<const BeamSet> sets, VolumeKind volumes,
               Shading shading, FrameStats& stats);
    /// E and S of a layer: of `segments` those that are primary, of `receivers` those that are
    /// seen_directly(); either may be null. They are of one sample and have the
    /// size of the clip's pictures.
    BeamSums render(const view::SegmentLayer* segments, const view::ReceiverLayer* receivers,
                    FrameStats& stats);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods::adaptive_beams
