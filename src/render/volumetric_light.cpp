#include "render/volumetric_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <vector>

#include "base/hash.h"
#include "base/parallel.h"
#include "render/flat_water.h"
#include "render/shading.h"

namespace dapple::render {
namespace {

constexpr std::size_t kTile = 256;  ///< pixels
/// Of hash_uniform, by lights and pieces of a path.
constexpr std::uint32_t kShiftDimension = 0x766c0000;
/// What the place of points grows by a pixel to the right and down, whole parts dropped: neighbors fill each
/// other's gaps (the additive sequence R2 of Roberts 2018, from the powers of the plastic number).
constexpr glm::dvec2 kShiftStep{0.7548776662466927, 0.5698402909980532};

/// A step of the quadrature is at most this deep (relative error of three nodes for both ways together:
/// 3e-5) and spans at most this angle at a lamp.
constexpr double kLargestDepth = 1;
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

double mean(const glm::dvec3& color) {
    return (color.x + color.y + color.z) / 3;
}
double largest(const glm::dvec3& color) {
    return std::max({color.x, color.y, color.z});
}
double smallest(const glm::dvec3& color) {
    return std::min({color.x, color.y, color.z});
}

struct Segment {
    glm::dvec3 origin, direction;
    double length;
    bool in_water;
    glm::dvec3 at(double place) const { return origin + place * direction; }
};

/// A part of a segment within which densities are taken as even.
struct Cell {
    double begin, end;          ///< m
    glm::dvec3 depth;           ///< optical depth from the near end to `begin`
    glm::dvec3 depth_step;      ///< from `begin` to `end`
    std::size_t first_density;  ///< of the components, in SegmentCells::densities
};

struct SegmentCells {
    std::vector<Cell> cells;
    std::vector<double> densities;  ///< mean density of each component, cell by cell

    void find(const media::Media& media, const Segment& segment);
};

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

/// A light as one segment sees it.
class LightOnSegment {
public:
    LightOnSegment(const scene::FrameScene& scene, const media::Media& media, const scene::Light& light,
                   const glm::dvec3& sun_direction, const Segment& segment, double pixel_radius)
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

    bool lamp() const { return light_.type != scene::LightType::sun; }
    bool singular() const { return lamp() && distance_ == 0; }
    /// The variable of integration at a place: the angle at the lamp, or the place itself.
    double variable(double place) const { return lamp() ? std::atan((place - foot_) / distance_) : place; }
    double place(double variable) const { return lamp() ? foot_ + distance_ * std::tan(variable) : variable; }
    double angle(double begin, double end) const { return lamp() ? variable(end) - variable(begin) : 0; }
    /// How many parts the way to a lamp at most doubles in: where it is seen nearly along the segment its
    /// angle hardly changes.
    double doublings(double begin, double end) const {
        const double a = std::abs(begin - foot_), b = std::abs(end - foot_);
        const bool along = lamp() && (begin > foot_) == (end > foot_) && std::min(a, b) > distance_;
        return along ? std::max(1.0, std::ceil(std::abs(std::log2(b / a)))) : 1;
    }
    /// Cuts the way between two such places into equal ratios.
    double between(double begin, double end, double share) const {
        return foot_ + (begin - foot_) * std::pow((end - foot_) / (begin - foot_), share);
    }

    /// Way of the light to a place of the segment.
    struct Way {
        glm::dvec3 direction;  ///< unit, of travel
        double length;         ///< m
    };
    Way way(double place) const {
        if (!lamp()) return {sun_direction_, std::numeric_limits<double>::infinity()};
        const glm::dvec3 way = segment_.at(place) - lamp_;
        const double distance = length(way);
        return {distance > 0 ? way / distance : segment_.direction, distance};
    }
    glm::dvec3 depth(double place, const Way& way) const {
        return media_.optical_depth(segment_.at(place), -way.direction, way.length, segment_.in_water);
    }
    /// Light that is scattered towards the near end, a unit of the variable of integration, if nothing is
    /// lost on the ways.
    glm::dvec3 scattered(const double* densities, const Way& way) {
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

private:
    void set_phases(double cosine) {
        phases_.resize(media_.components().size());
        for (std::size_t k = 0; k < phases_.size(); ++k) {
            const bool scatters = media_.components()[k].scattering != glm::dvec3(0);
            phases_[k] = scatters ? media_.phase(k, glm::clamp(cosine, -1.0, 1.0)) : 0;
        }
    }

    const media::Media& media_;
    const scene::Light& light_;
    const Segment& segment_;
    glm::dvec3 sun_direction_;
    glm::dvec3 strength_{0};
    glm::dvec3 lamp_{0};
    double foot_ = 0;      ///< m along the segment: nearest to the lamp
    double distance_ = 0;  ///< m from there
    std::vector<double> phases_;
};

/// What one node of the quadrature stands for.
struct Share {
    double begin, end;  ///< m
    glm::dvec3 value;   ///< W/m^2/sr
};

/// Light of one source that one segment scatters, in shares along it, shadow left out.
class Quadrature {
public:
    /// `even`: what is lost between light and segment is integrated too.
    Quadrature(LightOnSegment& light, bool even) : light_(light), even_(even) {}

