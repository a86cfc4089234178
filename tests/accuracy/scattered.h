#pragma once
#include <vector>

#include "accuracy/scenes.h"

/// Light that media scatter, as pictures.
namespace dapple::test {

constexpr int kMurkySide = 32;

/// The column's pool and shadow in murky water, by the sun's whole disc.
inline scene::FrameState murky_column(double cells_per_shortest_wave) {
    scene::FrameState state = column_in_pool(cells_per_shortest_wave);
    state.clip.width = state.clip.height = kMurkySide;
    state.lights[0].angular_diameter = 0.53 * scene::kDegree;
    state.water->absorption = glm::dvec3(0.05);
    state.water->scattering = glm::dvec3(0.1);
    state.water->phase.type = scene::PhaseType::henyey_greenstein;
    state.water->phase.anisotropy = 0.6;
    return state;
}

/// What pixels receive of the light that media scatter, W/m^2/sr, green, by the camera's samples.
struct ScatteredPicture {
    std::vector<double> radiance;
    FrameStats stats;
};
inline ScatteredPicture take_scattered(const scene::FrameState& state, methods::CausticMethod& method,
                                       gpu::Device& device) {
    ScatteredPicture picture;
    const scene::FrameScene scene = scene_of(state);
    const rays::RayScene rays(scene);
    methods::FrameContext context{scene, rays, device, picture.stats, {{0, light::Event::transmission}}, {}};
    method.begin(context);
    picture.radiance.assign(static_cast<std::size_t>(state.clip.width * state.clip.height), 0);
    for (int sample = 0; sample < state.clip.samples; ++sample) {
        view::LayerCounts counts;
        view::SegmentLayer segments;
        view::trace_layer(scene, rays, {.sample = sample}, counts, &segments);
        std::vector<glm::vec3> radiance(segments.segments(), glm::vec3(0));
        method.in_scatter(context, segments, radiance);
        for (std::size_t pixel = 0; pixel < picture.radiance.size(); ++pixel)
            for (std::size_t i = segments.first[pixel]; i < segments.first[pixel + 1]; ++i)
                picture.radiance[pixel] +=
                    static_cast<double>(segments.throughput[i].g * radiance[i].g) / state.clip.samples;
    }
    return picture;
}

}  // namespace dapple::test
