#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "methods/adaptive_beams/beam_set.h"

namespace dapple::methods::adaptive_beams {

/// q.x + q.y u + q.z u^2 with u = depth - middle.
struct AreaFunction {
    glm::dvec3 q{0};    ///< m^2, m, 1
    double middle = 0;  ///< m

    double at(double depth) const {
        const double u = depth - middle;
        return q.x + u * (q.y + u * q.z);
    }
    /// The same function about another depth.
    AreaFunction about(double depth) const;
    /// The same about that end of a range or that extremum in it, rounded to float, where |A| is least.
    /// Floats then keep the small areas about a focus; far from there they would be differences of large
    /// numbers.
    AreaFunction about_least(double from, double to) const;
};

/// Signed area of a triangle of rays on the planes of constant depth, about `middle`.
AreaFunction area_function(const BeamSet& set, const glm::uvec3& triangle, double middle);

/// The triangles about each vertex (its ring): the sum of their areas |A_k(depth)| and of their flux. Areas
/// that keep their sign between the first start and the last end of the ring are summed up in one function;
/// the others, which pass a focus there, are listed.
struct RingAreas {
    std::vector<AreaFunction> even;      ///< a vertex, about the depth where it is least
    std::vector<glm::dvec3> flux;        ///< a vertex, W
    std::vector<std::uint32_t> first;    ///< vertices + 1, into `turning`
    std::vector<std::uint32_t> turning;  ///< triangles of the set, ascending in each ring

    explicit RingAreas(const BeamSet& set);
    /// m^2 at a depth.
    double area(const BeamSet& set, std::size_t vertex, double depth) const;
};

}  // namespace dapple::methods::adaptive_beams
