#include "methods/reference/eye_connection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "view/camera.h"

namespace dapple::reference {
namespace {

/// Pixels between events on a way that passes the eye at the typical distance.
constexpr double kSpacing = 1.5;
/// Of a way; reached within a millionth of that distance.
constexpr double kMostEvents = 0x1p20;

}  // namespace

EyeConnection::EyeConnection(const scene::FrameScene& scene, bool in_water)
    : scene_(scene), in_water_(in_water) {
    const scene::Clip& clip = scene.state.clip;
    const view::Camera camera(scene.state.camera, clip.width, clip.height);
    eye_ = scene.state.camera.position - scene.origin;
    forward_ = camera.forward();
    pixel_from_relative_ = camera.pixel_from_world() * glm::translate(glm::dmat4(1), scene.origin);
    pixel_size_ = 2 * std::tan(0.5 * scene.state.camera.field_of_view) / clip.height;
    if (scene.state.water) {
        const glm::dvec2 size = scene.state.water->extent.size;
        typical_distance_ = 0.25 * std::sqrt(size.x * size.y);
    }
    targets.resize(static_cast<std::size_t>(clip.width) * static_cast<std::size_t>(clip.height));
}

void EyeConnection::find_any() {
    any_ = std::any_of(targets.begin(), targets.end(), [](const Target& t) { return t.segment != kNone; });
}

/// To the part within the picture: both pixel coordinates times the depth are linear along the way.
bool EyeConnection::clip(const LightWay& way, const Stretch& stretch, Clip& result) const {
    const scene::Clip& size = scene_.state.clip;
    const glm::dvec4 origin = pixel_from_relative_ * glm::dvec4(way.position, 1);
    const glm::dvec4 rate = pixel_from_relative_ * glm::dvec4(way.direction, 0);
    result.begin = stretch.begin;
    result.end = stretch.end;
    const auto keep_where_positive = [&](double value, double slope) {
        if (slope > 0)
            result.begin = std::max(result.begin, -value / slope);
        else if (slope < 0)
            result.end = std::min(result.end, -value / slope);
        else if (!(value > 0))
            result.end = result.begin;
    };
    keep_where_positive(origin.x, rate.x);
    keep_where_positive(origin.y, rate.y);
    keep_where_positive(size.width * origin.w - origin.x, size.width * rate.w - rate.x);
    keep_where_positive(size.height * origin.w - origin.y, size.height * rate.w - rate.y);
    keep_where_positive(origin.w, rate.w);
    if (!(result.begin < result.end)) return false;
    result.a = origin + result.begin * rate;
    result.b = origin + result.end * rate;
    if (!(result.a.w > 0 && result.b.w > 0)) return false;
    result.pixels = length(glm::dvec2(result.a) / result.a.w - glm::dvec2(result.b) / result.b.w);
    return true;
}

bool EyeConnection::add_events(const LightWay& way, MediaProbe& light_probe, MediaProbe& eye_probe,
                               RandomStream& random, std::vector<ScatteringEvent>& events) const {
    if (way.in_water != in_water_) return false;
    const OwnMedia& media = light_probe.media();
    const auto stretch = media.scattering_stretch(way.position, way.direction, way.length, in_water_);
    Clip line{};
    if (!stretch || !clip(way, *stretch, line)) return false;
    const double past = length(cross(eye_ - way.position, way.direction));
    const double wanted = line.pixels / kSpacing * typical_distance_ / past;
    const double count = std::isfinite(wanted) ? std::clamp(std::ceil(wanted), 1.0, kMostEvents) : 1;
    const bool bounded = media.any_bounded(in_water_);
    if (bounded) light_probe.start(way.position, way.direction, in_water_);
    const auto width = static_cast<std::size_t>(scene_.state.clip.width);
    bool extinguished = false;
    for (double i = 0; i < count; ++i) {
        // Evenly in the picture; perspective gives the place on the way.
        const double place = (i + random.next()) / count;
        const double mixed = place * line.a.w + (1 - place) * line.b.w;
        const double along = line.begin + (line.end - line.begin) * place * line.a.w / mixed;
        const double step = (line.end - line.begin) * line.a.w * line.b.w / (mixed * mixed * count);
        const glm::dvec2 pixel =
            (1 - place) * glm::dvec2(line.a) / line.a.w + place * glm::dvec2(line.b) / line.b.w;
        const glm::dvec2 corner =
            glm::clamp(glm::floor(pixel), glm::dvec2(0),
                       glm::dvec2(scene_.state.clip.width - 1, scene_.state.clip.height - 1));
        const Target& target =
            targets[static_cast<std::size_t>(corner.y) * width + static_cast<std::size_t>(corner.x)];
        if (target.segment == kNone) continue;

        ScatteringEvent event;
        event.position = way.position + along * way.direction;
        const glm::dvec3 to_eye = eye_ - event.position;
        const double distance = length(to_eye);
        const glm::dvec3 view = to_eye / distance;
        const double depth_share = -dot(view, forward_);
        const glm::dvec3 scattering =
            light_probe.scattering(event.position, dot(way.direction, view), in_water_);
        if (scattering == glm::dvec3(0)) continue;
        glm::dvec3 transmittance;
        if (bounded) {
            transmittance = light_probe.transmittance_to(along, random);
            if (transmittance == glm::dvec3(0)) return true;  // nor farther on
            transmittance *= eye_probe.transmittance(event.position, view, distance, in_water_, random);
        } else {
            transmittance = media.through_water(along + distance);
        }
        // Of the mean over the pixel: d(pixels^2) / d(solid angle) = 1 / (pixel size^2 cos^3).
        const double density =
            1 / (pixel_size_ * pixel_size_ * depth_share * depth_share * depth_share * distance * distance);
        event.near_end = eye_;
        event.radiance = step * density * way.power * scattering * transmittance * target.factor;
        event.segment = target.segment;
        event.in_water = in_water_;
        event.may_cross_water = true;
        if (event.radiance != glm::dvec3(0))
            events.push_back(event);
        else if (transmittance == glm::dvec3(0))
            extinguished = true;
    }
    return extinguished;
}

}  // namespace dapple::reference
