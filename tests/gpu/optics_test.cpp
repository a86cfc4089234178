// The physics headers as the device runs them, against the same text in C++.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "base/hash.h"
#include "gpu/pass_list.h"
#include "gpu/validated_device.h"
#include "optics/optics.h"
#include "spirv/test_phase_comp.h"
#include "spirv/test_refraction_comp.h"

namespace dapple::gpu {
namespace {

using glm::vec3;
using uint = std::uint32_t;
#include "test/phase_case.h"
#include "test/refraction_case.h"

static_assert(sizeof(PhaseInput) == 16 && sizeof(PhaseOutput) == 20);
static_assert(sizeof(RefractionInput) == 28 && sizeof(RefractionOutput) == 40);

std::vector<RefractionInput> inputs() {
    constexpr float kWater = 1.333f;
    std::vector<RefractionInput> result;
    const auto add = [&result](glm::dvec3 normal, double cos_i, double turn, float eta) {
        const glm::dvec3 side = glm::normalize(
            glm::cross(normal, std::abs(normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
        const glm::dvec3 tangent = std::cos(turn) * side + std::sin(turn) * glm::cross(normal, side);
        const glm::dvec3 incident = std::sqrt(std::max(0.0, 1 - cos_i * cos_i)) * tangent - cos_i * normal;
        RefractionInput input{vec3(incident), vec3(normal), eta};
        if (glm::dot(input.incident, input.normal) > 0)
            input.normal = -input.normal;  // rounding at grazing incidence
        result.push_back(input);
    };
    // Straight on, grazing, and at and about the critical angle, both ways through the surface, and with no
    // change.
    for (const float eta : {1 / kWater, kWater, 1.0f})
        for (const glm::dvec3 normal : {glm::dvec3(0, 1, 0), glm::normalize(glm::dvec3(0.1, 1, -0.2))}) {
            for (const double cos_i : {1.0, 1 - 1e-7, 0.5, 1e-3, 1e-6, 0.0}) add(normal, cos_i, 0.3, eta);
            if (eta > 1)
                for (const double step : {-1e-3, -1e-6, 1e-6, 1e-3})
                    add(normal, std::sqrt(1 - 1 / (double{eta} * eta)) + step, 0.3, eta);
        }
    for (std::uint64_t i = 0; i < 100'000; ++i) {
        const auto random = [i](std::uint32_t dimension) { return hash_uniform(7, 0, i, dimension); };
        const double y = 2 * random(0) - 1;
        const double angle = 2 * M_PI * random(1);
        const double ring = std::sqrt(1 - y * y);
        const float eta = i % 2 == 0 ? kWater : 1 / kWater;
        add({ring * std::cos(angle), y, ring * std::sin(angle)}, random(2), 2 * M_PI * random(3), eta);
    }
    return result;
}

float largest(vec3 v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// What a shader of one input and one output an invocation makes of the inputs.
template <class Output, class Input>
std::vector<Output> on_the_device(const char* name, std::span<const std::uint32_t> shader,
                                  const std::vector<Input>& given) {
    Device& device = test::validated_device();
    Buffer in(device, "inputs", given.size() * sizeof(Input));
    Buffer out(device, "outputs", given.size() * sizeof(Output));
    std::copy(given.begin(), given.end(), in.as<Input>().begin());
    const ComputePipeline pipeline(device, name, shader, {.storage_buffers = 2, .push_bytes = 4});
    Bindings bindings{.buffers = {&in, &out}, .writes = {&out}};
    const auto count = static_cast<std::uint32_t>(given.size());
    bindings.set_push(count);
    PassList passes(device);
    FrameStats stats;
    passes.compute(name, pipeline, bindings, {(count + 63) / 64, 1, 1});
    passes.run(stats);
    const std::span<const Output> results = out.as<Output>();
    return {results.begin(), results.end()};
}

TEST(OpticsOnTheDevice, AgreesWithCpp) {
    namespace cpp = optics::f32;
    const std::vector<RefractionInput> given = inputs();
    const auto out = on_the_device<RefractionOutput>("refraction", test_refraction_comp, given);

    // Additions, products and roots of IEEE arithmetic in the same order give the same values everywhere. A
    // device may contract a product and a sum, and divide and take roots within 2.5 and 3 ulp (Vulkan,
    // precision of operations): then values of about 1 part by some units of 2^-24. Only where the sine of
    // the refracted angle rounds to 1 may the two disagree about total reflection.
    constexpr float kUnit = 0x1p-24f;
    constexpr float kValue = 16 * kUnit;
    int total_reflections = 0;
    for (std::size_t i = 0; i < given.size(); ++i) {
        const RefractionInput& input = given[i];
        const RefractionOutput& result = out[i];
        const double cosine = glm::dot(glm::dvec3(input.incident), glm::dvec3(input.normal));
        const double sin_t = double{input.eta} * std::sqrt((1 - cosine) * (1 + cosine));
        vec3 refracted;
        const bool transmitted = cpp::refracted_direction(input.incident, input.normal, input.eta, refracted);
        if (std::abs(sin_t - 1) < kValue) continue;
        ASSERT_EQ(transmitted, result.transmitted != 0) << i;
        total_reflections += transmitted ? 0 : 1;

        // Roots of small numbers are known less well: d(cos_t) = sin_t d(sin_t) / cos_t.
        const float cos_i = -glm::dot(input.incident, input.normal);
        const float cos_t = cpp::transmitted_cosine(cos_i, input.eta);
        const float near_critical = cos_t > 0 ? std::max(1.0f, 1 / cos_t) : 1.0f;
        ASSERT_NEAR(result.cos_t, cos_t, kValue * near_critical) << i;
        if (transmitted) {
            ASSERT_LT(largest(result.refracted - refracted), kValue * near_critical) << i;
        }
        ASSERT_LT(largest(result.reflected - cpp::reflected_direction(input.incident, input.normal)), kValue)
            << i;
        ASSERT_NEAR(result.reflectance, cpp::fresnel_reflectance(cos_i, cos_t, input.eta),
                    kValue * near_critical)
            << i;
        ASSERT_NEAR(result.transmittance, cpp::fresnel_transmittance(cos_i, cos_t, input.eta),
                    kValue * near_critical)
            << i;
    }
    EXPECT_GT(total_reflections, 1000);  // the inputs do reach that branch
}

TEST(OpticsOnTheDevice, PhaseFunctionsAgreeWithCpp) {
    namespace cpp = optics::f32;
    std::vector<PhaseInput> given;
    for (const vec3 kind :
         {vec3(0, 1.1, 3.5835), vec3(0.9, 1.02, 3.3), vec3(-0.7, 1.2, 4.5), vec3(0.5, 1.35, 3.1)})
        for (int i = 0; i <= 2000; ++i)
            given.push_back({static_cast<float>(std::cos(M_PI * i / 2000)), kind.x, kind.y, kind.z});
    const auto out = on_the_device<PhaseOutput>("phase", test_phase_comp, given);

    float lobes = 0, ocean = 0, within = 0;
    for (std::size_t i = 0; i < given.size(); ++i) {
        const PhaseInput& input = given[i];
        const PhaseOutput& result = out[i];
        const auto apart = [](float a, float b) { return std::abs(a / b - 1); };
        ASSERT_EQ(result.isotropic, cpp::isotropic_phase());
        lobes = std::max(
            {lobes, apart(result.henyey_greenstein, cpp::henyey_greenstein_phase(input.cosine, input.g)),
             apart(result.two_lobe, cpp::two_lobe_phase(input.cosine, input.g, -0.4f, 0.7f))});
        ocean = std::max(ocean, apart(result.fournier_forand,
                                      cpp::fournier_forand_phase(input.cosine, input.index, input.slope)));
        within =
            std::max(within, std::abs(result.within - cpp::fournier_forand_within(0.5f - 0.5f * input.cosine,
                                                                                  input.index, input.slope)));
    }
    // A root and a division of 3 and 2.5 ulp; powers are known to some ulp times their exponents, up to 26 /
    // 2, and where 1 - delta^nu is small, 0.05 at the ends of the series, to twenty times as much.
    EXPECT_LT(lobes, 1e-6);
    EXPECT_LT(ocean, 5e-4);
    EXPECT_LT(within, 1e-4);
}

}  // namespace
}  // namespace dapple::gpu
