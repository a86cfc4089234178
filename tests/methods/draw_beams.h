#pragma once
#include <cstdint>
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

}  // namespace dapple::test
