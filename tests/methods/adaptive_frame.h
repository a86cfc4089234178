#pragma once
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <vector>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "methods/adaptive_beams/adaptive_beams.h"
#include "methods/adaptive_scene.h"
#include "view/camera_paths.h"

/// Frames of the class of adaptive beams.
namespace dapple::test::adaptive_frame {

inline constexpr double kIndex = 1.333;

/// A pool under flat water with few, wide beams; seen from within.
inline scene::FrameScene pool(double elevation) {
    scene::FrameScene scene;
    test::add_water(scene, 0, 8);
    scene.state.water->refractive_index = kIndex;
    scene.state.lights = {test::sun_at(elevation)};
    scene.state.caustics.adaptive_beams.grid = 8;
    scene.state.caustics.adaptive_beams.levels = 0;
    scene.state.clip.width = 40;
    scene.state.clip.height = 30;
    scene.state.clip.samples = 1;
    scene.state.camera.position = {0.1, -0.2, 0.3};
    scene.state.camera.target = {0, -1, -0.2};
    scene.state.camera.field_of_view = 30 * scene::kDegree;
    scene.state.objects = {test::floor_at(-1, 100)};
    scene.object_meshes.resize(scene.state.objects.size());
    return scene;
}

/// One frame with the method, which it outlives.
struct Frame {
    explicit Frame(const scene::FrameScene& s, light::Event event = light::Event::transmission)
        : scene(s), rays(scene), context{scene, rays, test::validated_device(), stats, {}} {
        context.chains = {{0, event}};
        method.begin(context);
    }

    view::ReceiverLayer receivers(int sample, view::SegmentLayer& segments) const {
        view::LayerCounts counts;
        view::LayerRequest request;
        request.sample = sample;
        return view::trace_layer(scene, rays, request, counts, &segments);
    }
    methods::LayerResult irradiance(const view::ReceiverLayer& layer) {
        std::vector<methods::LayerResult> results(1);
        results[0].irradiance.assign(layer.pixels(), glm::vec3(0));
        results[0].covered.assign(layer.pixels(), 0);
        method.irradiance(context, {&layer, 1}, results);
        return results[0];
    }
    std::vector<glm::vec3> in_scatter(const view::SegmentLayer& layer) {
        std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
        method.in_scatter(context, layer, radiance);
        return radiance;
    }

    const scene::FrameScene& scene;
    rays::RayScene rays;
    FrameStats stats;
    methods::FrameContext context;
    methods::AdaptiveBeams method;
};

/// W/m^2 across the light in the water, where nothing dims it.
inline double across(double elevation) {
    const double cos_t = std::cos(std::asin(std::cos(elevation * scene::kDegree) / kIndex));
    return test::flat_floor(90 - elevation, 1, kIndex).irradiance / cos_t;
}

inline glm::dvec3 direction_in_water(double elevation) {
    const double sine = std::cos(elevation * scene::kDegree) / kIndex;
    return {-sine, -std::sqrt(1 - sine * sine), 0};
}

}  // namespace dapple::test::adaptive_frame
