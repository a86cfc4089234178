#include "render/volumetric_light.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <optional>
#include <vector>

#include "base/hash.h"
#include "base/parallel.h"
#include "render/light_quadrature.h"
#include "render/shading.h"
#include "render/sun_depths.h"
#include "render/way_depths.h"
#include "scene/area_light.h"

namespace dapple::render {
namespace {

constexpr std::size_t kTile = 256;  ///< pixels
/// Of hash_uniform, by lights and pieces of a path.
constexpr std::uint32_t kShiftDimension = 0x766c0000;

double mean(const glm::dvec3& color) {
    return (color.x + color.y + color.z) / 3;
}

bool has_grids(const scene::FrameScene& scene) {
    return std::any_of(scene.state.media.begin(), scene.state.media.end(),
                       [](const scene::Medium& medium) { return medium.type == scene::MediumType::grid; });
}

/// A place of a segment, with the light that shares its shadow.
struct Stratum {
    double place;
    glm::dvec3 value;
};

/// Cuts shares into kShadowPoints strata of equal light; each has its place `shift` (in [0, 1)) of the way
/// through its light.
void cut(const std::vector<LightShare>& shares, double shift, std::vector<Stratum>& strata) {
    strata.clear();
    double total = 0;
    for (const LightShare& share : shares) total += mean(share.value);
    if (!(total > 0)) return;
    const double size = total / kShadowPoints;
    double filled = 0;  // of the last stratum
    const auto open = [&] {
        filled = 0;
        strata.push_back({0, glm::dvec3(0)});
    };
    open();
    for (const LightShare& share : shares) {
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
              const std::vector<light::SpotPicture>& pictures, const view::SegmentLayer& layer,
              const std::vector<std::optional<SunDepths>>& sun_depths, std::span<glm::vec3> radiance)
        : scene_(scene),
          media_(media),
          rays_(rays),
          pictures_(pictures),
          layer_(layer),
          sun_depths_(sun_depths),
          radiance_(radiance),
          even_(!has_grids(scene)) {}

    void add(std::size_t pixel) {
        for (std::uint32_t i = layer_.first[pixel]; i < layer_.first[pixel + 1]; ++i) {
            const Segment segment{glm::dvec3(layer_.origin[i]),
                                  glm::normalize(glm::dvec3(layer_.direction[i])),
                                  static_cast<double>(layer_.length[i]), layer_.in_water[i] != 0};
            cells_.find(media_, segment);
            if (cells_.cells.empty()) continue;
            const auto width = static_cast<std::size_t>(layer_.width);
            // Pixels to the right and below fill each other's gaps.
            const double shift = dot(kEvenStep, glm::dvec2(pixel % width, pixel / width)) +
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
        for (const Cell& cell : cells_.cells)
            add_light_of_cell(light, cell, &cells_.densities[cell.first_density], even_, shares_);
        if (pictures_[index_of_light].exists()) add_picture(pictures_[index_of_light], light, shares_);
        if (sun_depths_[index_of_light])
            dim(segment, *sun_depths_[index_of_light]);
        else if (!even_)
            way_depths_.dim(light, shares_);
        if (!rays_.has_objects()) {
            for (const LightShare& share : shares_) radiance_[i] += glm::vec3(share.value);
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

    /// By what is lost between the sun and the segment, share by share.
    void dim(const Segment& segment, const SunDepths& depths) {
        for (LightShare& share : shares_)
            share.value *= glm::exp(-depths.depth(segment.at(0.5 * (share.begin + share.end))));
    }

    /// m: of the disc as large as the pixel where the segment passes the lamp, and as the part of an area
    /// light that the lamp is.
    double pixel_radius(std::uint32_t i, const scene::Light& lamp) const {
        const glm::vec3 to_lamp = glm::vec3(lamp.position - scene_.origin) - layer_.origin[i];
        const float place = std::clamp(dot(to_lamp, layer_.direction[i]), 0.0f, layer_.length[i]);
        const glm::vec3 u = layer_.spread_u_origin[i] + place * layer_.spread_u_direction[i];
        const glm::vec3 v = layer_.spread_v_origin[i] + place * layer_.spread_v_direction[i];
        double area = static_cast<double>(glm::length(glm::cross(u, v)));
        if (lamp.part.count > 0) area += scene::emitter_area(lamp) / lamp.part.count;
        return std::sqrt(glm::one_over_pi<double>() * area);
    }

    const scene::FrameScene& scene_;
    const media::Media& media_;
    const rays::RayScene& rays_;
    const std::vector<light::SpotPicture>& pictures_;
    const view::SegmentLayer& layer_;
    const std::vector<std::optional<SunDepths>>& sun_depths_;  ///< a light: where they cost little
    std::span<glm::vec3> radiance_;
    bool even_;
    SegmentCells cells_;
    std::vector<LightShare> shares_;
    std::vector<Stratum> strata_;
    WayDepths way_depths_;
    std::vector<Candidate> candidates_;
    std::vector<rays::Ray> shadow_rays_;
};

}  // namespace

void add_volumetric_direct_light(const scene::FrameScene& scene, const media::Media& media,
                                 const rays::RayScene& rays, const view::SegmentLayer& segments,
                                 std::span<glm::vec3> radiance) {
    const std::vector<light::SpotPicture> pictures = light::spot_pictures(scene);
    std::vector<std::optional<SunDepths>> sun_depths(scene.state.lights.size());
    for (std::size_t i = 0; i < sun_depths.size(); ++i) {
        const scene::Light& light = scene.state.lights[i];
        if (light.type != scene::LightType::sun || !has_grids(scene)) continue;
        sun_depths[i].emplace(media, sun_direction(light, segments.sample, scene.state.clip.samples));
        if (!sun_depths[i]->fits()) sun_depths[i].reset();
    }
    parallel_for(segments.first.size() - 1, kTile, [&](std::size_t begin, std::size_t end) {
        TileLight tile(scene, media, rays, pictures, segments, sun_depths, radiance);
        for (std::size_t pixel = begin; pixel < end; ++pixel) tile.add(pixel);
        tile.finish();
    });
}

}  // namespace dapple::render