    void add(const Cell& cell, const double* densities, std::vector<Share>& shares) {
        double deepest = largest(cell.depth_step);
        if (even_) {
            const double middle = 0.5 * (cell.begin + cell.end);
            const glm::dvec3 a = depth(cell.begin), b = depth(middle), c = depth(cell.end);
            deepest = std::max(deepest, 2 * largest(glm::abs(b - a) + glm::abs(c - b)));
        }
        const double steps = std::clamp(std::ceil(deepest / kLargestDepth), 1.0, 1024.0);
        for (double step = 0; step < steps; ++step) {
            const double begin = glm::mix(cell.begin, cell.end, step / steps);
            const double end = glm::mix(cell.begin, cell.end, (step + 1) / steps);
            const double parts = light_.doublings(begin, end);
            if (parts == 1) {
                add_part(cell, densities, begin, end, deepest, shares);
                continue;
            }
            for (double part = 0; part < parts; ++part) {
                add_part(cell, densities, light_.between(begin, end, part / parts),
                         light_.between(begin, end, (part + 1) / parts), deepest, shares);
            }
        }
    }

private:
    glm::dvec3 depth(double place) const { return light_.depth(place, light_.way(place)); }

    void add_part(const Cell& cell, const double* densities, double begin, double end, double depth,
                  std::vector<Share>& shares) {
        const double angle = light_.angle(begin, end);
        if (depth <= kShallow && angle <= kNarrow) {
            add_step(cell, densities, begin, end, 1, kOneNode, shares);
        } else {
            add_step(cell, densities, begin, end, std::max(1.0, std::ceil(angle / kLargestAngle)),
                     kThreeNodes, shares);
        }
    }

    void add_step(const Cell& cell, const double* densities, double begin, double end, double parts,
                  std::span<const GaussNode> nodes, std::vector<Share>& shares) {
        const double first = light_.variable(begin), size = light_.variable(end) - first;
        for (double part = 0; part < parts; ++part) {
            double weights = 0;
            for (const GaussNode& node : nodes) {
                const auto variable = [&](double place) { return first + size * (part + place) / parts; };
                const double place = light_.place(variable(node.place));
                const double along = (place - cell.begin) / (cell.end - cell.begin);
                const LightOnSegment::Way way = light_.way(place);
                glm::dvec3 depth = cell.depth + along * cell.depth_step;
                if (even_) depth += light_.depth(place, way);
                const glm::dvec3 value =
                    node.weight * size / parts * light_.scattered(densities, way) * glm::exp(-depth);
                shares.push_back(
                    {light_.place(variable(weights)), light_.place(variable(weights + node.weight)), value});
                weights += node.weight;
            }
        }
    }

    LightOnSegment& light_;
    bool even_;
};

/// A place of a segment, with the light that shares its shadow.
struct Stratum {
    double place;
    glm::dvec3 value;
};

/// Cuts shares into kShadowPoints strata of equal light; each has its place `shift` (in [0, 1)) of the way
/// through its light.
void cut(const std::vector<Share>& shares, double shift, std::vector<Stratum>& strata) {
    strata.clear();
    double total = 0;
    for (const Share& share : shares) total += mean(share.value);
    if (!(total > 0)) return;
    const double size = total / kShadowPoints;
    double filled = 0;  // of the last stratum
    const auto open = [&] {
        filled = 0;
        strata.push_back({0, glm::dvec3(0)});
    };
    open();
    for (const Share& share : shares) {
        const double light = mean(share.value);
        if (!(light > 0)) continue;
        double used = 0;
        while (used < light) {
            const bool last = strata.size() == kShadowPoints;
            const double rest = light - used;
            const double taken = last ? rest : std::min(rest, size - filled);
            if (filled <= shift * size) {
                const double way = std::clamp((used + shift * size - filled) / light, 0.0, 1.0);
                strata.back().place = glm::mix(share.begin, share.end, way);
            }
            strata.back().value += taken / light * share.value;
            filled += taken;
            if (last || taken == rest) {
                used = light;
            } else {
                used += taken;
            }
            if (!last && filled >= size) open();
        }
    }
}

/// All lights on the segments of a tile of pixels.
class TileLight {
public:
    TileLight(const scene::FrameScene& scene, const media::Media& media, const rays::RayScene& rays,
              const view::SegmentLayer& layer, std::span<glm::vec3> radiance)
        : scene_(scene),
          media_(media),
          rays_(rays),
          layer_(layer),
          radiance_(radiance),
          even_(std::none_of(scene.state.media.begin(), scene.state.media.end(),
                             [](const auto& medium) { return medium.type == scene::MediumType::grid; })) {}

