#include "light/texel_rays.h"

#include <algorithm>
#include <cmath>

#include "optics/optics.h"
#include "scene/area_light.h"

// The loops here have no branches that all lanes do not share, and are compiled (CMakeLists.txt) so that the
// compiler may take both sides of a condition: it makes eight rays at once of the physics as it is written
// for one.

namespace dapple::light {
namespace {

constexpr std::size_t kMost = TexelRays::kMost;
constexpr float kSmallestAxisCosine = 0.1f;  // of BeamMesh::axis
constexpr float kNoRay = -1;                 // flux of a texel without water or without a transmitted ray

void put(TexelRays::Vectors& vectors, std::size_t k, glm::vec3 value) {
    vectors.x[k] = value.x;
    vectors.y[k] = value.y;
    vectors.z[k] = value.z;
}

glm::dvec2 horizontal(glm::dvec3 v) {
    return {v.x, v.z};
}

}  // namespace

TexelTracer::TexelTracer(const scene::FrameScene& scene, const MapPlan& plan, const BeamMesh& mesh)
    : anchor_(plan.anchor - horizontal(scene.origin)),
      column_step_(plan.texel[0]),
      row_step_(plan.texel[1]),
      first_column_(static_cast<int>(plan.first.x)),
      first_row_(static_cast<int>(plan.first.y)),
      shear_(plan.shear - horizontal(scene.origin) * plan.inverse_height),
      inverse_height_(static_cast<float>(plan.inverse_height)),
      rest_height_(static_cast<float>(-scene.origin.y)),
      axis_(mesh.axis),
      reflection_(mesh.event == Event::reflection) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
    const double n = scene.state.water->refractive_index;
    sun_ = light.type == scene::LightType::sun;
    spot_ = light.type == scene::LightType::spot;
    emitter_ = scene::is_area(light);
    light_ = glm::vec3(sun_ ? light.direction : light.position - scene.origin);
    light_axis_ = glm::vec3(light.direction);
    cos_outer_ = static_cast<float>(std::cos(light.cone_angle));
    cos_inner_ = static_cast<float>(std::cos(std::max(0.0, light.cone_angle - light.falloff_angle)));
    eta_ = static_cast<float>(plan.from_below ? n : 1 / n);
}

void TexelTracer::trace(std::span<const glm::vec4> texels, int column, int row, TexelRays& rays) const {
    Met met;
    find_points(texels, column, row, met);
    find_light(column, row, met);
    reflection_ ? leave<true>(met, rays) : leave<false>(met, rays);
}

void TexelTracer::find_points(std::span<const glm::vec4> texels, int column, int row, Met& met) const {
    std::array<glm::vec4, kMost> rest;
    const glm::vec4* from = texels.data();
    if (texels.size() < kMost) {
        std::copy(texels.begin(), texels.end(), rest.begin());
        std::fill(rest.begin() + static_cast<std::ptrdiff_t>(texels.size()), rest.end(), glm::vec4(0));
        from = rest.data();
    }
    // A light under water meets the surface from there.
    const float side = inverse_height_ < 0 ? -1.0f : 1.0f;
    Row height;
    for (std::size_t k = 0; k < kMost; ++k) {
        const glm::vec3 normal(from[k].y, from[k].z, from[k].w);
        put(met.normal, k, normal);
        height[k] = from[k].x;
        met.water[k] = glm::dot(normal, normal) > 0 ? 1 : 0;
    }
    // Without water the rest plane goes on, so that every ray is finite.
    for (std::size_t k = 0; k < kMost; ++k) {
        height[k] = met.water[k] != 0 ? height[k] : 0.0f;
        met.normal.y[k] = met.water[k] != 0 ? met.normal.y[k] : 1.0f;
    }
    for (std::size_t k = 0; k < kMost; ++k) {
        const glm::vec2 foot = center(column + static_cast<int>(k), row) * (1 - inverse_height_ * height[k]) +
                               shear_ * height[k];
        put(met.point, k, {foot.x, height[k] + rest_height_, foot.y});
        put(met.normal, k, side * glm::normalize(met.normal.at(k)));
    }
}

/// Light through the texels of the rest plane: area across the beam (sun), or solid angle of the texel.
void TexelTracer::find_light(int column, int row, Met& met) const {
    const float area = std::abs(column_step_.x * row_step_.y - column_step_.y * row_step_.x);
    if (sun_) {
        for (std::size_t k = 0; k < kMost; ++k) {
            put(met.incident, k, light_);
            met.power[k] = area * std::abs(light_.y);
        }
        return;
    }
    for (std::size_t k = 0; k < kMost; ++k) {
        put(met.incident, k, glm::normalize(met.point.at(k) - light_));
        const glm::vec2 place = center(column + static_cast<int>(k), row);
        const glm::vec3 way = glm::vec3(place.x, rest_height_, place.y) - light_;
        const float square = glm::dot(way, way);
        met.power[k] = area * (std::abs(way.y) / (square * std::sqrt(square)));
    }
    if (spot_)
        for (std::size_t k = 0; k < kMost; ++k)
            met.power[k] *= optics::f32::spot_light_falloff(glm::dot(met.incident.at(k), light_axis_),
                                                            cos_outer_, cos_inner_);
    if (emitter_)
        for (std::size_t k = 0; k < kMost; ++k)
            met.power[k] *= glm::max(0.0f, glm::dot(met.incident.at(k), light_axis_));
}

template <bool kReflection>
void TexelTracer::leave(const Met& met, TexelRays& rays) const {
    const float eta = eta_;
    Row facing;  // cosine to the normal
    for (std::size_t k = 0; k < kMost; ++k) {
        const glm::vec3 incident = met.incident.at(k), normal = met.normal.at(k);
        facing[k] = -glm::dot(incident, normal);
        const float cos_i = glm::clamp(facing[k], 0.0f, 1.0f);
        const float cos_t = optics::f32::transmitted_cosine(cos_i, eta);
        glm::vec3 direction;
        bool leaves = true;
        float share;
        if (kReflection) {
            direction = optics::f32::reflected_direction(incident, normal);
            share = optics::f32::fresnel_reflectance(cos_i, cos_t, eta);
        } else {
            leaves = optics::f32::refracted_direction(incident, normal, eta, direction);
            share = optics::f32::fresnel_transmittance(cos_i, cos_t, eta);
        }
        put(rays.slope, k, direction);
        rays.flux[k] = leaves ? met.power[k] * share : kNoRay;
    }
    const glm::vec3 axis = axis_;
    for (std::size_t k = 0; k < kMost; ++k) {
        const bool carried = met.water[k] != 0 && facing[k] > 0;
        const float flux = carried ? rays.flux[k] : kNoRay;
        const glm::vec3 direction = rays.slope.at(k), point = met.point.at(k);
        const float along = glm::dot(direction, axis);
        const bool held = rays.flux[k] >= 0 && along > kSmallestAxisCosine;
        rays.flux[k] = held ? flux : kNoRay;
        rays.lost[k] = held ? 0.0f : glm::max(0.0f, flux);
        const float inverse = 1 / along;
        const glm::vec3 slope(held ? direction.x * inverse : axis.x, held ? direction.y * inverse : axis.y,
                              held ? direction.z * inverse : axis.z);
        const float start = glm::dot(point, axis);
        put(rays.slope, k, slope);
        rays.start[k] = start;
        put(rays.origin, k, point - start * slope);
    }
}

}  // namespace dapple::light
