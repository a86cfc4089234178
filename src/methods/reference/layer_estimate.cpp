#include "methods/reference/layer_estimate.h"

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

}  // namespace dapple::reference
