#include "methods/adaptive_beams/paper_beams.h"

#include <algorithm>
#include <cmath>

#include "methods/adaptive_beams/drawn_beams.h"

namespace dapple::methods::adaptive_beams {
namespace {

/// Of a ray with its caustic triangle's plane.
constexpr double kLeastSine = 1e-3;

/// False where the beam has no sections.
bool fill(const BeamSet& set, std::size_t i, layout::PaperBeam& beam) {
    glm::dvec3 base[3], along[3];
    double way[3];  // m of depth
    for (int k = 0; k < 3; ++k) {
        const BeamSet::Vertex& v = set.vertices[set.triangles[i][k]];
        along[k] = {v.slope_a, v.slope_b, 1};
        base[k] = glm::dvec3(v.a, v.b, 0) + static_cast<double>(v.start) * along[k];
        way[k] = static_cast<double>(v.end) - static_cast<double>(v.start);
    }
    glm::dvec3 normal = glm::cross(base[1] - base[0], base[2] - base[0]);
    const double size = glm::length(normal);
    if (!(size > 0)) return false;
    normal *= (glm::dot(normal, along[0]) < 0 ? -1 : 1) / size;
    for (int k = 0; k < 3; ++k) {
        const double rise = glm::dot(normal, along[k]);
        if (!(rise > kLeastSine * glm::length(along[k]))) return false;
        beam.end[k] = static_cast<float>(way[k] * rise);
        along[k] /= rise;
        beam.base[k] = base[k];
        beam.along[k] = along[k];
    }
    const glm::dvec3 p = base[1] - base[0], q = base[2] - base[0], s = along[1] - along[0],
                     t = along[2] - along[0];
    beam.normal = normal;
    beam.area = 0.5 * glm::dvec3(glm::dot(normal, glm::cross(p, q)),
                                 glm::dot(normal, glm::cross(p, t) + glm::cross(s, q)),
                                 glm::dot(normal, glm::cross(s, t)));
    beam.flux = set.flux[i];
    beam.bias = static_cast<float>(kLeastBias + kBiasOfWidth * std::sqrt(size));
    return true;
}

}  // namespace

PaperBeams paper_beams(const BeamSet& set) {
    PaperBeams result;
    result.beams.resize(set.triangles.size());
    for (std::size_t i = 0; i < set.triangles.size(); ++i) {
        if (fill(set, i, result.beams[i])) continue;
        result.beams[i] = {};
        ++result.lost;
    }
    return result;
}

}  // namespace dapple::methods::adaptive_beams
