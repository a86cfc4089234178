#pragma once
#include <memory>
#include <span>
#include <vector>

#include "base/stats.h"
#include "media/media.h"
#include "methods/sliced_beams/scatter_layer.h"
#include "methods/sliced_beams/scatter_sheet.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

/// A frame's beams as light that media scatter once towards the camera.
class VolumeLight {
public:
    using Sheets = std::span<const std::unique_ptr<SheetCoverage<float>>>;

    /// The scene and the sheets must outlive this.
    VolumeLight(const scene::FrameScene& scene, Sheets sheets, FrameStats& stats);

    /// Adds S of each of the layer's segments, W/m^2/sr. The same bits on any number of threads.
    void add(const view::SegmentLayer& layer, std::span<glm::vec3> radiance, ScatterCounts& counts) const;

private:
    /// What the group's segments scatter where bounded media may matter to them.
    void find_uneven(const LayerGroup& group, UnevenGroup<float>& uneven) const;
    struct Direction {
        std::size_t sheet;
        LightDirection<float> light;
        float share;  ///< of the sheet's light
    };
    /// Directions of the suns' discs that a camera sample is tried with, on one side of the water.
    std::vector<Direction> directions(const view::SegmentLayer& layer, bool in_water) const;

    const scene::FrameScene& scene_;
    media::Media media_;
    std::vector<PhaseTable<float>> phases_;  ///< of the media's components
    EvenMedium<float> even_[2]{};            ///< in the air: nothing; in the water
    std::vector<std::unique_ptr<ScatterSheet<float>>> sheets_;
};

}  // namespace dapple::methods::sliced_beams
