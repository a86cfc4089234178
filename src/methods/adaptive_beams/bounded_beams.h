#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <list>
#include <span>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "gpu/pass_list.h"
#include "layout/beam_media.h"
#include "media/media.h"
#include "methods/adaptive_beams/beam_set.h"
#include "methods/adaptive_beams/light_lattices.h"
#include "methods/adaptive_beams/media_columns.h"
#include "scene/frame_scene.h"
#include "view/camera.h"
#include "view/segment_layer.h"

namespace dapple::methods::adaptive_beams {

/// Mean cosines of two lobes and the first one's share; of other functions this is -1.
glm::vec3 lobes_of(const scene::PhaseFunction& phase);

/// Phase functions of the media that are no sum of two lobes, as tables for the device.
class PhaseTables {
public:
    PhaseTables(gpu::Device& device, const media::Media& media);
    const gpu::Buffer& table() const { return values_; }
    /// First value of a component of media::Media; negative: lobes_of() says all.
    int first(std::size_t component) const { return first_[component]; }

private:
    std::vector<int> first_;
    gpu::Buffer values_;
};

/// What draws of a set among bounded media bind, beside what all do.
struct BoundedSet {
    const BeamSet* set;
    gpu::Buffer media;                   ///< two words of entry sizes, and layout::DrawnMedium
    gpu::Buffer light_columns;           ///< columns along rays of the set's beams
    std::vector<layout::BeamRays> rays;  ///< a beam

    /// Of some of its beams.
    gpu::Buffer rays_of(gpu::Device& device, std::size_t first, std::size_t count) const;
};

/// The camera rays of a picture: those with primary segments; `segments` may be null.
struct PictureRays {
    const view::SegmentLayer* segments;
    const view::Camera* camera;
    glm::dvec2 offset;  ///< of the sample in its pixel
};

/// Columns along the camera rays of a part of a picture.
struct RayColumns {
    std::size_t count;
    gpu::Buffer lines, values;
};

/// Bounded media on the device: what they do to light on its way along beams and along camera rays.
class BoundedBeams {
public:
    /// No table of light's columns has more bytes than `largest_buffer`.
    BoundedBeams(gpu::Device& device, std::uint64_t largest_buffer);
    /// A frame's media, which must outlive their use.
    void begin(const scene::FrameScene& scene, const media::Media& media, const PhaseTables& phases,
               FrameStats& stats);
    /// All sets of the frame, which must outlive their use: finds the columns of grids along rays of their
    /// beams (light_lattices.h); counts beams for which they are coarser than they should be. A result a set,
    /// which lives to the next begin(); null where its side of the water has no bounded media.
    std::vector<const BoundedSet*> add(std::span<const BeamSet> sets, FrameStats& stats);
    /// Lays out the columns along the rays of a picture, before they are found part by part: of all sets.
    void look_along(const PictureRays& picture, FrameStats& stats);
    /// Floats of a pixel's columns, of the picture that was looked along last.
    std::uint32_t ray_entry() const;
    /// Of `count` pixels of it from `first` on.
    RayColumns ray_columns(const PictureRays& picture, std::size_t first, std::size_t count) const;
    void add_passes(gpu::PassList& passes, const RayColumns& columns) const;

private:
    std::size_t media_bytes(bool in_water) const;
    void write_media(BoundedSet& bounded) const;
    layout::MediaLine camera_line(const PictureRays& picture, std::size_t pixel) const;

    gpu::Device& device_;
    std::uint64_t largest_buffer_;
    MediaColumns columns_;
    const scene::FrameScene* scene_ = nullptr;
    const media::Media* media_ = nullptr;
    const PhaseTables* phases_ = nullptr;
    ColumnTable rays_[2];  ///< of camera rays in air and in water
    LightTables light_;
    std::list<BoundedSet> sets_;
};

}  // namespace dapple::methods::adaptive_beams
