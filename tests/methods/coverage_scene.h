#pragma once
#include <cmath>
#include <memory>
#include <vector>

#include "methods/sliced_beams/sliced_beams.h"
#include "ocean/water_surface.h"
#include "scene/frame_scene.h"
#include "view/camera_paths.h"

/// A frame of a pool, to hold the two ways of computing coverage against each other.
namespace dapple::test {

/// 24 waves of 0.15 to 1.2 m in equal ratios and all directions over a pool of 6 m by 6 m, 2 m deep, with
/// walls, a sphere and a column that stands out of the water; the camera is under water.
inline scene::FrameScene pool_scene(int width, int height, int cells, double sun_disc_degrees) {
    scene::FrameScene scene;
    scene::FrameState& state = scene.state;
    state.clip.width = width;
    state.clip.height = height;
    state.clip.samples = 1;
    state.camera.position = {0.3, -0.4, 2.4};
    state.camera.target = {0, -1.4, 0};
    state.camera.field_of_view = 1.2;
    scene::Water& water = state.water.emplace();
    water.extent.size = {6, 6};
    water.mesh_cells = cells;
    for (int i = 0; i < 24; ++i) {
        scene::Wave wave;
        wave.length = 0.15 * std::pow(8.0, i / 23.0);
        wave.heading = 2.399963229728653 * i;
        wave.amplitude = 0.0032 * wave.length;
        wave.phase = 1.7 * i * i;
        const double k = 2 * std::numbers::pi / wave.length;
        wave.wave_vector = k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
        water.surface.waves.waves.push_back(wave);
    }
    scene::Light sun;
    sun.name = "sun";
    sun.direction = glm::normalize(glm::dvec3(0.5, -0.8660254, 0.1));
    sun.irradiance = {3, 2.5, 2};
    sun.angular_diameter = sun_disc_degrees * scene::kDegree;
    state.lights.push_back(sun);
    const auto add = [&](scene::Shape shape, glm::dvec3 position, glm::dvec3 size) {
        scene::Object object;
        object.shape = shape;
        object.size = size;
        object.radius = 0.5 * size.x;
        object.transform.position = position;
        state.objects.push_back(object);
    };
    add(scene::Shape::plane, {0, -2, 0}, {6, 1, 6});
    add(scene::Shape::box, {0, -0.9, -3.1}, {6.4, 2.4, 0.2});
    add(scene::Shape::box, {-3.1, -0.9, 0}, {0.2, 2.4, 6});
    add(scene::Shape::box, {3.1, -0.9, 0}, {0.2, 2.4, 6});
    add(scene::Shape::sphere, {-0.7, -1.3, 0.2}, {0.9, 0, 0});
    add(scene::Shape::box, {1.2, -0.8, -0.6}, {0.3, 2.6, 0.3});
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    return scene;
}

/// A frame that coverage is asked for, with all that comes before.
class CoverageFrame {
public:
    CoverageFrame(gpu::Device& device, const scene::FrameScene& scene)
        : device_(device), scene_(scene), rays_(scene) {
        view::LayerCounts counts;
        layers_.push_back(view::trace_layer(scene_, rays_, {}, counts));
        layers_[0].branch = 1;  // data layers, which are the CPU's, are asked for branch 0 only
    }
    /// E of the layers; the passes' costs are in `stats`.
    std::vector<methods::LayerResult> irradiance(methods::SlicedBeams& method, FrameStats& stats) {
        methods::FrameContext context{scene_, rays_, device_, stats, {{0, light::Event::transmission}}};
        method.begin(context);
        std::vector<methods::LayerResult> results(layers_.size());
        for (std::size_t i = 0; i < layers_.size(); ++i) {
            results[i].irradiance.resize(layers_[i].pixels());
            results[i].covered.resize(layers_[i].pixels());
        }
        method.irradiance(context, layers_, results);
        return results;
    }
    std::vector<view::ReceiverLayer>& layers() { return layers_; }

private:
    gpu::Device& device_;
    const scene::FrameScene& scene_;
    rays::RayScene rays_;
    std::vector<view::ReceiverLayer> layers_;
};

}  // namespace dapple::test
