#include "light/paper_cascades.h"

#include <algorithm>
#include <cmath>

#include "light/cascade_layout.h"
#include "light/ring.h"

namespace dapple::light {
namespace {

/// Columns are where the light's frame has its axes, as the light throws them onto the rest plane: a sun's
/// map is a square across its light (equation 2), so a parallelogram here, longer along its azimuth. Lamps,
/// of which the paper has none, keep the rest plane's own axes.
glm::dmat2 light_frame(const scene::Light& light) {
    if (light.type != scene::LightType::sun) return glm::dmat2(1);
    const glm::dvec2 level(light.direction.x, light.direction.z);
    const double length = glm::length(level);
    const glm::dvec2 azimuth = length > 0 ? level / length : glm::dvec2(1, 0);
    return glm::dmat2(azimuth / std::abs(light.direction.y), glm::dvec2(-azimuth.y, azimuth.x));
}

/// Equation 1: the light's frame stands on the light's way through the camera. How far back it stands
/// changes its depths only, whose range is that of the water here (the last row of equation 2 must hold -near
/// / (far - near); as printed everything is cut away), so that nothing is cut off along the light.
glm::dvec2 middle(const scene::FrameScene& scene, const scene::Light& light, const MapPlan& plan,
                  const scene::CausticMapParameters& parameters) {
    const glm::dvec2 about = cascade_center(scene.state, parameters);
    const bool of_camera = parameters.cascade_center == scene::CascadeCenter::camera;
    if (light.type != scene::LightType::sun || !of_camera) return about;
    return about - plan.shear * scene.state.camera.position.y;
}

}  // namespace

int paper_resolution(double range, double precision) {
    for (const int size : {256, 512, 1024}) {
        if (range / precision < size) return size;
    }
    return 2048;
}

int paper_side(const scene::FrameState& state, const scene::CausticMapParameters& parameters,
               std::size_t cascade) {
    const double inner = inner_box_size(state, parameters);
    if (parameters.map_precision > 0 && parameters.cascade_maps.empty())
        return paper_resolution(inner, parameters.map_precision);
    const double width = inner * std::pow(parameters.cascade_scale, static_cast<double>(cascade));
    return static_cast<int>(cascade_resolution(parameters, cascade, width));
}

int paper_frame(int resolution, double scale) {
    return static_cast<int>(std::lround(0.5 * resolution * (1 - 1 / scale)));
}

std::vector<MapPlan> plan_paper_cascades(const scene::FrameScene& scene, int light_index,
                                         const scene::CausticMapParameters& parameters) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    const MapPlan projection = plan_projection(scene, light_index);
    const double inner = inner_box_size(scene.state, parameters);
    std::vector<MapPlan> plans;
    for (int c = 0; c < parameters.cascades; ++c) {
        // Equation 2: wider by s^c. Equation 7, L = s^(2 c), follows: a photon carries the light of its
        // texel, whose area grows so. (Its ray's intensity, equation 12, lacks the area of a texel of level
        // 0.)
        const double width = inner * std::pow(parameters.cascade_scale, c);
        const int resolution = paper_side(scene.state, parameters, static_cast<std::size_t>(c));
        check_map_size(resolution, resolution);
        MapPlan plan = projection;
        plan.cascade = c;
        plan.columns = plan.rows = resolution;
        plan.texel = light_frame(light) * (width / resolution);
        plan.anchor =
            middle(scene, light, projection, parameters) - plan.texel * glm::dvec2(0.5 * resolution);
        // Algorithm 1, with equation 4 as area (1 - 1 / s^2): applied to each axis, as line 13 does, it would
        // lose a quarter of the ring at s = 2; lines 24 and 33 swap the regions, line 26 needs >=, and
        // equation 5 and line 17 run one past N - 1.
        const int frame = c > 0 ? paper_frame(resolution, parameters.cascade_scale) : 0;
        const TexelRange hole{frame, resolution - frame - 1};
        // One texel inside the hole is a neighbour, which footprints look at.
        plan.parts =
            c > 0 ? ring(resolution, resolution, {hole.low + 1, hole.high - 1}, {hole.low + 1, hole.high - 1})
                  : std::vector<TexelBox>{{0, 0, resolution, resolution}};
        if (parameters.cascades > 1) {
            const std::size_t size = static_cast<std::size_t>(resolution);
            std::vector<double> inside(size, 0);
            for (std::int64_t k = hole.low; c > 0 && k <= hole.high; ++k)
                inside[static_cast<std::size_t>(k)] = 1;
            plan.shares = {std::vector<double>(size, 1), std::vector<double>(size, 1), inside, inside};
        }
        plan.capped = c + 1 == parameters.cascades;
        plans.push_back(std::move(plan));
    }
    return plans;
}

}  // namespace dapple::light