    void add(std::size_t pixel) {
        for (std::uint32_t i = layer_.first[pixel]; i < layer_.first[pixel + 1]; ++i) {
            const Segment segment{glm::dvec3(layer_.origin[i]),
                                  glm::normalize(glm::dvec3(layer_.direction[i])),
                                  static_cast<double>(layer_.length[i]), layer_.in_water[i] != 0};
            cells_.find(media_, segment);
            if (cells_.cells.empty()) continue;
            const auto width = static_cast<std::size_t>(layer_.width);
            const double shift = dot(kShiftStep, glm::dvec2(pixel % width, pixel / width)) +
                                 static_cast<double>(layer_.sample) / scene_.state.clip.samples;
            const std::uint32_t piece = i - layer_.first[pixel];
            for (std::size_t light = 0; light < scene_.state.lights.size(); ++light) {
                if (light_in_water(scene_.state, scene_.state.lights[light]) == segment.in_water)
                    add(i, segment, light,
                        shift + hash_uniform(scene_.state.clip.seed, light, piece, kShiftDimension));
            }
        }
    }

    /// Tests what add() left to be tested.
    void finish() {
        std::vector<std::uint8_t> blocked(shadow_rays_.size(), 0);
        rays_.occluded_by_objects(shadow_rays_, blocked);
        for (std::size_t i = 0; i < blocked.size(); ++i) {
            if (!blocked[i]) radiance_[candidates_[i].segment] += candidates_[i].radiance;
        }
    }

private:
    struct Candidate {
        std::uint32_t segment;
        glm::vec3 radiance;
    };

    void add(std::uint32_t i, const Segment& segment, std::size_t index_of_light, double shift) {
        const scene::Light& source = scene_.state.lights[index_of_light];
        const int samples = scene_.state.clip.samples;
        LightOnSegment light(scene_, media_, source, sun_direction(source, layer_.sample, samples), segment,
                             source.type == scene::LightType::sun ? 0 : pixel_radius(i, source));
        if (light.singular()) return;
        shares_.clear();
        Quadrature quadrature(light, even_);
        for (const Cell& cell : cells_.cells)
            quadrature.add(cell, &cells_.densities[cell.first_density], shares_);
        if (!even_) dim(light);
        if (!rays_.has_objects()) {
            for (const Share& share : shares_) radiance_[i] += glm::vec3(share.value);
            return;
        }
        cut(shares_, glm::fract(shift), strata_);
        for (const Stratum& stratum : strata_) {
            const LightOnSegment::Way way = light.way(stratum.place);
            candidates_.push_back({i, glm::vec3(stratum.value)});
            shadow_rays_.push_back({glm::vec3(segment.at(stratum.place)), 0, glm::vec3(-way.direction),
                                    static_cast<float>(way.length * (1 - 1e-6))});
        }
    }

    /// By what is lost between light and segment: its optical depth is found in the middles of strata of
    /// equal light, and linear between.
    void dim(const LightOnSegment& light) {
        cut(shares_, 0.5, strata_);
        if (strata_.empty()) return;
        if (strata_.size() == 1) strata_.push_back(strata_.front());
        depths_.clear();
        for (const Stratum& stratum : strata_)
            depths_.push_back(light.depth(stratum.place, light.way(stratum.place)));
        std::size_t next = 1;
        for (Share& share : shares_) {
            const double place = 0.5 * (share.begin + share.end);
            while (next + 1 < strata_.size() && strata_[next].place < place) ++next;
            const double begin = strata_[next - 1].place, size = strata_[next].place - begin;
            const double way = size > 0 ? (place - begin) / size : 0.5;
            const glm::dvec3 depth = glm::mix(depths_[next - 1], depths_[next], way);
            share.value *= glm::exp(-glm::max(depth, glm::dvec3(0)));
        }
    }

    /// m: of the disc as large as the pixel where the segment passes the lamp.
    double pixel_radius(std::uint32_t i, const scene::Light& lamp) const {
        const glm::vec3 to_lamp = glm::vec3(lamp.position - scene_.origin) - layer_.origin[i];
        const float place = std::clamp(dot(to_lamp, layer_.direction[i]), 0.0f, layer_.length[i]);
        const glm::vec3 u = layer_.spread_u_origin[i] + place * layer_.spread_u_direction[i];
        const glm::vec3 v = layer_.spread_v_origin[i] + place * layer_.spread_v_direction[i];
        return std::sqrt(glm::one_over_pi<double>() * static_cast<double>(glm::length(glm::cross(u, v))));
    }

    const scene::FrameScene& scene_;
    const media::Media& media_;
    const rays::RayScene& rays_;
    const view::SegmentLayer& layer_;
    std::span<glm::vec3> radiance_;
    bool even_;
    SegmentCells cells_;
    std::vector<Share> shares_;
    std::vector<Stratum> strata_;
    std::vector<glm::dvec3> depths_;  ///< of the light's way to the strata's places
    std::vector<Candidate> candidates_;
    std::vector<rays::Ray> shadow_rays_;
};

}  // namespace

void add_volumetric_direct_light(const scene::FrameScene& scene, const media::Media& media,
                                 const rays::RayScene& rays, const view::SegmentLayer& segments,
                                 std::span<glm::vec3> radiance) {
    parallel_for(segments.first.size() - 1, kTile, [&](std::size_t begin, std::size_t end) {
        TileLight tile(scene, media, rays, segments, radiance);
        for (std::size_t pixel = begin; pixel < end; ++pixel) tile.add(pixel);
        tile.finish();
    });
}

}  // namespace dapple::render
