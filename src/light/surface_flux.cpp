#include "light/surface_flux.h"

#include <numeric>
#include <vector>

#include "base/parallel.h"
#include "light/spot_picture.h"
#include "optics/optics.h"
#include "scene/area_light.h"

namespace dapple::light {
namespace {

bool inside(const MapPlan& plan, glm::dvec3 point) {
    const double w = 1 - plan.inverse_height * point.y;
    if (w <= 0) return false;
    const glm::dvec2 texel = plan.texel_of((glm::dvec2(point.x, point.z) - plan.shear * point.y) / w);
    return texel.x >= 0 && texel.y >= 0 && texel.x <= plan.columns && texel.y <= plan.rows;
}

}  // namespace

double flux_outside_map(const scene::FrameScene& scene, const MapPlan& plan, int light_index, Event event) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    const double n = scene.state.water->refractive_index;
    const double eta = plan.from_below ? n : 1 / n;
    const SpotPicture picture(scene, light_index);
    const double colors = light.intensity.r + light.intensity.g + light.intensity.b;
    const scene::TriangleMesh& mesh = scene.water->mesh;
    constexpr std::size_t kTile = 1 << 14;
    std::vector<double> tiles(mesh.triangles.size() / kTile + 1, 0);
    parallel_for(mesh.triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t t = begin; t < end; ++t) {
            const glm::uvec3 corner = mesh.triangles[t];
            const glm::dvec3 a = mesh.positions[corner.x], b = mesh.positions[corner.y],
                             c = mesh.positions[corner.z];
            const glm::dvec3 center = (a + b + c) / 3.0;
            if (inside(plan, center)) continue;
            glm::dvec3 direction = light.direction;
            double density = 1;  // of unit irradiance, or of unit intensity at this distance
            if (light.type != scene::LightType::sun) {
                const glm::dvec3 way = center - light.position;
                density = 1 / glm::dot(way, way);
                direction = way * glm::sqrt(density);
                if (light.type == scene::LightType::spot)
                    density *= optics::f64::spot_light_falloff(
                        glm::dot(direction, light.direction), glm::cos(light.cone_angle),
                        glm::cos(light.cone_angle - light.falloff_angle));
                if (scene::is_area(light)) density *= glm::max(0.0, glm::dot(direction, light.direction));
                if (picture.exists() && density > 0 && colors > 0)
                    density *=
                        glm::dot(light.intensity,
                                 picture.mean({a - light.position, b - light.position, c - light.position})) /
                        colors;
            }
            glm::dvec3 area = 0.5 * glm::cross(b - a, c - a);
            if (plan.from_below) area = -area;
            const double across = -glm::dot(area, direction);
            if (across <= 0) continue;
            const double cos_i = glm::min(1.0, across / glm::length(area));
            const double cos_t = optics::f64::transmitted_cosine(cos_i, eta);
            sum += density * across *
                   (event == Event::transmission ? optics::f64::fresnel_transmittance(cos_i, cos_t, eta)
                                                 : optics::f64::fresnel_reflectance(cos_i, cos_t, eta));
        }
        tiles[begin / kTile] = sum;
    });
    return std::accumulate(tiles.begin(), tiles.end(), 0.0);
}

}  // namespace dapple::light
