#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "light/water_beams.h"
#include "media/media.h"

namespace dapple::methods::sliced_beams {

/// Columns of the bounded media along the rays of a sheet after the water, made once a frame for the rays
/// that may meet one: so many points a ray, interpolated linearly.
template <class Real>
class RayColumns {
public:
    RayColumns() = default;
    RayColumns(const media::Media& media, const light::BeamSheet<Real>& sheet);

    bool empty() const { return first_.empty(); }
    /// Whether a beam's rays are dimmed by more than the water.
    bool dims(const glm::uvec3& vertices) const {
        return !empty() &&
               (first_[vertices.x] != kNone || first_[vertices.y] != kNone || first_[vertices.z] != kNone);
    }
    /// Optical depth of the bounded media, a channel, along a mean of three rays, down to a depth along the
    /// axis from where each leaves the water.
    glm::dvec3 optical_depth(const glm::uvec3& vertices, const glm::dvec3& weights, double depth) const;
    static double bytes_a_ray(std::size_t media) {
        return sizeof(std::uint32_t) + sizeof(float) * static_cast<double>(2 + kPoints * media);
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::size_t kPoints = 48;

    std::size_t media_ = 0;               ///< bounded ones
    std::vector<glm::dvec3> extinction_;  ///< /m, of each where its density is 1
    std::vector<std::uint32_t> first_;    ///< a vertex: where its entry begins, or kNone
    std::vector<float> columns_;  ///< an entry: first depth from there, step, kPoints columns of each medium
};

extern template class RayColumns<float>;
extern template class RayColumns<double>;

}  // namespace dapple::methods::sliced_beams
