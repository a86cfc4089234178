#include <gtest/gtest.h>

#include <cmath>

#include "base/hash.h"
#include "optics/optics.h"

namespace dapple::optics::f64 {
namespace {

double uniform(std::uint64_t index, std::uint32_t dimension) {
    return 2 * hash_uniform(5, 0, index, dimension) - 1;
}
glm::dvec3 vector(std::uint64_t index, std::uint32_t dimension) {
    return {uniform(index, dimension), uniform(index, dimension + 1), uniform(index, dimension + 2)};
}

/// A ray and a normal that depend on one parameter; the differentials are compared with central differences
/// of step 1e-5, whose error is about 1e-10 of third derivatives of order 1 and 2^-53 / 1e-5 of round-off.
struct Family {
    std::uint64_t index;
    glm::dvec3 direction(double s) const {
        return normalize(glm::dvec3(0, -1, 0) + 0.5 * vector(index, 0) + s * vector(index, 3));
    }
    glm::dvec3 direction_differential() const {
        return normalized_differential(glm::dvec3(0, -1, 0) + 0.5 * vector(index, 0), vector(index, 3));
    }
    glm::dvec3 normal(double s) const {
        return normalize(glm::dvec3(0, 1, 0) + 0.2 * vector(index, 6) + s * vector(index, 9));
    }
    glm::dvec3 normal_differential() const {
        return normalized_differential(glm::dvec3(0, 1, 0) + 0.2 * vector(index, 6), vector(index, 9));
    }
    glm::dvec3 origin(double s) const { return vector(index, 12) + s * vector(index, 15); }
};

constexpr double kStep = 1e-5;

template <typename Function>
glm::dvec3 difference(const Function& f) {
    return (f(kStep) - f(-kStep)) / (2 * kStep);
}

TEST(RayDifferential, MatchesDifferencesOfTheRaysThemselves) {
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const Family family{i};
        const glm::dvec3 direction = family.direction(0);
        const glm::dvec3 normal = family.normal(0);
        const glm::dvec3 dd = family.direction_differential();
        const glm::dvec3 dn = family.normal_differential();
        if (dot(direction, normal) > -0.2) continue;

        const glm::dvec3 mirrored =
            difference([&](double s) { return reflected_direction(family.direction(s), family.normal(s)); });
        EXPECT_LT(length(mirrored - reflected_differential(direction, normal, dd, dn)), 1e-7);

        for (const double eta : {1 / 1.333, 1.333, 1.0}) {
            const double cos_t = transmitted_cosine(-dot(direction, normal), eta);
            if (cos_t < 0.2) continue;  // the third derivative grows as the fifth power of 1 / cos_t
            const glm::dvec3 refracted = difference([&](double s) {
                glm::dvec3 result;
                refracted_direction(family.direction(s), family.normal(s), eta, result);
                return result;
            });
            EXPECT_LT(length(refracted - refracted_differential(direction, normal, eta, dd, dn)), 1e-6);
        }

        const auto landing = [&](double s) {  // on the plane y = -3
            const glm::dvec3 o = family.origin(s);
            const glm::dvec3 d = family.direction(s);
            return o + (-3 - o.y) / d.y * d;
        };
        const double distance = (-3 - family.origin(0).y) / direction.y;
        const glm::dvec3 moved = transferred_differential(vector(i, 15), dd, direction, distance, {0, 1, 0});
        EXPECT_LT(length(difference(landing) - moved), 1e-6);
        EXPECT_NEAR(moved.y, 0, 1e-12);
    }
}

}  // namespace
}  // namespace dapple::optics::f64
