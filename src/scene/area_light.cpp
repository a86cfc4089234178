#include "scene/area_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dapple::scene {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
/// A light whose direction is nearer to the vertical than that (sine) shines straight up or down.
constexpr double kVertical = 1e-6;

/// A rectangle of an emitter's own coordinates.
struct PartBox {
    glm::dvec2 low, high;
};

/// Cuts the unit square into `count` boxes of equal area: rows, and as many boxes in each as its share of
/// the height says. `row_ends[i]`: boxes in the rows up to row i.
std::vector<PartBox> boxes_of(const std::vector<int>& row_ends, bool rows_first) {
    std::vector<PartBox> boxes;
    const double count = row_ends.back();
    int first = 0;
    for (const int end : row_ends) {
        const double in_row = end - first;
        for (int i = 0; i < end - first; ++i) {
            glm::dvec2 low(i / in_row, first / count), high((i + 1) / in_row, end / count);
            if (rows_first) {
                std::swap(low.x, low.y);
                std::swap(high.x, high.y);
            }
            boxes.push_back({low, high});
        }
        first = end;
    }
    return boxes;
}

/// Parts of a quad as nearly square as their number allows.
std::vector<PartBox> quad_parts(const Light& quad) {
    const int rows = std::clamp(
        static_cast<int>(std::round(std::sqrt(quad.samples * quad.size.y / quad.size.x))), 1, quad.samples);
    std::vector<int> ends;
    for (int row = 1; row <= rows; ++row)
        ends.push_back(static_cast<int>(std::llround(static_cast<double>(quad.samples) * row / rows)));
    return boxes_of(ends, false);
}

/// Rings about as wide as their parts are long.
std::vector<PartBox> disc_parts(const Light& disc) {
    const int rings = std::max(1, static_cast<int>(std::round(0.5 * std::sqrt(disc.samples))));
    std::vector<int> ends;
    for (int ring = 1; ring <= rings; ++ring) {
        const double share = static_cast<double>(ring) / rings;
        ends.push_back(static_cast<int>(std::llround(disc.samples * share * share)));
    }
    return boxes_of(ends, true);
}

/// A part's middle and what its points lie off it, along two axes of the emitter's plane: m.
struct Moments {
    glm::dvec2 middle, spread_u, spread_v;
};

Moments quad_moments(const Light& quad, const PartBox& box) {
    // The variance of a stretch of width w is w^2 / 12.
    const glm::dvec2 deviation = quad.size * (box.high - box.low) / std::sqrt(12.0);
    return {quad.size * (0.5 * (box.low + box.high) - 0.5), {deviation.x, 0}, {0, deviation.y}};
}

Moments disc_moments(const Light& disc, const PartBox& box) {
    const double inner = disc.radius * std::sqrt(box.low.x), outer = disc.radius * std::sqrt(box.high.x);
    const double half = 0.5 * kTurn * (box.high.y - box.low.y);  // angle
    const double at = 0.5 * kTurn * (box.low.y + box.high.y);
    // Means over the sector: of r 2/3 (b^3 - a^3) / (b^2 - a^2), of r^2 (a^2 + b^2) / 2, of the cosine of the
    // angle to its axis sin(h) / h, of that squared 1/2 + sin(2 h) / (4 h).
    const double mean = 2.0 / 3 * (outer * outer + outer * inner + inner * inner) / (outer + inner);
    const double square = 0.5 * (inner * inner + outer * outer);
    const double ahead = mean * std::sin(half) / half, lean = std::sin(2 * half) / (4 * half);
    const double along = square * (0.5 + lean) - ahead * ahead, across = square * (0.5 - lean);
    const glm::dvec2 axis(std::cos(at), std::sin(at));
    return {ahead * axis, std::sqrt(std::max(0.0, along)) * axis,
            std::sqrt(std::max(0.0, across)) * glm::dvec2(-axis.y, axis.x)};
}

void add_parts(const Light& emitter, std::vector<Light>& lights) {
    const bool quad = emitter.type == LightType::quad;
    const LightFrame frame = light_frame(emitter);
    const auto on_plane = [&](glm::dvec2 v) { return v.x * frame.right + v.y * frame.up; };
    for (const PartBox& box : quad ? quad_parts(emitter) : disc_parts(emitter)) {
        const Moments moments = quad ? quad_moments(emitter, box) : disc_moments(emitter, box);
        Light& light = lights.emplace_back(emitter);
        light.part = {
            emitter.samples,           box.low, box.high, emitter.position, on_plane(moments.spread_u),
            on_plane(moments.spread_v)};
        light.position = emitter.position + on_plane(moments.middle);
        light.intensity = emitter.radiance * (emitter_area(emitter) / emitter.samples);
    }
}

}  // namespace

LightFrame light_frame(const Light& light) {
    const glm::dvec3& axis = light.direction;
    const glm::dvec3 level(-axis.z, 0, axis.x);  // axis x (0, 1, 0)
    const double length = glm::length(level);
    const glm::dvec3 right = length > kVertical ? level / length : glm::dvec3(1, 0, 0);
    const glm::dvec3 up = glm::cross(right, axis);
    const double cosine = std::cos(light.roll), sine = std::sin(light.roll);
    return {cosine * right - sine * up, sine * right + cosine * up};
}

double emitter_area(const Light& light) {
    return light.type == LightType::quad ? light.size.x * light.size.y
                                         : std::numbers::pi * light.radius * light.radius;
}

double emitter_reach(const Light& light) {
    return light.type == LightType::quad ? 0.5 * glm::length(light.size) : light.radius;
}

glm::dvec3 emitter_point(const Light& part, glm::dvec2 place) {
    const LightFrame frame = light_frame(part);
    const glm::dvec2 at = glm::mix(part.part.low, part.part.high, place);
    glm::dvec2 off = part.size * (at - 0.5);
    if (part.type == LightType::disc)
        off = part.radius * std::sqrt(at.x) * glm::dvec2(std::cos(kTurn * at.y), std::sin(kTurn * at.y));
    return part.part.center + off.x * frame.right + off.y * frame.up;
}

FrameState with_emitter_parts(FrameState state) {
    if (std::none_of(state.lights.begin(), state.lights.end(), is_area)) return state;
    std::vector<Light> lights;
    for (std::size_t i = 0; i < state.lights.size(); ++i) {
        Light& light = state.lights[i];
        if (light.name.empty()) light.name = "lights[" + std::to_string(i) + "]";
        if (is_area(light) && light.part.count == 0)
            add_parts(light, lights);
        else
            lights.push_back(light);
    }
    state.lights = std::move(lights);
    return state;
}

}  // namespace dapple::scene
