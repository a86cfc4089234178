#include "methods/reference/volume_pass.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "methods/reference/own_optics.h"

namespace dapple::reference {
namespace {

constexpr std::size_t kTile = 512;             ///< strata, at least
constexpr std::size_t kSegmentsAStratum = 16;  ///< where there are many segments tiles are larger
constexpr std::size_t kMostTilesAtOnce = 32;
constexpr std::size_t kBatch = 1024;  ///< events whose visibility is asked at one go

constexpr std::size_t kPilotStrata = 65536;
/// A number that no other pass has.
constexpr std::uint64_t kPilotPass = 0xffffff;

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
        const double rest = (8 * rounding_of(event.near_end) + event.slack) / length(way);
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

/// Traces strata [begin, end) of one source and adds what they scatter to `sums`. `number` picks an event's
/// place there. Whether places were found where a medium had dimmed the light to 0.
template <class Number>
bool trace_events(const VolumeJob& job, const LightPass& pass, std::size_t source, std::size_t begin,
                  std::size_t end, std::vector<glm::dvec3>& sums, const Number& number) {
    const Harvest harvest = job.tracer.trace(pass, source, begin, end, true);
    EventSink sink(job.scene, job.rays, job.tracer, sums);
    bool extinguished = false;
    MediaProbe along_light(job.tracer.media()), to_eye(job.tracer.media());
    const scene::FrameState& state = job.scene.state;
    for (const LightWay& way : harvest.ways) {
        RandomStream random{state.clip.seed, static_cast<std::uint64_t>(state.frame), way.random};
        const std::size_t first = sink.events.size();
        if (job.segments.eye->any())
            extinguished |= job.segments.eye->add_events(way, along_light, to_eye, random, sink.events);
        for (const CameraBeams& beams : job.segments.beams)
            extinguished |= beams.add_events(way, along_light, to_eye, random, sink.events);
        for (std::size_t i = first; i < sink.events.size(); ++i) number(way, sink.events[i]);
        if (sink.events.size() >= kBatch) sink.flush();
    }
    sink.flush();
    return extinguished;
}

}  // namespace

std::vector<SourceWeights> source_weights(const VolumeJob& job) {
    std::vector<SourceWeights> result;
    for (std::size_t source = 0; source < job.tracer.sources(); ++source) {
        StrataLayout even(job.tracer.aspect(source), kPilotStrata);
        const LightPass pass{kPilotPass, kPilotStrata, &even};
        std::vector<glm::dvec3> brought(even.strata(), glm::dvec3(0));
        constexpr std::size_t kAtOnce = kTile * kMostTilesAtOnce;
        for (std::size_t first = 0; first < even.strata(); first += kAtOnce) {
            if (job.stop()) return {};
            const std::size_t count = std::min(even.strata() - first, kAtOnce);
            parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
                // Strata lie apart in `brought`: threads do not meet.
                trace_events(job, pass, source, first + begin, first + end, brought,
                             [&](const LightWay& way, ScatteringEvent& event) {
                                 event.radiance *= job.segments.throughput[event.segment];
                                 event.segment = way.stratum;
                             });
            });
        }
        std::vector<double> squares(even.tiles(), 0);
        for (std::size_t stratum = 0; stratum < brought.size(); ++stratum)
            squares[even.tile(stratum)] += mean(brought[stratum]) * mean(brought[stratum]);
        std::vector<double> weights = even.widened(squares);
        for (double& weight : weights) weight = std::sqrt(weight);
        result.push_back({std::move(even), std::move(weights)});
    }
    return result;
}

std::optional<VolumePassResult> run_volume_pass(const VolumeJob& job, LightPass pass,
                                                const std::vector<SourceWeights>& weights,
                                                std::vector<glm::dvec3>& radiance) {
    const std::size_t segments = job.segments.segments;
    radiance.assign(segments, glm::dvec3(0));
    VolumePassResult result;
    const std::size_t tile = std::max(kTile, segments / kSegmentsAStratum);
    const std::size_t at_once = std::clamp<std::size_t>(
        kWaitingBytes / (sizeof(glm::dvec3) * std::max<std::size_t>(1, segments)), 1, kMostTilesAtOnce);
    std::vector<std::vector<glm::dvec3>> sums(at_once);
    std::vector<std::uint8_t> extinguished(at_once);
    for (std::size_t source = 0; source < job.tracer.sources(); ++source) {
        const StrataLayout layout(weights[source].tiles, weights[source].weights, pass.strata);
        pass.layout = &layout;
        const std::size_t strata = layout.strata();
        result.rays += strata;
        for (std::size_t first = 0; first < strata; first += tile * at_once) {
            if (job.stop()) return {};
            const std::size_t count = std::min(strata - first, tile * at_once);
            parallel_for(count, tile, [&](std::size_t begin, std::size_t end) {
                std::vector<glm::dvec3>& sum = sums[begin / tile];
                sum.assign(segments, glm::dvec3(0));
                extinguished[begin / tile] = trace_events(job, pass, source, first + begin, first + end, sum,
                                                          [](const LightWay&, ScatteringEvent&) {});
            });
            for (std::size_t t = 0; t * tile < count; ++t) {
                for (std::size_t i = 0; i < segments; ++i) radiance[i] += sums[t][i];
                result.extinguished |= extinguished[t] != 0;
            }
        }
    }
    return result;
}

}  // namespace dapple::reference
