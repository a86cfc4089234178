#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/hash.h"
#include "optics/optics.h"

namespace dapple::optics {
namespace {

constexpr double kUlp = 0x1p-24;  // half the spacing of floats in [1, 2): the unit of round-off
constexpr std::uint64_t kRandom = 1000000;

double uniform(std::uint64_t index, std::uint32_t dimension) {
    return hash_uniform(11, 0, index, dimension);
}

/// |a - b| in units in the last place of the float nearest to b.
double ulps(float a, double b) {
    const auto nearest = static_cast<float>(b);
    const double spacing =
        static_cast<double>(std::nextafter(std::abs(nearest), INFINITY)) - std::abs(nearest);
    return std::abs(static_cast<double>(a) - b) / spacing;
}

std::vector<float> special_indices() {
    return {static_cast<float>(1 / 1.333), 1.333f,  1.0f,     1.5f,
            static_cast<float>(1 / 1.5),   1.0001f, 0.9999f,  std::nextafter(1.0f, 2.0f),
            std::nextafter(1.0f, 0.0f),    2.42f,   1 / 2.42f};
}

std::vector<float> special_cosines(float eta) {
    std::vector<float> cosines{
        0.0f,  1e-30f, 1e-10f, 1e-7f, 3e-7f, 1e-6f, 1e-5f,   1e-4f,
        1e-3f, 0.01f,  0.1f,   0.5f,  0.9f,  0.99f, 0.9999f, std::nextafter(1.0f, 0.0f),
        1.0f};
    if (eta > 1) {  // about the critical angle
        auto critical = static_cast<float>(std::sqrt(1 - 1 / (static_cast<double>(eta) * eta)));
        for (int i = 0; i < 4; ++i) critical = std::nextafter(critical, 0.0f);
        for (int i = 0; i < 9; ++i, critical = std::nextafter(critical, 1.0f)) cosines.push_back(critical);
    }
    const double brewster = 1 / std::sqrt(1 + 1 / (static_cast<double>(eta) * eta));
    cosines.push_back(static_cast<float>(brewster));
    return cosines;
}

struct Worst {
    double reflectance = 0;
    double transmittance = 0;
    double sum = 0;
};

/// Float against double, from the same cosines; the double version is the same text, so what is seen is
/// round-off.
void compare(float cos_i, float cos_t, float eta, Worst& worst) {
    const float r = f32::fresnel_reflectance(cos_i, cos_t, eta);
    const float t = f32::fresnel_transmittance(cos_i, cos_t, eta);
    ASSERT_TRUE(std::isfinite(r) && std::isfinite(t)) << cos_i << " " << cos_t << " " << eta;
    ASSERT_TRUE(r >= 0 && r <= 1 && t >= 0 && t <= 1) << cos_i << " " << cos_t << " " << eta;
    worst.reflectance = std::max(worst.reflectance, ulps(r, f64::fresnel_reflectance(cos_i, cos_t, eta)));
    worst.transmittance =
        std::max(worst.transmittance, ulps(t, f64::fresnel_transmittance(cos_i, cos_t, eta)));
    const double exact_t = f64::transmitted_cosine(cos_i, eta);
    worst.sum = std::max(worst.sum, std::abs(f64::fresnel_reflectance(cos_i, exact_t, eta) +
                                             f64::fresnel_transmittance(cos_i, exact_t, eta) - 1));
}

TEST(Refraction, FresnelInFloatIsWithinEightUlpFromGivenCosines) {
    Worst worst;
    for (const float eta : special_indices()) {
        for (const float cos_i : special_cosines(eta)) {
            compare(cos_i, f32::transmitted_cosine(cos_i, eta), eta, worst);
        }
    }
    for (std::uint64_t i = 0; i < kRandom; ++i) {
        const float n = static_cast<float>(1 + 1.5 * uniform(i, 0));
        const float eta = i % 2 == 0 ? n : 1 / n;
        float cos_i = static_cast<float>(uniform(i, 1));
        if (i % 3 == 0) cos_i = static_cast<float>(std::pow(10.0, -8 * uniform(i, 1)));  // towards grazing
        compare(cos_i, f32::transmitted_cosine(cos_i, eta), eta, worst);
    }
    RecordProperty("reflectance_ulp", std::to_string(worst.reflectance));
    RecordProperty("transmittance_ulp", std::to_string(worst.transmittance));
    EXPECT_LE(worst.reflectance, 8);
    EXPECT_LE(worst.transmittance, 8);
    // Some ten operations of 2^-53 each.
    EXPECT_LE(worst.sum, 16 * 0x1p-53);
}

TEST(Refraction, ReflectanceIsTheTextbookQuotient) {
    // The text of Born & Wolf, whose differences are harmless in double at these indices.
    for (const double eta : {1 / 1.333, 1.333, 1.5}) {
        for (double angle = 0; angle < 1.57; angle += 0.01) {
            const double cos_i = std::cos(angle);
            const double square = 1 - eta * eta * std::pow(std::sin(angle), 2);
            if (square < 0) {
                EXPECT_EQ(f64::transmitted_cosine(cos_i, eta), -1);
                EXPECT_EQ(f64::fresnel_reflectance(cos_i, -1.0, eta), 1);
                EXPECT_EQ(f64::fresnel_transmittance(cos_i, -1.0, eta), 0);
                continue;
            }
            const double cos_t = std::sqrt(square);
            const double s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
            const double p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
            EXPECT_NEAR(f64::transmitted_cosine(cos_i, eta), cos_t, 1e-14 / cos_t);
            EXPECT_NEAR(f64::fresnel_reflectance(cos_i, cos_t, eta), (s * s + p * p) / 2, 1e-13);
        }
    }
    // At normal incidence ((n - 1) / (n + 1))^2, from both sides.
    const double normal = std::pow(0.333 / 2.333, 2);
    EXPECT_NEAR(f64::fresnel_reflectance(1.0, 1.0, 1.333), normal, 1e-16);
    EXPECT_NEAR(f64::fresnel_reflectance(1.0, 1.0, 1 / 1.333), normal, 1e-16);
    // 85 degrees from air into water: 0.584, where Schlick's approximation says 0.641.
    const double cos_i = std::cos(85 * M_PI / 180);
    EXPECT_NEAR(f64::fresnel_reflectance(cos_i, f64::transmitted_cosine(cos_i, 1 / 1.333), 1 / 1.333), 0.584,
                5e-4);
}

TEST(Refraction, DirectionFromAirIsWithinFourRoundoffs) {
    double worst = 0;
    double worst_snell = 0;
    const auto check = [&](const glm::vec3& incident, const glm::vec3& normal, float eta) {
        glm::vec3 in_float;
        glm::dvec3 in_double;
        ASSERT_TRUE(f32::refracted_direction(incident, normal, eta, in_float));
        ASSERT_TRUE(f64::refracted_direction(glm::dvec3(incident), glm::dvec3(normal), eta, in_double));
        const glm::dvec3 error = glm::abs(glm::dvec3(in_float) - in_double);
        ASSERT_TRUE(error.x + error.y + error.z < 1);
        worst = std::max({worst, error.x, error.y, error.z});
        // Snell's law itself: tangential parts are in the ratio of the indices.
        const glm::dvec3 i(incident);
        const glm::dvec3 n(normal);
        const glm::dvec3 tangent =
            static_cast<double>(eta) * (i - dot(i, n) * n) - (in_double - dot(in_double, n) * n);
        worst_snell = std::max(worst_snell, length(tangent));
    };
    const auto water = static_cast<float>(1 / 1.333);
    for (std::uint64_t i = 0; i < kRandom; ++i) {
        const double azimuth = 2 * M_PI * uniform(i, 0);
        const double tilt_azimuth = 2 * M_PI * uniform(i, 1);
        const double tilt = 0.6 * uniform(i, 2);
        const double cosine = i % 3 == 0 ? std::pow(10.0, -7 * uniform(i, 3)) : uniform(i, 3);
        const glm::vec3 normal(
            glm::normalize(glm::dvec3(std::sin(tilt) * std::cos(tilt_azimuth), std::cos(tilt),
                                      std::sin(tilt) * std::sin(tilt_azimuth))));
        const glm::dvec3 n(normal);
        const glm::dvec3 u = glm::normalize(glm::cross(n, glm::dvec3(1, 0, 0)));
        const glm::dvec3 v = glm::cross(n, u);
        const double sine = std::sqrt(1 - cosine * cosine);
        const glm::vec3 incident(
            glm::normalize(sine * (std::cos(azimuth) * u + std::sin(azimuth) * v) - cosine * n));
        if (glm::dot(incident, normal) > 0) continue;
        check(incident, normal, i % 4 == 0 ? static_cast<float>(1 / (1 + uniform(i, 4))) : water);
    }
    for (const float eta : {water, 1 / 1.5f, 1.0f, std::nextafter(1.0f, 0.0f)}) {
        for (const float cosine : special_cosines(eta)) {
            const auto sine = static_cast<float>(std::sqrt(1 - static_cast<double>(cosine) * cosine));
            check({sine, -cosine, 0}, {0, 1, 0}, eta);
        }
    }
    RecordProperty("direction_roundoffs", std::to_string(worst / kUlp));
    EXPECT_LE(worst, 4 * kUlp);
    // The normal in float is unit to 2^-24 only, which is what the tangential parts see.
    EXPECT_LE(worst_snell, 4 * kUlp);
}

TEST(Refraction, NoSpecialInputMakesNan) {
    for (const float eta : special_indices()) {
        for (const float cosine : special_cosines(eta)) {
            const auto sine = static_cast<float>(std::sqrt(1 - static_cast<double>(cosine) * cosine));
            for (const float side : {1.0f, -1.0f}) {  // also a normal on the wrong side
                glm::vec3 direction;
                const bool passes =
                    f32::refracted_direction({sine, -side * cosine, 0}, {0, 1, 0}, eta, direction);
                ASSERT_TRUE(std::isfinite(direction.x + direction.y + direction.z));
                if (passes && side > 0) {
                    // Length: 1 to a few round-offs, amplified at the critical angle, where cos_t is a square
                    // root of what is left of 1.
                    EXPECT_NEAR(glm::length(direction), 1, 1e-6);
                }
                const glm::vec3 mirrored = f32::reflected_direction({sine, -side * cosine, 0}, {0, 1, 0});
                EXPECT_EQ(mirrored, glm::vec3(sine, side * cosine, 0));
            }
        }
    }
}

TEST(Refraction, ExactlyCriticalGoesAlongTheSurface) {
    // eta = 1.25: sin = 0.8 and cos = 0.6; neither is a float or a double, so take the double next above 0.6.
    const double cosine = std::nextafter(0.6, 1.0);
    const double cos_t = f64::transmitted_cosine(cosine, 1.25);
    EXPECT_GE(cos_t, 0);
    EXPECT_LT(cos_t, 1e-7);
    EXPECT_NEAR(f64::fresnel_reflectance(cosine, cos_t, 1.25), 1, 1e-6);
    EXPECT_EQ(f64::transmitted_cosine(0.599, 1.25), -1);
}

}  // namespace
}  // namespace dapple::optics
