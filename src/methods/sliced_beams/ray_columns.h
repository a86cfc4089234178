#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "light/water_beams.h"
#include "media/media.h"

namespace dapple::methods::sliced_beams {

/// Columns of the bounded media along the rays of a sheet after the water, made once a frame for the rays
/// that may meet one: so many points a ray, interpolated linearly. Where that would blur the face of a dense
/// medium the mean ray is asked itself. The sheet must outlive it.
template <class Real>
class RayColumns {
public:
    RayColumns() = default;
    RayColumns(std::shared_ptr<const media::Media> media, const light::BeamSheet<Real>& sheet);

    bool empty() const { return first_.empty(); }
    /// Whether a beam's rays are dimmed by more than the water.
    bool dims(const glm::uvec3& vertices) const {
        return !empty() &&
               (first_[vertices.x] != kNone || first_[vertices.y] != kNone || first_[vertices.z] != kNone);
    }
    /// Optical depth of the bounded media, a channel, along a mean of three rays, down to a depth along the
    /// axis from where each leaves the water. `shift`, m a m of depth: how far the rays are turned from the
    /// sheet's towards a point of the sun's disc.
    glm::dvec3 optical_depth(const glm::uvec3& vertices, const glm::dvec3& weights, double depth,
                             glm::dvec2 shift = {0, 0}) const;
    static double bytes_a_ray(std::size_t media) {
        return sizeof(std::uint32_t) + sizeof(float) * static_cast<double>(2 + kPoints * media);
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::size_t kPoints = 48;

    glm::dvec3 exact_depth(const glm::uvec3& vertices, const glm::dvec3& weights, double depth,
                           glm::dvec2 shift) const;

    std::shared_ptr<const media::Media> bodies_;
    const light::BeamSheet<Real>* sheet_ = nullptr;
    std::size_t media_ = 0;               ///< bounded ones
    std::vector<glm::dvec3> extinction_;  ///< /m, of each where its density is 1
    std::vector<double> least_, most_;    ///< that of its channels
    std::vector<std::uint32_t> first_;    ///< a vertex: where its entry begins, or kNone
    std::vector<float> columns_;  ///< an entry: first depth from there, step, kPoints columns of each medium
};

extern template class RayColumns<float>;
extern template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
