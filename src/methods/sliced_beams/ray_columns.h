#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "light/water_beams.h"
#include "media/media.h"
#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// Columns of the bounded media along the rays of a sheet after the water, made once a frame for the rays
/// that may meet one: so many points a ray, interpolated linearly between the rays of a beam. Beams whose
/// rays meet much unlike columns have a fourth ray in their middle; where that too would blur the face of a
/// dense medium the mean ray is asked itself. Sheet and beams must outlive it.
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
    /// At most: with a ray in the middle of each of two beams.
    static double bytes_a_ray(std::size_t media) {
        return 3 * (sizeof(std::uint32_t) + sizeof(float) * static_cast<double>(2 + kPoints * media));
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::size_t kPoints = 48;

    struct MeanRay {
        glm::dvec3 origin, slope;  ///< in the sheet's axes, from the water
    };
    MeanRay mean_ray(std::size_t beam, const glm::dvec3& weights) const;
    /// Fills an entry along a ray that is given by its slope in the sheet's axes.
    void fill(float* entry, const MeanRay& ray) const;
    /// Fills those of the beams whose rays' columns are too unlike.
    void find_middles();
    glm::dvec3 exact_depth(std::size_t beam, const glm::dvec3& weights, double depth, glm::dvec2 shift) const;

    /// Of the columns in some entries: in the densest channel the least and the greatest, in the clearest the
    /// least.
    struct Spread {
        Lanes<float> first = splat(std::numeric_limits<float>::infinity()), last{}, clearest = first;
        void take(const Lanes<float>& densest_here, const Lanes<float>& clearest_here,
                  const Mask<float>& counts);
        Mask<float> parted() const;
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
    std::vector<std::uint32_t> first_;   ///< a vertex: where its entry begins, or kNone
    std::vector<std::uint32_t> middle_;  ///< a beam: where that of its mean ray begins, or kNone
    std::vector<float> columns_;  ///< an entry: first depth from there, step, kPoints columns of each medium
};

extern template class RayColumns<float>;
extern template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
