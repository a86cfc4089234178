#include "methods/reference/volume_pass.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "methods/reference/own_optics.h"

namespace dapple::reference {
namespace {

constexpr std::size_t kTile = 512;                ///< strata, at least
constexpr std::size_t kSegmentsAStratum = 16;     ///< where there are many segments tiles are larger
constexpr std::size_t kKeptBytes = 128ull << 20;  ///< of tiles that wait to be added
constexpr std::size_t kMostTilesAtOnce = 64;
constexpr std::size_t kBatch = 1024;  ///< events whose visibility is asked at one go

/// Drops events that objects or waves hide from the near end, and adds the rest.
class EventSink {
public:
    EventSink(const scene::FrameScene& scene, const rays::RayScene& rays, const LightTracer& tracer,
              std::vector<glm::dvec3>& sums)
        : scene_(scene), rays_(rays), water_(tracer.water()), sums_(sums) {}

    std::vector<ScatteringEvent> events;

    void flush() {
        visible_.assign(events.size(), 1);
        if (rays_.has_objects()) {
            traced_.clear();
            for (const ScatteringEvent& event : events) traced_.push_back(ray_of(event));
            occluded_.resize(events.size());
            rays_.occluded_by_objects(traced_, occluded_);
            for (std::size_t i = 0; i < events.size(); ++i) visible_[i] = occluded_[i] == 0 ? 1 : 0;
        }
        if (water_.built()) test_water();
        for (std::size_t i = 0; i < events.size(); ++i)
            if (visible_[i] != 0 && finite(events[i].radiance))
                sums_[events[i].segment] += events[i].radiance;
        events.clear();
    }

private:
    /// To the near end, a few roundings short of it: it may lie on a mirror.
    rays::Ray ray_of(const ScatteringEvent& event) const {
        const glm::dvec3 way = event.near_end - event.position;
        const double rest = 8 * rounding_of(event.near_end) / length(way);
        return float_ray(event.position, way, 0, static_cast<float>(std::max(0.0, 1 - rest)));
    }
    /// Only near the surface may there be a wave on a straight way within one medium.
    void test_water() {
        traced_.clear();
        tested_.clear();
        const double highest = water_.surface().highest();
        for (std::size_t i = 0; i < events.size(); ++i) {
            const ScatteringEvent& event = events[i];
            if (!event.may_cross_water || visible_[i] == 0) continue;
            const double a = event.position.y + scene_.origin.y, b = event.near_end.y + scene_.origin.y;
            if (event.in_water ? std::max(a, b) < -highest : std::min(a, b) > highest) continue;
            tested_.push_back(i);
            traced_.push_back(ray_of(event));
        }
        hits_.resize(tested_.size());
        water_.intersect(traced_, hits_);
        for (std::size_t i = 0; i < tested_.size(); ++i)
            if (hits_[i].primitive != rays::kNoHit) visible_[tested_[i]] = 0;
    }

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const WaterRays& water_;
    std::vector<glm::dvec3>& sums_;
    std::vector<rays::Ray> traced_;
    std::vector<rays::Hit> hits_;
    std::vector<std::uint8_t> visible_, occluded_;
    std::vector<std::size_t> tested_;
};

}  // namespace

bool run_volume_pass(const scene::FrameScene& scene, const rays::RayScene& rays, const LightTracer& tracer,
                     const LightPass& pass, const CameraSegments& segments, const std::function<bool()>& stop,
                     std::vector<glm::dvec3>& radiance) {
    radiance.assign(segments.segments, glm::dvec3(0));
    const std::size_t strata = tracer.strata(pass);
    const std::size_t tile = std::max(kTile, segments.segments / kSegmentsAStratum);
    const std::size_t at_once = std::clamp<std::size_t>(
        kKeptBytes / (sizeof(glm::dvec3) * std::max<std::size_t>(1, segments.segments)), 1, kMostTilesAtOnce);
    std::vector<std::vector<glm::dvec3>> sums(at_once);
    for (std::size_t light = 0; light < tracer.lights(); ++light) {
        for (std::size_t first = 0; first < strata; first += tile * at_once) {
            if (stop()) return false;
            const std::size_t count = std::min(strata - first, tile * at_once);
            parallel_for(count, tile, [&](std::size_t begin, std::size_t end) {
                std::vector<glm::dvec3>& sum = sums[begin / tile];
                sum.assign(segments.segments, glm::dvec3(0));
                std::vector<Arrival> ignored;
                std::vector<LightWay> ways;
                tracer.trace(pass, light, first + begin, first + end, ignored, &ways);
                EventSink sink(scene, rays, tracer, sum);
                MediaProbe along_light(tracer.media()), to_eye(tracer.media());
                for (const LightWay& way : ways) {
                    RandomStream random{scene.state.clip.seed, static_cast<std::uint64_t>(scene.state.frame),
                                        way.random};
                    if (segments.eye->any())
                        segments.eye->add_events(way, along_light, to_eye, random, sink.events);
                    if (segments.beams.any())
                        segments.beams.add_events(way, along_light, to_eye, random, sink.events);
                    if (sink.events.size() >= kBatch) sink.flush();
                }
                sink.flush();
            });
            for (std::size_t t = 0; t * tile < count; ++t)
                for (std::size_t i = 0; i < radiance.size(); ++i) radiance[i] += sums[t][i];
        }
    }
    return true;
}

}  // namespace dapple::reference
