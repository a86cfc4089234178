#include "light/cascade_layout.h"

#include <algorithm>
#include <cmath>

namespace dapple::light {
namespace {

constexpr double kMostResolution = 1 << 28;  // beyond what memory holds, and whole numbers still do
constexpr double kMostPlaces = 1e15;         // across the extent: as above

std::int64_t floor_divided(std::int64_t a, std::int64_t b) {
    const std::int64_t quotient = a / b;
    return quotient * b > a ? quotient - 1 : quotient;
}

std::int64_t ceil_divided(std::int64_t a, std::int64_t b) {
    return -floor_divided(-a, b);
}

/// Where, in texels of the outermost cascade, its first photon lies from the extent's edge: in the middle of
/// a texel where the finer cascades have theirs so too, else where no photon of any cascade lies near an
/// edge, on which it would be in and out by round-off.
double first_place(const CascadeLayout& layout) {
    constexpr int kSteps = 97;  // a prime, so that no ratio brings its fractions to whole numbers
    double best = 0.5, least = HUGE_VAL;
    for (int i = 0; i < kSteps; ++i) {
        const double place = i == 0 ? 0.5 : static_cast<double>(i) / kSteps;
        double off = 0;
        for (std::size_t c = 0; c < layout.boxes.size(); ++c) {
            const double own = place * static_cast<double>(layout.multiple(c));
            off = std::max(off, std::abs(own - std::floor(own) - 0.5));
        }
        off += 1e-3 * std::abs(place - 0.5);
        if (off < least) {
            least = off;
            best = place;
        }
    }
    return best;
}

double share_at(const CascadeBox& box, std::int64_t steps) {
    const double t = std::clamp(static_cast<double>(steps) / static_cast<double>(box.ramp), 0.0, 1.0);
    return t < 0.5 ? 2 * t * t : 1 - 2 * (1 - t) * (1 - t);
}

/// Steps of a ramp in a box `steps` wide. Where footprints on both lattices differ (a pixel widens the finer
/// ones only, or they lie along other vectors) up to a quarter of a second difference of the shares shows, 1
/// / ramp^2: 32 steps keep that to 0.1 %. Wider boxes have wider ramps, an eighth of them; small ones have
/// what leaves them a middle as wide as the finer box.
std::int64_t ramp_steps(std::int64_t steps, double scale) {
    constexpr std::int64_t kEnough = 48;
    const std::int64_t wanted = std::max(steps / 8, std::min(steps / 4, kEnough));
    const auto room = static_cast<std::int64_t>(0.5 * (1 - 1 / scale) * static_cast<double>(steps)) - 1;
    return std::max<std::int64_t>(1, std::min(wanted, room));
}

/// Nearest to `wanted` such that the box's middle, where light is its own alone, lies over water.
double held_center(double wanted, double extent_center, double extent_size, double middle) {
    const double room = 0.5 * (extent_size - middle);
    return room > 0 ? std::clamp(wanted, extent_center - room, extent_center + room) : extent_center;
}

/// Whether photons of the innermost cascade are to lie no farther apart than was asked for.
bool by_precision(const scene::CausticMapParameters& parameters) {
    return parameters.map_precision > 0 && parameters.cascade_maps.empty();
}

/// Gives the boxes their sizes and the texels their ratios; returns what the outermost texel should measure.
double set_sizes(const scene::FrameState& state, const scene::CausticMapParameters& parameters,
                 CascadeLayout& layout) {
    const glm::dvec2 extent = state.water->extent.size;
    const double longer = std::max(extent.x, extent.y);
    layout.whole = false;
    double size = inner_box_size(state, parameters);
    for (int c = 0; c < parameters.cascades && !layout.whole; ++c, size *= parameters.cascade_scale) {
        CascadeBox box;
        box.size = size;
        layout.boxes.push_back(box);
        layout.whole = size >= longer * (1 - 1e-9);
    }
    const auto spacing = [&](std::size_t c) {
        return layout.boxes[c].size / cascade_resolution(parameters, c, layout.boxes[c].size);
    };
    double texel = spacing(0);
    for (std::size_t c = 0; c + 1 < layout.boxes.size(); ++c) {
        layout.boxes[c].ratio = std::max<std::int64_t>(1, std::llround(spacing(c + 1) / texel));
        texel *= static_cast<double>(layout.boxes[c].ratio);
    }
    // A size or a spacing of the innermost that was asked for leads; else that of the outermost does.
    return parameters.inner_size > 0 || by_precision(parameters) ? texel : spacing(layout.boxes.size() - 1);
}

}  // namespace

std::int64_t CascadeLayout::multiple(std::size_t cascade) const {
    std::int64_t result = 1;
    for (std::size_t c = cascade; c + 1 < boxes.size(); ++c) result *= boxes[c].ratio;
    return result;
}

double inner_box_size(const scene::FrameState& state, const scene::CausticMapParameters& parameters) {
    if (parameters.inner_size > 0) return parameters.inner_size;
    const glm::dvec2 extent = state.water->extent.size;
    return std::max(extent.x, extent.y) / std::pow(parameters.cascade_scale, parameters.cascades - 1);
}

double cascade_resolution(const scene::CausticMapParameters& parameters, std::size_t cascade, double size) {
    double result = parameters.map_resolution;
    if (cascade < parameters.cascade_maps.size())
        result = parameters.cascade_maps[cascade].resolution;
    else if (parameters.map_precision > 0)
        result = std::ceil(size / (parameters.map_precision *
                                   std::pow(parameters.cascade_scale, static_cast<double>(cascade))) -
                           1e-9);
    return std::clamp(result, 1.0, kMostResolution);
}

glm::dvec2 cascade_center(const scene::FrameState& state, const scene::CausticMapParameters& parameters) {
    const scene::Camera& camera = state.camera;
    switch (parameters.cascade_center) {
        case scene::CascadeCenter::camera:
            return {camera.position.x, camera.position.z};
        case scene::CascadeCenter::target:
            return {camera.target.x, camera.target.z};
        case scene::CascadeCenter::extent:
            break;
    }
    return state.water->extent.center;
}

double inner_share(const CascadeBox& box, int axis, std::int64_t k) {
    return share_at(box, std::min(k - box.low[axis], box.high[axis] - k));
}

glm::dvec2 CascadeLayout::margin(std::size_t cascade) const {
    return cells == PhotonCells::tents ? first * boxes.back().texel : 0.5 * boxes[cascade].texel;
}

double own_inner_share(const CascadeBox& box, PhotonCells cells, int axis, std::int64_t k) {
    const std::int64_t before = floor_divided(k, box.ratio), beyond = k - before * box.ratio;
    const double low = inner_share(box, axis, before);
    if (beyond == 0 || cells == PhotonCells::boxes) return low;
    const double part = static_cast<double>(beyond) / static_cast<double>(box.ratio);
    return low + part * (inner_share(box, axis, before + 1) - low);
}

CascadeLayout lay_out_cascades(const scene::FrameState& state, const scene::CausticMapParameters& parameters,
                               PhotonCells cells) {
    const scene::Extent& extent = state.water->extent;
    CascadeLayout layout;
    layout.cells = cells;
    const double wanted = set_sizes(state, parameters, layout);
    layout.corner = extent.center - 0.5 * extent.size;
    layout.first = first_place(layout);
    const glm::dvec2 about = cascade_center(state, parameters);
    for (int axis = 0; axis < 2; ++axis) {
        const double most = kMostPlaces / static_cast<double>(layout.multiple(0));
        const double texels = std::clamp(extent.size[axis] / wanted, 1.0, most);
        const std::int64_t across = by_precision(parameters)
                                        ? static_cast<std::int64_t>(std::ceil(texels * (1 - 1e-12)))
                                        : std::llround(texels);
        const double outermost = extent.size[axis] / static_cast<double>(across);
        layout.extent_texels[axis] = across;
        for (std::size_t c = 0; c < layout.boxes.size(); ++c)
            layout.boxes[c].texel[axis] = outermost / static_cast<double>(layout.multiple(c));
    }
    for (std::size_t c = 0; c < layout.boxes.size(); ++c) {
        CascadeBox& box = layout.boxes[c];
        const bool last = c + 1 == layout.boxes.size();
        const glm::dvec2 step = last ? box.texel : layout.boxes[c + 1].texel,
                         base = layout.base(last ? c : c + 1);
        const glm::dvec2 steps = glm::max(glm::round(box.size / step), glm::dvec2(last ? 1 : 2));
        if (!last)
            box.ramp =
                ramp_steps(static_cast<std::int64_t>(std::min(steps.x, steps.y)), parameters.cascade_scale);
        for (int axis = 0; axis < 2; ++axis) {
            const double ramps = last ? 0 : 2 * static_cast<double>(box.ramp) * step[axis];
            const double center =
                held_center(about[axis], extent.center[axis], extent.size[axis], box.size - ramps);
            const double lowest = center - 0.5 * steps[axis] * step[axis] - base[axis];
            box.low[axis] = std::llround(lowest / step[axis] + (last ? 0.5 : 0.0));
            box.high[axis] = box.low[axis] + static_cast<std::int64_t>(steps[axis]);
            if (c == 0) continue;
            // The next finer box lies where light is this one's alone, however coarse the steps are.
            const CascadeBox& finer = layout.boxes[c - 1];
            const std::int64_t room = last ? 0 : box.ramp, ratio = last ? 1 : box.ratio;
            box.low[axis] = std::min(box.low[axis], floor_divided(finer.low[axis], ratio) - room);
            box.high[axis] =
                std::max(box.high[axis], ceil_divided(finer.high[axis], ratio) + room + (last ? 1 : 0));
        }
    }
    return layout;
}

}  // namespace dapple::light
