#pragma once
#include <memory>
#include <span>
#include <vector>

#include "base/stats.h"
#include "media/media.h"
#include "methods/sliced_beams/scatter_layer.h"
#include "methods/sliced_beams/scatter_pass.h"
#include "methods/sliced_beams/scatter_sheet.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

/// A frame's beams as light that media scatter once towards the camera.
class VolumeLight {
public:
    using Sheets = std::span<const std::unique_ptr<SheetCoverage<float>>>;

    /// The scene and the sheets must outlive this, and `pass`, if any, which takes the light that the device
    /// can find, and forgets that of frames before.
    VolumeLight(const scene::FrameScene& scene, Sheets sheets, FrameStats& stats,
                ScatterPass* pass = nullptr);

    /// Adds S of each of the layer's segments, W/m^2/sr, but for what `pass` has taken. The same bits on any
    /// number of threads.
    void add(const view::SegmentLayer& layer, std::span<glm::vec3> radiance, ScatterCounts& counts) const;
    /// Adds what `pass` has taken.
    void add_on_device(const view::SegmentLayer& layer, std::span<glm::vec3> radiance, ScatterCounts& counts,
                       FrameStats& stats) const;

private:
    /// What the group's segments scatter where bounded media may matter to them.
    void find_uneven(const LayerGroup& group, UnevenGroup<float>& uneven) const;
    using Direction = ScatterPass::Direction;
    /// Directions of the suns' discs that a camera sample is tried with, on one side of the water.
    std::vector<Direction> directions(const view::SegmentLayer& layer, bool in_water) const;

    const scene::FrameScene& scene_;
    media::Media media_;
    std::vector<PhaseTable<float>> phases_;  ///< of the media's components
    EvenMedium<float> even_[2]{};            ///< in the air: nothing; in the water
    std::vector<std::unique_ptr<ScatterSheet<float>>> sheets_;
    std::vector<std::uint8_t> on_cpu_;  ///< a sheet: 1 where the CPU has beams of it
    ScatterPass* pass_;
};

}  // namespace dapple::methods::sliced_beams
