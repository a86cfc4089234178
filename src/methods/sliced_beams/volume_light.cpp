#include "methods/sliced_beams/volume_light.h"

#include <algorithm>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {

VolumeLight::VolumeLight(const scene::FrameScene& scene, Sheets sheets, FrameStats& stats, ScatterPass* pass)
    : scene_(scene), media_(scene), pass_(pass) {
    const std::vector<media::Component>& components = media_.components();
    for (std::size_t i = 0; i < components.size(); ++i) phases_.emplace_back(media_, i);
    even_[0] = EvenMedium<float>({0, 0, 0}, {0, 0, 0}, phases_[0]);
    even_[1] = EvenMedium<float>(components[0].extinction, components[0].scattering, phases_[0]);
    for (const auto& sheet : sheets) {
        sheets_.push_back(std::make_unique<ScatterSheet<float>>(*sheet));
        if (!sheets_.back()->ways().empty()) sheets_.back()->ways().report(stats);
        const glm::dvec3 collapsed = sheets_.back()->collapsed();
        if (collapsed != glm::dvec3(0))
            stats.count("lost to flat beams, W", (collapsed.x + collapsed.y + collapsed.z) / 3);
    }
    on_cpu_.assign(sheets_.size(), 1);
    if (!pass_) return;
    pass_->clear();
    // The device knows the water alone.
    if (media_.bounded(true) || !media_.scatters(true)) return;
    for (std::size_t i = 0; i < sheets_.size(); ++i)
        if (sheets_[i]->coverage().sheet().in_water() && pass_->take(*sheets_[i], i))
            on_cpu_[i] = sheets_[i]->keep_mixed() ? 1 : 0;
}

std::vector<VolumeLight::Direction> VolumeLight::directions(const view::SegmentLayer& layer,
                                                            bool in_water) const {
    const scene::FrameState& state = scene_.state;
    const int wanted = state.caustics.sliced_beams.volume_sun_samples;
    std::vector<Direction> all;
    for (std::size_t i = 0; i < sheets_.size(); ++i) {
        if (sheets_[i]->coverage().sheet().in_water() != in_water) continue;
        // The parts of the disc that have sheets of their own are directions already.
        if (!sheets_[i]->coverage().blurs()) {
            all.push_back({i, sheets_[i]->direction({0, 0}), 1});
            continue;
        }
        const int count = std::max(1, wanted / state.caustics.sliced_beams.sun_samples);
        for (const glm::dvec2& d : disc_directions(count, layer.sample, state.clip.samples))
            all.push_back({i, sheets_[i]->direction(d), 1 / static_cast<float>(count)});
    }
    return all;
}

void VolumeLight::find_uneven(const LayerGroup& group, UnevenGroup<float>& uneven) const {
    uneven.phases = phases_;
    for (int lane = 0; lane < kLanes<float>; ++lane) {
        const SegmentGroup<float>& s = group.segments;
        if (!(s.length[lane] >= 0)) continue;
        const glm::dvec3 origin(s.origin[0][lane], s.origin[1][lane], s.origin[2][lane]);
        const glm::dvec3 direction(s.direction[0][lane], s.direction[1][lane], s.direction[2][lane]);
        const auto length = static_cast<double>(s.length[lane]);
        uneven.scatter[lane] = SegmentScatter(media_, origin, direction, length, group.in_water);
        // The air scatters nothing by itself.
        if (!group.in_water || media_.may_meet(origin, direction, length, true)) uneven.uneven[lane] = -1;
    }
}

void VolumeLight::add(const view::SegmentLayer& layer, std::span<glm::vec3> radiance,
                      ScatterCounts& counts) const {
    std::vector<Direction> side[2] = {directions(layer, false), directions(layer, true)};
    std::erase_if(side[1], [&](const Direction& d) { return !on_cpu_[d.sheet]; });
    if (side[0].empty() && side[1].empty()) return;
    const LayerSegments segments(layer);
    constexpr std::size_t kPart = 2;
    std::vector<ScatterCounts> parts(segments.patches() / kPart + 1);
    parallel_for(segments.patches(), kPart, [&](std::size_t begin, std::size_t end) {
        ScatterCounts& part = parts[begin / kPart];
        for (std::size_t patch = begin; patch < end; ++patch) {
            for (const LayerGroup& group : segments.groups(patch)) {
                if (!media_.scatters(group.in_water) || side[group.in_water].empty()) continue;
                const bool bounded = media_.bounded(group.in_water);
                UnevenGroup<float> uneven;
                if (bounded) find_uneven(group, uneven);
                Lanes<float> sum[3] = {};
                for (const Direction& direction : side[group.in_water]) {
                    Lanes<float> one[3] = {};
                    sheets_[direction.sheet]->add(group.segments, direction.light, even_[group.in_water],
                                                  bounded ? &uneven : nullptr, one, part);
                    for (int c = 0; c < 3; ++c) sum[c] += direction.share * one[c];
                }
                for (std::size_t lane = 0; lane < group.segment.size(); ++lane)
                    if (group.segments.length[lane] >= 0)
                        radiance[group.segment[lane]] += glm::vec3(sum[0][lane], sum[1][lane], sum[2][lane]);
            }
        }
    });
    for (const ScatterCounts& part : parts) counts.add(part);
}

void VolumeLight::add_on_device(const view::SegmentLayer& layer, std::span<glm::vec3> radiance,
                                ScatterCounts& counts, FrameStats& stats) const {
    std::vector<Direction> taken = directions(layer, true);
    std::erase_if(taken, [&](const Direction& d) { return !pass_ || !pass_->takes(d.sheet); });
    if (!taken.empty()) pass_->add(LayerSegments(layer), taken, even_[1], radiance, counts, stats);
}

}  // namespace dapple::methods::sliced_beams
