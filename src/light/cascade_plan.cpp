#include "light/cascade_plan.h"

#include <algorithm>
#include <cmath>

#include "light/cascade_layout.h"
#include "light/paper_cascades.h"
#include "light/ring.h"

namespace dapple::light {
namespace {

/// Of those of a cascade's photons that water lies at, or may be thrown to.
TexelRange water_range(const CascadeLayout& layout, std::size_t cascade, int axis, double thrown,
                       bool& capped) {
    const CascadeBox& outermost = layout.boxes.back();
    const std::int64_t multiple = layout.multiple(cascade);
    const double texel = layout.boxes[cascade].texel[axis];
    const std::int64_t across = layout.extent_texels[axis] * multiple;
    const std::int64_t first = -static_cast<std::int64_t>(std::floor(layout.margin(cascade)[axis] / texel));
    const int widest =
        border_texels(thrown, outermost.texel[axis], static_cast<double>(layout.extent_texels[axis]), capped);
    const double own = thrown > 0 ? std::ceil(std::min(thrown / texel, 1e15)) : 0;
    const std::int64_t border = std::min(static_cast<std::int64_t>(own), widest * multiple);
    return {first - border, first + across - 1 + border};
}

/// Places of a cascade's map and of its hole, along x and z.
struct RingRanges {
    TexelRange map[2], hole[2];
    bool capped = false;
    bool empty() const { return map[0].low > map[0].high || map[1].low > map[1].high; }
};

/// `thrown`: m along x and z that the light throws points of the water off.
RingRanges ring_ranges(const CascadeLayout& layout, std::size_t cascade, glm::dvec2 thrown) {
    const bool last = cascade + 1 == layout.boxes.size();
    const CascadeBox& box = layout.boxes[cascade];
    RingRanges ranges;
    for (int axis = 0; axis < 2; ++axis) {
        TexelRange& map = ranges.map[axis];
        map = water_range(layout, cascade, axis, thrown[axis], ranges.capped);
        // A box's ends are among its texels: what carries nothing there still is a neighbour of what does. Of
        // boxes all texels of the coarser one's at the lower end carry nothing.
        const std::int64_t dark = layout.cells == PhotonCells::boxes ? box.ratio - 1 : 0;
        if (!last)
            map = {std::max(map.low, box.low[axis] * box.ratio + dark),
                   std::min(map.high, box.high[axis] * box.ratio)};
        else if (!layout.whole)
            map = {std::max(map.low, box.low[axis]), std::min(map.high, box.high[axis] - 1)};
        ranges.hole[axis] = {1, 0};
        if (cascade == 0) continue;
        const CascadeBox& finer = layout.boxes[cascade - 1];
        ranges.hole[axis] = {finer.low[axis] + finer.ramp + 1 - map.low,
                             finer.high[axis] - finer.ramp - 1 - map.low};
    }
    return ranges;
}

/// False where the cascade has nothing to carry.
bool place_map(const scene::FrameScene& scene, const CascadeLayout& layout, std::size_t cascade,
               MapPlan& plan) {
    const bool last = cascade + 1 == layout.boxes.size();
    const CascadeBox& box = layout.boxes[cascade];
    const CascadeBox* finer = cascade > 0 ? &layout.boxes[cascade - 1] : nullptr;
    plan.cascade = static_cast<int>(cascade);
    plan.texel = glm::dmat2(box.texel.x, 0, 0, box.texel.y);
    const RingRanges ranges = ring_ranges(layout, cascade, thrown_off(plan, scene));
    if (ranges.empty()) return false;
    const TexelRange(&map)[2] = ranges.map;
    const std::int64_t columns = map[0].high - map[0].low + 1, rows = map[1].high - map[1].low + 1;
    check_map_size(columns, rows);
    plan.columns = static_cast<int>(columns);
    plan.rows = static_cast<int>(rows);
    plan.parts = ring(plan.columns, plan.rows, ranges.hole[0], ranges.hole[1]);
    plan.capped = last && (ranges.capped || !layout.whole);

    // Places are counted from one near the frame's origin, where floats tell them apart best.
    const glm::dvec2 origin(scene.origin.x, scene.origin.z);
    const glm::dvec2 base = layout.base(cascade);
    const glm::i64vec2 near(glm::round((origin - base) / box.texel));
    plan.anchor = base + (glm::dvec2(near) - 0.5) * box.texel;
    plan.first = glm::i64vec2(map[0].low, map[1].low) - near;

    if (plan.parts.empty()) return false;
    const auto shares = [&](int axis, std::vector<double>& outer, std::vector<double>& inner) {
        for (std::int64_t k = map[axis].low; k <= map[axis].high; ++k) {
            outer.push_back(last ? 1 : own_inner_share(box, layout.cells, axis, k));
            inner.push_back(finer != nullptr ? inner_share(*finer, axis, k) : 0);
        }
    };
    if (layout.boxes.size() > 1) {
        shares(0, plan.shares.outer_x, plan.shares.inner_x);
        shares(1, plan.shares.outer_z, plan.shares.inner_z);
    }
    return true;
}

}  // namespace

std::vector<MapPlan> plan_cascades(const scene::FrameScene& scene, int light,
                                   const scene::CausticMapParameters& parameters, PhotonCells cells) {
    if (!plan_projection(scene, light).lit) return {plan_projection(scene, light)};
    if (parameters.paper_faithful) return plan_paper_cascades(scene, light, parameters);
    if (parameters.cascades == 1 && !(parameters.inner_size > 0)) {
        const double size = inner_box_size(scene.state, parameters);
        return {plan_map(scene, light, cascade_resolution(parameters, 0, size))};
    }
    const CascadeLayout layout = lay_out_cascades(scene.state, parameters, cells);
    std::vector<MapPlan> plans;
    for (std::size_t cascade = 0; cascade < layout.boxes.size(); ++cascade) {
        MapPlan plan = plan_projection(scene, light);
        if (place_map(scene, layout, cascade, plan)) plans.push_back(std::move(plan));
    }
    return plans;
}

MapTexels count_texels(const scene::FrameState& state, const scene::CausticMapParameters& parameters) {
    MapTexels texels;
    const auto add = [&](double side_x, double side_z, double hole) {
        texels.largest = std::max(texels.largest, side_x * side_z);
        texels.all += side_x * side_z;
        texels.photons += side_x * side_z - hole;
    };
    if (parameters.paper_faithful) {
        for (int c = 0; c < parameters.cascades; ++c) {
            const double side = paper_side(state, parameters, static_cast<std::size_t>(c));
            // Equation 6 in whole texels, and the texels of the hole that are neighbours of the ring.
            const double hole = c == 0 ? 0 : std::max(0.0, side / parameters.cascade_scale - 3);
            add(side, side, hole * hole);
        }
        return texels;
    }
    const CascadeLayout layout = lay_out_cascades(state, parameters);
    for (std::size_t c = 0; c < layout.boxes.size(); ++c) {
        const auto [map, hole, capped] = ring_ranges(layout, c, glm::dvec2(0));
        double side[2], held[2];
        for (int axis = 0; axis < 2; ++axis) {
            const auto texel = [](std::int64_t place) { return static_cast<double>(place); };
            side[axis] = std::max(0.0, texel(map[axis].high) - texel(map[axis].low) + 1);
            held[axis] =
                std::min(texel(hole[axis].high) + 1, side[axis]) - std::max(texel(hole[axis].low), 0.0);
        }
        add(side[0], side[1], std::max(0.0, held[0]) * std::max(0.0, held[1]));
    }
    return texels;
}

}  // namespace dapple::light
