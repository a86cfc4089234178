#include "render/way_depths.h"

#include <algorithm>

namespace dapple::render {
namespace {

/// Fewer miss ripples of a cloud by symmetry.
constexpr double kFirstParts = 6;
/// Halvings of these at most.
constexpr int kMostLevels = 6;
/// Of the segment's light: what the depth's distance from a straight line may come to, were it as large all
/// over a part that is not halved once more. Its middle is known then too: of a bow a sixth is left, in the
/// mean.
constexpr double kTolerance = 0.01;

double mean(const glm::dvec3& color) {
    return (color.x + color.y + color.z) / 3;
}
double middle(const LightShare& share) {
    return 0.5 * (share.begin + share.end);
}
glm::dvec3 sum(std::span<const LightShare> shares) {
    glm::dvec3 all(0);
    for (const LightShare& share : shares) all += share.value;
    return all;
}

/// Those whose middles lie before a place, of shares in their order.
std::size_t count_before(std::span<const LightShare> shares, double place) {
    const auto end = std::ranges::lower_bound(shares, place, {}, middle);
    return static_cast<std::size_t>(end - shares.begin());
}

}  // namespace

WayDepths::Node WayDepths::node(const LightOnSegment& light, double place) {
    return {place, glm::max(light.depth(place, light.way(place)), glm::dvec3(0))};
}

/// Finds the ends of parts of equal light, and about what is left of all.
void WayDepths::start(const LightOnSegment& light, std::span<const LightShare> shares) {
    const double part = mean(sum(shares)) / kFirstParts;
    coarse_ = {node(light, shares.front().begin)};
    left_ = glm::dvec3(0);
    glm::dvec3 in_part(0);
    for (std::size_t i = 0; i < shares.size(); ++i) {
        in_part += shares[i].value;
        if (i + 1 < shares.size() && mean(in_part) < part) continue;
        const Node before = coarse_.back();
        coarse_.push_back(node(light, shares[i].end));
        left_ += in_part * glm::exp(-0.5 * (before.depth + coarse_.back().depth));
        in_part = glm::dvec3(0);
    }
}

/// Adds nodes between two to nodes_, whose shares are given.
void WayDepths::refine(const LightOnSegment& light, std::span<const LightShare> shares, const Node& begin,
                       const Node& end, int level) {
    const double place = light.place(0.5 * (light.variable(begin.place) + light.variable(end.place)));
    if (shares.empty() || !(place > begin.place && place < end.place)) return;
    const Node found = node(light, place);
    const double way = (place - begin.place) / (end.place - begin.place);
    const glm::dvec3 off = glm::abs(found.depth - glm::mix(begin.depth, end.depth, way));
    const glm::dvec3 wrong = sum(shares) * glm::exp(-found.depth) * off;
    if (level == kMostLevels || glm::all(glm::lessThanEqual(wrong, kTolerance * left_))) {
        nodes_.push_back(found);
        return;
    }
    const std::size_t before = count_before(shares, place);
    refine(light, shares.first(before), begin, found, level + 1);
    nodes_.push_back(found);
    refine(light, shares.subspan(before), found, end, level + 1);
}

void WayDepths::dim(const LightOnSegment& light, std::span<LightShare> shares) {
    const auto is_lit = [](const LightShare& share) { return share.value != glm::dvec3(0); };
    while (!shares.empty() && !is_lit(shares.front())) shares = shares.subspan(1);
    while (!shares.empty() && !is_lit(shares.back())) shares = shares.first(shares.size() - 1);
    if (shares.empty()) return;
    start(light, shares);
    nodes_ = {coarse_.front()};
    for (std::size_t i = 1; i < coarse_.size(); ++i) {
        const std::size_t from = count_before(shares, coarse_[i - 1].place);
        const std::size_t to = count_before(shares, coarse_[i].place);
        refine(light, shares.subspan(from, to - from), coarse_[i - 1], coarse_[i], 0);
        nodes_.push_back(coarse_[i]);
    }
    std::size_t next = 1;
    for (LightShare& share : shares) {
        const double place = middle(share);
        while (next + 1 < nodes_.size() && nodes_[next].place < place) ++next;
        const Node &begin = nodes_[next - 1], &end = nodes_[next];
        const double size = end.place - begin.place;
        const double way = size > 0 ? std::clamp((place - begin.place) / size, 0.0, 1.0) : 0.5;
        share.value *= glm::exp(-glm::mix(begin.depth, end.depth, way));
    }
}

}  // namespace dapple::render
