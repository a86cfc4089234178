#include "methods/adaptive_beams/beam_sets.h"

#include <array>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "light/beam_axes.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr std::array<const char*, light::kSheetAxes> kAxisNames = {"",    " +x", " -x", " +z",
                                                                   " -z", " +y", " -y"};

BeamSet::Vertex vertex_of(const PathLeg& leg, const glm::dmat3& mesh_from_world) {
    const glm::dvec3 start = mesh_from_world * leg.start;
    const glm::dvec3 way = mesh_from_world * leg.direction;
    const glm::dvec2 slope = glm::dvec2(way) / way.z;
    const glm::dvec2 foot = glm::dvec2(start) - start.z * slope;
    const auto first = static_cast<float>(start.z);
    return {static_cast<float>(foot.x),
            static_cast<float>(foot.y),
            static_cast<float>(slope.x),
            static_cast<float>(slope.y),
            first,
            std::max(first, static_cast<float>(start.z + leg.length * way.z))};
}

}  // namespace

void append_sets(const LegBeams& legs, light::Event event, const TracedRays& rays, int light,
                 const std::string& name, std::vector<BeamSet>& sets, Losses& losses) {
    const auto leg_of = [&](std::uint32_t ray) -> const PathLeg& {
        return rays.paths[ray].paths[static_cast<std::size_t>(event)].legs[legs.leg];
    };
    glm::dvec3 mean(0);
    for (const LegBeam& beam : legs.beams)
        for (const std::uint32_t ray : beam.rays)
            mean += (beam.flux.x + beam.flux.y + beam.flux.z) * leg_of(ray).direction;
    mean = glm::dot(mean, mean) > 0 ? glm::normalize(mean) : glm::dvec3(0, -1, 0);
    const auto axes = light::sheet_axes(mean);
    const auto cones = [&](std::uint32_t ray) {
        unsigned bits = 0;
        for (std::size_t k = 0; k < axes.size(); ++k)
            if (glm::dot(leg_of(ray).direction, axes[k]) > light::kConeCosine) bits |= 1u << k;
        return bits;
    };
    std::array<std::vector<const LegBeam*>, light::kSheetAxes> by_axis;
    for (const LegBeam& beam : legs.beams) {
        const unsigned fits = cones(beam.rays[0]) & cones(beam.rays[1]) & cones(beam.rays[2]);
        if (fits == 0) {
            losses[static_cast<std::size_t>(Cause::outside_cone)] += beam.flux;
            continue;
        }
        by_axis[static_cast<std::size_t>(std::countr_zero(fits))].push_back(&beam);
    }
    for (std::size_t k = 0; k < axes.size(); ++k) {
        if (by_axis[k].empty()) continue;
        BeamSet& set = sets.emplace_back();
        set.name = name + kAxisNames[k];
        set.light = light;
        set.in_water = legs.in_water;
        const glm::dmat3 frame = light::mesh_frame(axes[k]);
        set.world_from_mesh = frame;
        const glm::dmat3 mesh_from_world = glm::transpose(frame);
        std::unordered_map<std::uint32_t, std::uint32_t> index;
        for (const LegBeam* beam : by_axis[k]) {
            glm::uvec3 triangle;
            for (int i = 0; i < 3; ++i) {
                const std::uint32_t ray = beam->rays[static_cast<std::size_t>(i)];
                const auto [found, inserted] =
                    index.try_emplace(ray, static_cast<std::uint32_t>(set.vertices.size()));
                if (inserted) set.vertices.push_back(vertex_of(leg_of(ray), mesh_from_world));
                triangle[i] = found->second;
            }
            set.triangles.push_back(triangle);
            set.flux.emplace_back(beam->flux);
            set.ends_on.push_back(leg_of(beam->rays[0]).end);
        }
    }
}

}  // namespace dapple::methods::adaptive_beams
