#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "closed_form/flat_scene.h"

/// One sinusoid under an overhead sun: the exact landing map X = x + (d + h) tan(delta) of rays refracted at
/// a cos kx gives the flux between the edges of any strip of the floor.
namespace dapple::test {

inline constexpr double kSinusoidIndex = 1.333;
inline constexpr double kSinusoidAmplitude = 0.01, kSinusoidLength = 0.5;   // m
inline constexpr double kSinusoidPatch = 3, kSinusoidView = 1;              // m, along the waves
inline const double kWaveNumber = 2 * glm::pi<double>() / kSinusoidLength;  // rad/m
/// Paraxial focus below a crest: n / ((n - 1) a k^2) = 2.54 m.
inline const double kSinusoidFocus =
    kSinusoidIndex / ((kSinusoidIndex - 1) * kSinusoidAmplitude * kWaveNumber * kWaveNumber);

/// Irradiance, mean over each pixel's strip, for a sun of unit irradiance: rays 3 um apart on the whole
/// patch, the flux between two neighbours spread evenly between their landing points.
inline std::vector<double> sinusoid_irradiance(double depth, int pixels) {
    constexpr int rays = 1000000;
    const double pixel = kSinusoidView / pixels;
    std::vector<double> flux(static_cast<std::size_t>(pixels), 0);
    double previous_landing = 0;
    for (int i = 0; i <= rays; ++i) {
        const double x = kSinusoidPatch * (static_cast<double>(i) / rays - 0.5);
        const double height = kSinusoidAmplitude * std::cos(kWaveNumber * x);
        const double tilt = std::atan(-kSinusoidAmplitude * kWaveNumber * std::sin(kWaveNumber * x));
        const double inside = std::asin(std::sin(tilt) / kSinusoidIndex);
        const double landing = x + (depth + height) * std::tan(tilt - inside);
        // Fresnel at angle `tilt`; near 0 the sine form is 0 / 0 and the normal value holds to 1e-9.
        double transmittance = 1 - std::pow((kSinusoidIndex - 1) / (kSinusoidIndex + 1), 2);
        if (std::abs(tilt) > 1e-4) {
            const double s = std::sin(tilt - inside) / std::sin(tilt + inside);
            const double p = std::tan(tilt - inside) / std::tan(tilt + inside);
            transmittance = 1 - 0.5 * (s * s + p * p);
        }
        if (i > 0) {
            const double low = std::min(landing, previous_landing),
                         high = std::max(landing, previous_landing);
            const double carried = transmittance * kSinusoidPatch / rays;
            const int first = std::max(0, static_cast<int>(std::floor((low + 0.5 * kSinusoidView) / pixel)));
            const int last =
                std::min(pixels - 1, static_cast<int>(std::floor((high + 0.5 * kSinusoidView) / pixel)));
            for (int column = first; column <= last; ++column) {
                const double left = column * pixel - 0.5 * kSinusoidView;
                const double overlap = std::min(high, left + pixel) - std::max(low, left);
                flux[static_cast<std::size_t>(column)] +=
                    high > low ? carried * std::max(0.0, overlap) / (high - low) : carried;
            }
        }
        previous_landing = landing;
    }
    for (double& value : flux) value /= pixel;
    return flux;
}

/// The scene of it: `pixels` along the waves, `rows` across them.
inline scene::FrameState sinusoid_pool(double depth, int pixels, int rows) {
    scene::FrameState state = pool_over_floor(kSinusoidPatch, depth, 0, pixels);
    state.clip.height = rows;
    state.camera.view_height = kSinusoidView * rows / pixels;
    state.water->extent.size = {kSinusoidPatch, 0.25};
    state.water->absorption = glm::dvec3(0);
    state.water->mesh_cells = 1500;  // 2 mm: the mesh's own error is far below the photons'
    state.water->surface.waves.waves = {{kSinusoidLength, 0, kSinusoidAmplitude, 0}};
    state.lights = {sun_from_zenith(0)};
    state.lights[0].irradiance = glm::dvec3(1);
    return state;
}

/// Relative L1 error of E.R of a picture of the pool; `matched`: once its mean has been made the exact one.
inline double sinusoid_error(const std::vector<float>& landed, double depth, int pixels,
                             bool matched = false) {
    const std::vector<double> exact = sinusoid_irradiance(depth, pixels);
    double error = 0, sum = 0, landed_sum = 0;
    for (std::size_t i = 0; i < landed.size(); ++i) {
        sum += exact[i % exact.size()];
        landed_sum += static_cast<double>(landed[i]);
    }
    const double scale = matched ? sum / landed_sum : 1;
    for (std::size_t i = 0; i < landed.size(); ++i)
        error += std::abs(scale * static_cast<double>(landed[i]) - exact[i % exact.size()]);
    return error / sum;
}

}  // namespace dapple::test
