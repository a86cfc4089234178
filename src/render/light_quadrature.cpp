#include "render/light_quadrature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <span>

#include "render/flat_water.h"

namespace dapple::render {
namespace {

/// A step of the quadrature is at most this deep (relative error of three nodes for both ways together:
/// 3e-5) and spans at most this angle at a lamp.
constexpr double kLargestDepth = 1;
/// Deeper than this from both ends of a cell steps may double: whatever counts there is less deep in another
/// channel.
constexpr double kDeep = 16;
constexpr double kLargestAngle = glm::pi<double>() / 32;
/// Up to this depth and angle one node is enough: relative error depth^2 / 24 = 4e-4, as much at the peak of
/// a phase function of mean cosine 0.9.
constexpr double kShallow = 0.1;
constexpr double kNarrow = glm::pi<double>() / 512;
/// A lamp in line with a segment is seen from it under this angle at least: its square is left of 1 / r^2.
constexpr double kLeastSine = 1e-4;
/// Optical depth beyond which nothing is seen: 24 bits.
constexpr double kBlack = 16.6;

/// Gauss-Legendre nodes and weights on [0, 1].
struct GaussNode {
    double place, weight;
};
constexpr std::array<GaussNode, 3> kThreeNodes{
    {{0.1127016653792583, 5.0 / 18}, {0.5, 8.0 / 18}, {0.8872983346207417, 5.0 / 18}}};
constexpr std::array<GaussNode, 1> kOneNode{{{0.5, 1}}};

double largest(const glm::dvec3& color) {
    return std::max({color.x, color.y, color.z});
}
double smallest(const glm::dvec3& color) {
    return std::min({color.x, color.y, color.z});
}

/// Where steps of a cell end, as shares of it: each at most kLargestDepth deep, but for what lies deep.
std::vector<double> step_ends(double depth) {
    std::vector<double> ends;
    if (depth <= 2 * kDeep) {
        const double steps = std::max(1.0, std::ceil(depth / kLargestDepth));
        for (double step = 1; step <= steps; ++step) ends.push_back(step / steps);
        return ends;
    }
    for (double at = kLargestDepth; at < 0.5 * depth; at += at < kDeep ? kLargestDepth : at)
        ends.push_back(at / depth);
    for (std::size_t i = ends.size(); i-- > 0;) ends.push_back(1 - ends[i]);
    ends.push_back(1);
    return ends;
}

/// Adds what is scattered between two places, in equal parts of the variable of integration.
void add_step(LightOnSegment& light, const Cell& cell, const double* densities, bool with_way, double begin,
              double end, double parts, std::span<const GaussNode> nodes, std::vector<LightShare>& shares) {
    const double first = light.variable(begin), size = light.variable(end) - first;
    for (double part = 0; part < parts; ++part) {
        double weights = 0;
        for (const GaussNode& node : nodes) {
            const auto at = [&](double place) { return light.place(first + size * (part + place) / parts); };
            const double place = at(node.place);
            const double along = (place - cell.begin) / (cell.end - cell.begin);
            const LightOnSegment::Way way = light.way(place);
            glm::dvec3 depth = cell.depth + along * cell.depth_step;
            if (with_way) depth += light.depth(place, way);
            const glm::dvec3 value =
                node.weight * size / parts * light.scattered(densities, way) * glm::exp(-depth);
            shares.push_back({at(weights), at(weights + node.weight), value});
            weights += node.weight;
        }
    }
}

void add_part(LightOnSegment& light, const Cell& cell, const double* densities, bool with_way, double begin,
              double end, double depth, std::vector<LightShare>& shares) {
    const double angle = light.angle(begin, end);
    if (depth <= kShallow && angle <= kNarrow) {
        add_step(light, cell, densities, with_way, begin, end, 1, kOneNode, shares);
    } else {
        const double parts = std::max(1.0, std::ceil(angle / kLargestAngle));
        add_step(light, cell, densities, with_way, begin, end, parts, kThreeNodes, shares);
    }
}

}  // namespace

void SegmentCells::find(const media::Media& media, const Segment& segment) {
    cells.clear();
    densities.clear();
    const media::DensityProfile profile =
        media.profile(segment.origin, segment.direction, segment.length, segment.in_water);
    const std::size_t count = profile.components;
    glm::dvec3 depth(0);
    for (std::size_t place = 0; place + 1 < profile.place.size() && smallest(depth) < kBlack; ++place) {
        const double begin = profile.place[place], end = profile.place[place + 1];
        if (!(end > begin)) continue;
        Cell cell{begin, end, depth, glm::dvec3(0), densities.size()};
        bool empty = true;
        for (std::size_t k = 0; k < count; ++k) {
            const double column = profile.column[(place + 1) * count + k] - profile.column[place * count + k];
            densities.push_back(column / (end - begin));
            cell.depth_step += column * media.components()[k].extinction;
            empty = empty && !(column > 0);
        }
        depth += cell.depth_step;
        if (empty) {
            densities.resize(cell.first_density);
        } else {
            cells.push_back(cell);
        }
    }
}

LightOnSegment::LightOnSegment(const scene::FrameScene& scene, const media::Media& media,
                               const scene::Light& light, const glm::dvec3& sun_direction,
                               const Segment& segment, double pixel_radius)
    : media_(media), light_(light), segment_(segment), sun_direction_(sun_direction) {
    if (light.type == scene::LightType::sun) {
        strength_ = light.irradiance;
        set_phases(-dot(sun_direction_, segment.direction));
        return;
    }
    strength_ = light.intensity;
    lamp_ = light.position - scene.origin;
    const glm::dvec3 to_lamp = lamp_ - segment.origin;
    foot_ = dot(to_lamp, segment.direction);
    const double passes_at = length(to_lamp - foot_ * segment.direction);
    // The mean of 1 / distance over a disc of radius r about the lamp is 2 / r.
    distance_ = std::sqrt(passes_at * passes_at + 0.25 * pixel_radius * pixel_radius);
    // Of a lamp ahead or behind only the way along the segment counts; as an angle it would round to 0.
    const double ahead = std::max({0.0, -foot_, foot_ - segment.length});
    distance_ = std::max(distance_, kLeastSine * ahead);
}

double LightOnSegment::variable(double place) const {
    return lamp() ? std::atan((place - foot_) / distance_) : place;
}
double LightOnSegment::place(double variable) const {
    return lamp() ? foot_ + distance_ * std::tan(variable) : variable;
}

double LightOnSegment::doublings(double begin, double end) const {
    const double a = std::abs(begin - foot_), b = std::abs(end - foot_);
    const bool along = lamp() && (begin > foot_) == (end > foot_) && std::min(a, b) > distance_;
    return along ? std::max(1.0, std::ceil(std::abs(std::log2(b / a)))) : 1;
}
double LightOnSegment::between(double begin, double end, double share) const {
    return foot_ + (begin - foot_) * std::pow((end - foot_) / (begin - foot_), share);
}

LightOnSegment::Way LightOnSegment::way(double place) const {
    if (!lamp()) return {sun_direction_, std::numeric_limits<double>::infinity()};
    const glm::dvec3 way = segment_.at(place) - lamp_;
    const double distance = length(way);
    return {distance > 0 ? way / distance : segment_.direction, distance};
}
glm::dvec3 LightOnSegment::depth(double place, const Way& way) const {
    return media_.optical_depth(segment_.at(place), -way.direction, way.length, segment_.in_water);
}

glm::dvec3 LightOnSegment::scattered(const double* densities, const Way& way) {
    double share = 1;
    if (lamp()) {
        share = spot_falloff(light_, way.direction) / distance_;
        if (share == 0) return glm::dvec3(0);
        set_phases(-dot(way.direction, segment_.direction));
    }
    glm::dvec3 sum(0);
    for (std::size_t k = 0; k < phases_.size(); ++k)
        sum += densities[k] * phases_[k] * media_.components()[k].scattering;
    return share * strength_ * sum;
}

void LightOnSegment::set_phases(double cosine) {
    phases_.resize(media_.components().size());
    for (std::size_t k = 0; k < phases_.size(); ++k) {
        const bool scatters = media_.components()[k].scattering != glm::dvec3(0);
        phases_[k] = scatters ? media_.phase(k, glm::clamp(cosine, -1.0, 1.0)) : 0;
    }
}

void add_light_of_cell(LightOnSegment& light, const Cell& cell, const double* densities, bool with_way,
                       std::vector<LightShare>& shares) {
    double deepest = largest(cell.depth_step);
    if (with_way) {
        const auto depth = [&](double place) { return light.depth(place, light.way(place)); };
        const double middle = 0.5 * (cell.begin + cell.end);
        const glm::dvec3 a = depth(cell.begin), b = depth(middle), c = depth(cell.end);
        deepest = std::max(deepest, 2 * largest(glm::abs(b - a) + glm::abs(c - b)));
    }
    double begin = cell.begin;
    for (const double share : step_ends(deepest)) {
        const double end = glm::mix(cell.begin, cell.end, share);
        const double parts = light.doublings(begin, end);
        if (parts == 1) {
            add_part(light, cell, densities, with_way, begin, end, deepest, shares);
        } else {
            for (double part = 0; part < parts; ++part) {
                add_part(light, cell, densities, with_way, light.between(begin, end, part / parts),
                         light.between(begin, end, (part + 1) / parts), deepest, shares);
            }
        }
        begin = end;
    }
}

void add_picture(const light::SpotPicture& picture, const LightOnSegment& light,
                 std::vector<LightShare>& shares) {
    for (LightShare& share : shares) {
        if (share.value == glm::dvec3(0)) continue;
        const double first = light.variable(share.begin), size = light.variable(share.end) - first;
        const double wanted = std::ceil(2 * size * picture.texels_per_radian());
        const double steps = wanted >= 1 ? std::min(wanted, kMostPictureSteps) : 1;
        glm::dvec3 sum(0);
        double count = 0;
        for (double step = 0; step < steps; ++step) {
            const double place = light.place(first + (step + 0.5) / steps * size);
            const glm::dvec3 direction = light.way(place).direction;
            // At the edge of the cone the share's own falloff is the mean of light and darkness.
            if (!picture.in_cone(direction)) continue;
            sum += picture.towards(direction, size / steps);
            ++count;
        }
        if (count > 0) share.value *= sum / count;
    }
}

}  // namespace dapple::render
