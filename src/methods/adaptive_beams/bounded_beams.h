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
#include "methods/adaptive_beams/media_columns.h"
#include "scene/frame_scene.h"
#include "view/camera.h"
#include "view/segment_layer.h"

namespace dapple::methods::adaptive_beams {

/// Bytes of the columns along all rays of a frame's beams, and of those rays, at most; but for what the
/// coarsest take.
constexpr std::uint64_t kLightColumnBytes = std::uint64_t{512} << 20;
/// And these of a beam, for so many grids.
std::uint64_t least_column_bytes(std::size_t grids);

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
    gpu::Buffer media;                   ///< two words of entry sizes, and layout::DrawnMedium
    gpu::Buffer light_columns;           ///< columns along rays of the set's beams
    std::vector<layout::BeamRays> rays;  ///< a beam

    /// Of some of its beams.
    gpu::Buffer rays_of(gpu::Device& device, std::size_t first, std::size_t count) const;
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
    /// All sets of the frame: finds the columns of grids along rays of their beams, about two voxels apart,
    /// at so many depths; fewer of both where they would take too much memory. A result a set, which lives to
    /// the next begin(); null where its side of the water has no bounded media.
    std::vector<const BoundedSet*> add(std::span<const BeamSet> sets, FrameStats& stats);
    /// Floats of a pixel's columns.
    std::uint32_t ray_entry() const;
    /// Of `count` pixels from `first` on; no segments: of none.
    RayColumns ray_columns(const view::SegmentLayer* segments, std::size_t first, std::size_t count,
                           const view::Camera& camera, glm::dvec2 offset) const;
    void add_passes(gpu::PassList& passes, const RayColumns& columns) const;

private:
    struct Lattices;
    Lattices wanted(const BeamSet& set) const;
    void thin_out(std::vector<Lattices>& all);
    void write_lines(const Lattices& lattices, std::span<layout::MediaLine> lines) const;
    gpu::Buffer media_of(const BeamSet& set) const;

    gpu::Device& device_;
    std::uint64_t largest_buffer_;
    MediaColumns columns_;
    const scene::FrameScene* scene_ = nullptr;
    const media::Media* media_ = nullptr;
    const PhaseTables* phases_ = nullptr;
    ColumnTable rays_[2];   ///< of camera rays in air and in water
    ColumnTable light_[2];  ///< of rays of beams
    std::list<BoundedSet> sets_;
};

}  // namespace dapple::methods::adaptive_beams
