#include "methods/sliced_beams/volume_light.h"

#include <algorithm>

#include "base/parallel.h"

namespace dapple::methods::sliced_beams {

VolumeLight::VolumeLight(const scene::FrameScene& scene, Sheets sheets, FrameStats& stats)
    : scene_(scene), media_(scene) {
    const std::vector<media::Component>& components = media_.components();
    for (std::size_t i = 0; i < components.size(); ++i) phases_.emplace_back(media_, i);
    water_ = EvenMedium<float>(components[0].extinction, components[0].scattering, phases_[0]);
    for (const auto& sheet : sheets) {
        sheets_.push_back(std::make_unique<ScatterSheet<float>>(*sheet));
        if (!sheets_.back()->ways().empty()) sheets_.back()->ways().report(stats);
    }
}

std::vector<VolumeLight::Direction> VolumeLight::directions(const view::SegmentLayer& layer,
                                                            bool in_water) const {
    const scene::FrameState& state = scene_.state;
    const int wanted = state.caustics.sliced_beams.volume_sun_samples;
    std::vector<Direction> all;
    for (std::size_t i = 0; i < sheets_.size(); ++i) {
        if (sheets_[i]->coverage().sheet().in_water() != in_water) continue;
        // The parts of the disc that have sheets of their own are directions already.
        const int count = sheets_[i]->coverage().blurs()
                              ? std::max(1, wanted / state.caustics.sliced_beams.sun_samples)
                              : 1;
        for (const glm::dvec2& d : disc_directions(count, layer.sample, state.clip.samples))
            all.push_back({i, sheets_[i]->direction(d), 1 / static_cast<float>(count)});
    }
    return all;
}

void VolumeLight::add(const view::SegmentLayer& layer, std::span<glm::vec3> radiance,
                      ScatterCounts& counts) const {
    const std::vector<Direction> side[2] = {directions(layer, false), directions(layer, true)};
    const LayerSegments segments(layer);
    constexpr std::size_t kPart = 32;
    std::vector<ScatterCounts> parts(segments.blocks() / kPart + 1);
    parallel_for(segments.blocks(), kPart, [&](std::size_t begin, std::size_t end) {
        ScatterCounts& part = parts[begin / kPart];
        for (std::size_t block = begin; block < end; ++block) {
            for (const LayerGroup& group : segments.groups(block)) {
                if (!media_.scatters(group.in_water)) continue;
                Lanes<float> sum[3] = {};
                for (const Direction& direction : side[group.in_water]) {
                    Lanes<float> one[3] = {};
                    sheets_[direction.sheet]->add(group.segments, direction.light, water_, one, part);
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

}  // namespace dapple::methods::sliced_beams
