#pragma once
#include <cmath>
#include <cstdint>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <vector>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "methods/adaptive_beams/beam_renderer.h"
#include "view/camera_paths.h"

/// Pictures of beams that the test has made.
namespace dapple::test {

constexpr double kFloor = 3;  // m, depth

struct Drawn {
    view::ReceiverLayer receivers;
    view::SegmentLayer segments;
    methods::adaptive_beams::BeamSums sums;
    FrameStats stats;
};

inline Drawn draw(
    const scene::FrameScene& scene, const std::vector<methods::adaptive_beams::BeamSet>& sets,
    methods::adaptive_beams::VolumeKind volumes = methods::adaptive_beams::VolumeKind::six_triangles,
    methods::adaptive_beams::Shading shading = methods::adaptive_beams::Shading::exact,
    std::uint64_t largest_buffer = std::numeric_limits<std::uint64_t>::max(), int sample = 0) {
    Drawn drawn;
    const rays::RayScene rays(scene);
    view::LayerCounts counts;
    drawn.receivers = view::trace_layer(scene, rays, {sample, 0}, counts, &drawn.segments);
    methods::adaptive_beams::BeamRenderer renderer(validated_device(), largest_buffer);
    renderer.begin(scene, sets, volumes, shading, drawn.stats);
    drawn.sums = renderer.render(&drawn.segments, &drawn.receivers, drawn.stats);
    return drawn;
}

/// Murky water at rest over a level floor, object 0; one sample a pixel.
inline scene::FrameScene flat_scene(double zenith, int cells) {
    scene::FrameScene scene = scene_of_flat_water({24, 20}, cells, cells);
    scene.state.lights = {sun_from_zenith(zenith)};
    scene.state.water->absorption = {0.4, 0.1, 0.03};
    scene.state.water->scattering = {0.2, 0.3, 0.05};
    scene.state.clip.width = 48;
    scene.state.clip.height = 36;
    scene.state.clip.samples = 1;
    scene.state.objects = {level_plane("floor", -kFloor, 100)};
    scene.object_meshes.resize(1);
    return scene;
}

/// Gentle crests over a level floor, object 0; one sample a pixel.
inline scene::FrameScene wavy_scene(int cells, double amplitude) {
    constexpr double kWave = 2 * glm::pi<double>() / 1.1;
    scene::FrameScene scene = scene_of_water({6, 6}, cells, cells, [&](double x, double z) {
        const double a = kWave * (x + 0.3 * z), b = 1.3 * kWave * (z - 0.2 * x) + 1;
        return amplitude * glm::dvec3(std::sin(a) + std::sin(b), kWave * (std::cos(a) - 0.26 * std::cos(b)),
                                      kWave * (0.3 * std::cos(a) + 1.3 * std::cos(b)));
    });
    scene.state.lights = {sun_from_zenith(30)};
    scene.state.water->absorption = {0.1, 0.05, 0.02};
    scene.state.water->scattering = {0.1, 0.1, 0.1};
    scene.state.water->phase.type = scene::PhaseType::henyey_greenstein;
    scene.state.water->phase.anisotropy = 0.7;
    scene.state.clip.width = 64;
    scene.state.clip.height = 36;
    scene.state.clip.samples = 1;
    scene.state.camera.position = {-1.4, -1.2, 1.1};
    scene.state.camera.target = {0.9, -1.9, -0.4};
    scene.state.camera.field_of_view = 40 * scene::kDegree;
    scene.state.objects = {level_plane("floor", -kFloor, 100)};
    scene.object_meshes.resize(1);
    return scene;
}

}  // namespace dapple::test
