#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

/// Snell's law and Fresnel's equations of the reference, written apart from shaders/optics on purpose: a
/// fault there must not be able to hide here. Born & Wolf, Principles of Optics, section 1.5.
namespace dapple::reference {

/// What becomes of unpolarised light at a smooth surface between two indices.
struct Split {
    glm::dvec3 refracted{0};   ///< unit; means nothing where `transmittance` is 0
    glm::dvec3 reflected{0};   ///< unit
    double transmittance = 0;  ///< shares of the power; 0 and 1 at total reflection
    double reflectance = 1;
};

/// `incident` is the unit direction of travel, `normal` is unit and faces it (incident . normal <= 0).
inline Split split(const glm::dvec3& incident, const glm::dvec3& normal, double index_from, double index_to) {
    Split result;
    const double cosine = std::clamp(-dot(incident, normal), 0.0, 1.0);
    result.reflected = normalize(incident + 2 * cosine * normal);
    // The tangential part of index * direction is the same on both sides.
    const glm::dvec3 tangential = (index_from / index_to) * (incident + cosine * normal);
    const double square = 1 - dot(tangential, tangential);
    if (square <= 0) return result;
    const double cosine_to = std::sqrt(square);
    result.refracted = normalize(tangential - cosine_to * normal);
    const double across = (index_from * cosine - index_to * cosine_to) /
                          (index_from * cosine + index_to * cosine_to);  // electric field across the plane
    const double within = (index_to * cosine - index_from * cosine_to) /
                          (index_to * cosine + index_from * cosine_to);  // within the plane of incidence
    result.reflectance = 0.5 * (across * across + within * within);
    result.transmittance = 1 - result.reflectance;
    return result;
}

inline double mean(const glm::dvec3& color) {
    return (color.x + color.y + color.z) / 3;
}

inline bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x + v.y + v.z);
}

/// A spot's intensity over that on its axis: 1 inside the inner cone, 0 outside the outer one, and the cubic
/// 3 x^2 - 2 x^3 of the cosine's place between the two.
inline double spot_share(double cosine, double cone_angle, double falloff_angle) {
    const double outer = std::cos(cone_angle);
    const double inner = std::cos(cone_angle - falloff_angle);
    if (cosine <= outer) return 0;
    if (cosine >= inner) return 1;
    const double x = (cosine - outer) / (inner - outer);
    return (3 - 2 * x) * x * x;
}

}  // namespace dapple::reference
