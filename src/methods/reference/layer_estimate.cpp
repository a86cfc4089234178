#include "methods/reference/layer_estimate.h"

#include <cmath>

#include "view/camera.h"
#include "view/camera_paths.h"

namespace dapple::reference {

LayerCells layer_cells(const scene::FrameScene& scene, const rays::RayScene& rays,
                       const ReceiverCharts& charts, const view::ReceiverLayer& layer) {
    const view::Camera::SampleCell part = view::Camera::sample_cell(layer.sample, scene.state.clip.samples);
    LayerCells result;
    result.paths.assign(layer.pixels(), 0);
    std::vector<PathEnd> ends;
    ends.reserve(layer.pixels() * kPathsAcross * kPathsAcross);
    for (int row = 0; row < kPathsAcross; ++row) {
        for (int column = 0; column < kPathsAcross; ++column) {
            view::LayerRequest request{layer.sample, layer.branch};
            request.offset = part.corner + part.size * (glm::dvec2(column, row) + 0.5) / double{kPathsAcross};
            view::LayerCounts ignored;
            const view::ReceiverLayer sub = view::trace_layer(scene, rays, request, ignored);
            for (std::size_t pixel = 0; pixel < sub.pixels(); ++pixel) {
                constexpr std::uint32_t alike = view::kReceiver | view::kInWater;
                const bool counts = (layer.flags[pixel] & view::kReceiver) != 0 &&
                                    (sub.flags[pixel] & alike) == (layer.flags[pixel] & alike);
                if (!counts) continue;
                const ChartPlace place =
                    charts.place(sub.object[pixel], sub.primitive[pixel], glm::dvec3(sub.position[pixel]),
                                 glm::dvec3(sub.geometric_normal[pixel]));
                if (!(place.density > 0)) continue;
                ends.push_back({place.key, static_cast<std::uint32_t>(pixel)});
                ++result.paths[pixel];
            }
        }
    }
    result.cells = DepositCells(std::move(ends), charts.charts(), charts.digits());
    return result;
}

void RoundEstimate::start(std::uint64_t strata_a_pass, std::size_t pixels) {
    strata = strata_a_pass;
    passes = 0;
    mean.assign(pixels, glm::dvec3(0));
    deviation.assign(pixels, glm::dvec3(0));
}

void RoundEstimate::add_pass(const std::vector<glm::dvec3>& irradiance) {
    ++passes;
    for (std::size_t i = 0; i < mean.size(); ++i) {
        const glm::dvec3 before = irradiance[i] - mean[i];
        mean[i] += before / static_cast<double>(passes);
        deviation[i] += before * (irradiance[i] - mean[i]);
    }
}

glm::dvec3 RoundEstimate::variance(std::size_t pixel) const {
    return deviation[pixel] / static_cast<double>((passes - 1) * passes);
}

double RoundEstimate::relative_error(const std::vector<std::uint16_t>& paths) const {
    double error = 0, sum = 0;
    for (std::size_t i = 0; i < mean.size(); ++i) {
        if (paths[i] == 0) continue;
        const glm::dvec3 standard_error = glm::sqrt(variance(i));
        error += standard_error.x + standard_error.y + standard_error.z;
        sum += mean[i].x + mean[i].y + mean[i].z;
    }
    return sum > 0 ? error / sum : 0;
}

}  // namespace dapple::reference
