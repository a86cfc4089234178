#include "methods/reference/round_estimate.h"

#include <algorithm>
#include <cmath>

namespace dapple::reference {

void RoundEstimate::start(std::uint64_t strata_a_pass, std::size_t values) {
    strata = strata_a_pass;
    passes = 0;
    extinguished = false;
    mean.assign(values, glm::dvec3(0));
    deviation.assign(values, glm::dvec3(0));
}

void RoundEstimate::add_pass(const std::vector<glm::dvec3>& values) {
    ++passes;
    for (std::size_t i = 0; i < mean.size(); ++i) {
        const glm::dvec3 before = values[i] - mean[i];
        mean[i] += before / static_cast<double>(passes);
        deviation[i] += before * (values[i] - mean[i]);
    }
}

glm::dvec3 RoundEstimate::variance(std::size_t value) const {
    return deviation[value] / static_cast<double>((passes - 1) * passes);
}

double RoundEstimate::relative_error(std::size_t first) const {
    double error = 0, sum = 0;
    for (std::size_t i = first; i < mean.size(); ++i) {
        const glm::dvec3 standard_error = glm::sqrt(variance(i));
        error += standard_error.x + standard_error.y + standard_error.z;
        sum += mean[i].x + mean[i].y + mean[i].z;
    }
    if (sum > 0) return error / sum;
    return extinguished ? 1 : 0;
}

void RoundEstimate::end_round(std::size_t first, std::uint64_t rays_a_pass, double exponent,
                              const scene::ReferenceParameters& parameters) {
    rays += kPasses * rays_a_pass;
    const double error = relative_error(first);
    const double most = 1e6 * parameters.most_rays;
    const double left = std::floor((most - static_cast<double>(rays)) / static_cast<double>(kPasses));
    const auto before = static_cast<double>(strata);
    // Doublings, so that layers that need about the same share their passes.
    const double wanted = std::pow(error / parameters.standard_error, exponent);
    const double next =
        std::min(left, before * std::exp2(std::clamp(std::ceil(std::log2(wanted)), 1.0, 6.0)));
    done = error <= parameters.standard_error || next < 1.5 * before;
    if (!done) start(static_cast<std::uint64_t>(next), mean.size());
}

}  // namespace dapple::reference
