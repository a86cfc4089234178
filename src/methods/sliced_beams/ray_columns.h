#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "light/water_beams.h"
#include "media/media.h"
#include "methods/sliced_beams/column_spans.h"
#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// Columns of the bounded media along the rays of a sheet after the water, made once a frame for the rays
/// that may meet one: points as fine as each medium's column needs, interpolated linearly along the ray and
/// between the rays of a beam. Beams whose rays meet much unlike columns have a fourth ray in their middle;
/// where that too would blur the face of a dense medium, and where so many points would be needed that they
/// do not fit, the mean ray is asked itself. Sheet and beams must outlive it.
template <class Real>
class RayColumns {
public:
    RayColumns() = default;
    /// `beams`: each by three rays of the sheet.
    RayColumns(std::shared_ptr<const media::Media> media, const light::BeamSheet<Real>& sheet,
               std::span<const glm::uvec3> beams);

    bool empty() const { return first_.empty(); }
    /// Whether a beam's rays are dimmed by more than the water.
    bool dims(std::size_t beam) const {
        if (empty()) return false;
        const glm::uvec3& rays = beams_[beam];
        return first_[rays.x] != kNone || first_[rays.y] != kNone || first_[rays.z] != kNone;
    }
    /// Optical depth of the bounded media, a channel, along a mean of a beam's three rays, down to a depth
    /// along the axis from where each leaves the water. `shift`, m a m of depth: how far the rays are turned
    /// from the sheet's towards a point of the sun's disc.
    glm::dvec3 optical_depth(std::size_t beam, const glm::dvec3& weights, double depth,
                             glm::dvec2 shift = {0, 0}) const;
    /// Adds it in each lane of `mask`.
    void add_optical_depth(std::size_t beam, const Lanes<float> (&weights)[3], const Lanes<float>& depth,
                           glm::dvec2 shift, const Mask<float>& mask, Lanes<float> (&sum)[3]) const;
    /// Rays, with those in the middles of beams, of which some medium's column has more detail than there is
    /// room for points.
    std::size_t coarse_rays() const { return coarse_rays_; }
    /// At most: with a ray in the middle of each of two beams.
    static double bytes(double rays, std::size_t media) {
        const double entries = 3 * rays, spans = entries * static_cast<double>(media);
        const double points = std::max(kMostPoints * spans / 3, double{kPlenty}) +
                              std::max(kMostPoints * spans * 2 / 3, double{kPlenty});
        return entries * sizeof(std::uint32_t) + spans * sizeof(ColumnSpan) + points * sizeof(float);
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::size_t kMostPoints = 128;  ///< of a medium, in the mean of all rays, or kPlenty
    static constexpr std::size_t kPlenty = 1 << 22;

    struct MeanRay {
        glm::dvec3 origin, slope;  ///< in the sheet's axes, from the water
    };
    MeanRay mean_ray(std::size_t beam, const glm::dvec3& weights) const;
    media::DensityProfile profile(const MeanRay& ray) const;
    /// Adds an entry for each index at which there is not kNone, of `ray_of(index)`, and sets it there.
    template <class RayOf>
    void add_entries(std::vector<std::uint32_t>& entries, RayOf&& ray_of);
    /// Adds those of the beams whose rays' columns are too unlike.
    void find_middles();
    glm::dvec3 exact_depth(std::size_t beam, const glm::dvec3& weights, double depth, glm::dvec2 shift) const;

    /// Of the columns in some entries: in the densest channel the least and the greatest, in the clearest the
    /// least.
    struct Spread {
        Lanes<float> first = splat(std::numeric_limits<float>::infinity()), last{}, clearest = first;
        Mask<float> coarse{};  ///< the points do not tell one of them
        void take(const Lanes<float>& densest_here, const Lanes<float>& clearest_here,
                  const Mask<float>& counts);
        Mask<float> unlike() const;
    };
    /// Adds `weight` times the column in an entry, down to a depth.
    void add_entry(std::uint32_t first, const Lanes<float>& depth, const Lanes<float>& weight,
                   const Mask<float>& counts, Spread& spread, Lanes<float> (&sum)[3]) const;

    std::shared_ptr<const media::Media> bodies_;
    const light::BeamSheet<Real>* sheet_ = nullptr;
    std::span<const glm::uvec3> beams_;
    std::size_t media_ = 0;              ///< bounded ones
    std::vector<glm::vec3> extinction_;  ///< /m, of each where its density is 1
    std::vector<float> least_, most_;    ///< that of its channels
    std::vector<std::uint32_t> first_;   ///< a vertex: its entry, or kNone
    std::vector<std::uint32_t> middle_;  ///< a beam: that of its mean ray, or kNone
    std::vector<ColumnSpan> spans_;      ///< [entry * media_ + medium]
    std::vector<float> columns_;         ///< m, the points of the spans
    std::size_t coarse_rays_ = 0;
};

extern template class RayColumns<float>;
extern template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
