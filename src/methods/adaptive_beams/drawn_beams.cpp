#include "methods/adaptive_beams/drawn_beams.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>

#include "base/parallel.h"
#include "methods/adaptive_beams/ring_areas.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr std::size_t kTile = 256;
constexpr std::size_t kCorners = 6, kFaces = 8;

glm::dvec2 at(const BeamSet::Vertex& ray, double depth) {
    return {ray.a + depth * static_cast<double>(ray.slope_a),
            ray.b + depth * static_cast<double>(ray.slope_b)};
}

std::array<glm::dvec2, 3> at(const std::array<BeamSet::Vertex, 3>& rays, double depth) {
    return {at(rays[0], depth), at(rays[1], depth), at(rays[2], depth)};
}

/// Mean length of the edges.
double width(const std::array<glm::dvec2, 3>& t) {
    return (glm::distance(t[0], t[1]) + glm::distance(t[1], t[2]) + glm::distance(t[2], t[0])) / 3;
}

/// The first start and the last end.
std::pair<double, double> depths(const std::array<BeamSet::Vertex, 3>& rays) {
    return {std::min({rays[0].start, rays[1].start, rays[2].start}),
            std::max({rays[0].end, rays[1].end, rays[2].end})};
}

glm::vec4 drawn(const AreaFunction& area) {
    return {area.q, area.middle};
}

class Builder {
public:
    Builder(const BeamSet& set, const view::Camera& camera, const glm::dvec3& origin, VolumeKind kind,
            double reach)
        : set_(set),
          kind_(kind),
          reach_(reach),
          areas_(set),
          pixel_from_mesh_(camera.pixel_from_world() * glm::translate(glm::dmat4(1), origin) *
                           glm::dmat4(set.world_from_mesh)) {
        // The camera's own axes: pixels are w times this wide.
        const glm::dmat4 pixel_from_camera =
            camera.pixel_from_world() * glm::inverse(camera.camera_from_world());
        pixel_size_ = 1 / std::abs(pixel_from_camera[0][0]);
        beams_.beams.resize(set.triangles.size());
        beams_.corners.resize(kCorners * set.triangles.size());
        beams_.indices.resize(3 * kFaces * set.triangles.size());
    }

    DrawnBeams build() {
        const std::size_t count = set_.triangles.size();
        std::vector<std::size_t> prisms(count / kTile + 1, 0);
        parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                if (!add(i)) ++prisms[begin / kTile];
        });
        for (const std::size_t tile : prisms) beams_.prisms += tile;
        list_turning();
        sort_indices();
        return std::move(beams_);
    }

private:
    /// m: of so many pixels at the farthest of the rays' points there, along planes of constant depth.
    double margin(const std::array<BeamSet::Vertex, 3>& rays, double depth, double pixels) const {
        double farthest = 0, steepest = 0;
        for (const BeamSet::Vertex& ray : rays) {
            const double w = (pixel_from_mesh_ * glm::dvec4(at(ray, depth), depth, 1)).w;
            farthest = std::max(farthest, std::abs(w));
            steepest = std::max(steepest, glm::length(glm::dvec2(ray.slope_a, ray.slope_b)));
        }
        return pixels * pixel_size_ * farthest * std::hypot(1, steepest);
    }

    std::array<BeamSet::Vertex, 3> rays_of(std::size_t beam) const {
        const glm::uvec3 triangle = set_.triangles[beam];
        return {set_.vertices[triangle.x], set_.vertices[triangle.y], set_.vertices[triangle.z]};
    }

    /// Lists for each beam the triangles of its corners' rings that turn over.
    void list_turning() {
        const std::size_t count = set_.triangles.size();
        std::vector<std::vector<layout::TurningArea>> lists(count / kTile + 1);
        parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
            std::vector<layout::TurningArea>& list = lists[begin / kTile];
            std::vector<std::pair<std::uint32_t, std::uint32_t>> found;  // triangle, corner
            for (std::size_t i = begin; i < end; ++i) {
                found.clear();
                for (int k = 0; k < 3; ++k) {
                    const std::uint32_t v = set_.triangles[i][k];
                    for (std::uint32_t j = areas_.first[v]; j < areas_.first[v + 1]; ++j)
                        found.emplace_back(areas_.turning[j], 1u << k);
                }
                std::sort(found.begin(), found.end());
                layout::DrawnBeam& beam = beams_.beams[i];
                const auto [from, to] = depths(rays_of(i));
                beam.first = static_cast<std::uint32_t>(list.size());
                for (std::size_t j = 0; j < found.size(); ++j) {
                    if (j > 0 && found[j].first == found[j - 1].first) {
                        list.back().corners |= found[j].second;
                    } else {
                        const AreaFunction area = area_function(set_, set_.triangles[found[j].first], from);
                        list.push_back({drawn(area.about_least(from, to)), found[j].second});
                    }
                }
                beam.last = static_cast<std::uint32_t>(list.size());
            }
        });
        for (std::size_t tile = 0; tile < lists.size(); ++tile) {
            const auto before = static_cast<std::uint32_t>(beams_.turning.size());
            for (std::size_t i = tile * kTile; i < std::min(count, (tile + 1) * kTile); ++i) {
                beams_.beams[i].first += before;
                beams_.beams[i].last += before;
            }
            beams_.turning.insert(beams_.turning.end(), lists[tile].begin(), lists[tile].end());
        }
    }

    void sort_indices() {
        constexpr std::size_t kBeamIndices = 3 * kFaces;
        std::vector<std::uint32_t> sorted;
        sorted.reserve(beams_.indices.size());
        for (const bool listed : {false, true}) {
            for (std::size_t i = 0; i < beams_.beams.size(); ++i) {
                if ((beams_.beams[i].first != beams_.beams[i].last) != listed) continue;
                const auto from = beams_.indices.begin() + static_cast<std::ptrdiff_t>(kBeamIndices * i);
                sorted.insert(sorted.end(), from, from + kBeamIndices);
            }
            if (!listed) beams_.plain = sorted.size() / kBeamIndices;
        }
        beams_.indices = std::move(sorted);
    }

    /// Whether its volume is of the kind that is wanted.
    bool add(std::size_t i) {
        const glm::uvec3 triangle = set_.triangles[i];
        const std::array<BeamSet::Vertex, 3> rays = rays_of(i);
        const auto [start, end] = depths(rays);
        const double start_bias = kLeastBias + kBiasOfWidth * width(at(rays, start));
        const double end_bias = kLeastBias + kBiasOfWidth * width(at(rays, end));
        layout::DrawnBeam& beam = beams_.beams[i];
        for (int k = 0; k < 3; ++k) {
            const BeamSet::Vertex& ray = rays[static_cast<std::size_t>(k)];
            const std::uint32_t v = triangle[k];
            beam.ray[k] = {ray.a, ray.b, ray.slope_a, ray.slope_b};
            beam.start[k] = ray.start;
            beam.end[k] = ray.end;
            beam.area[k] = drawn(areas_.even[v]);
            beam.flux[k] = areas_.flux[v];
        }
        beam.own_flux = set_.flux[i];
        beam.start_bias = static_cast<float>(start_bias);
        beam.end_bias = static_cast<float>(end_bias);
        beam.ends_on = set_.ends_on[i];

        BeamSection section;
        section.near_depth = start - start_bias;
        section.far_depth = end + end_bias;
        const double reach = margin(rays, section.far_depth, kMarginPixels + reach_);
        // What is lit lies between the first and the last end, where volumes are as wide as that takes. Where
        // all ends are far from the start they are narrow there.
        const double first_end = std::min({rays[0].end, rays[1].end, rays[2].end});
        const bool narrows = first_end - section.near_depth > 0.5 * (section.far_depth - section.near_depth);
        section.near_margin = margin(rays, section.near_depth, kMarginPixels + (narrows ? 0 : reach_));
        section.near_depth -= section.near_margin;
        section.far_depth += reach;
        section.far_margin = reach;
        if (narrows)
            section.far_margin *= (section.far_depth - section.near_depth) / (first_end - section.near_depth);
        section.near = at(rays, section.near_depth);
        section.far = at(rays, section.far_depth);
        const BoundingVolume volume = bounding_volume(section, kind_);
        for (std::size_t k = 0; k < kCorners; ++k) {
            const glm::dvec4 pixel = pixel_from_mesh_ * glm::dvec4(volume.corner[k], 1);
            beams_.corners[kCorners * i + k] = {pixel.x, pixel.y, pixel.w};
        }
        auto index = beams_.indices.begin() + static_cast<std::ptrdiff_t>(3 * kFaces * i);
        for (const auto& face : volume.face)
            for (const std::uint8_t corner : face)
                *index++ = static_cast<std::uint32_t>(kCorners * i + corner);
        return volume.kind == kind_;
    }

    const BeamSet& set_;
    VolumeKind kind_;
    double reach_;  ///< pixels
    RingAreas areas_;
    glm::dmat4 pixel_from_mesh_;
    double pixel_size_ = 0;  ///< m at w = 1
    DrawnBeams beams_;
};

}  // namespace

DrawnBeams drawn_beams(const BeamSet& set, const view::Camera& camera, const glm::dvec3& origin,
                       VolumeKind kind, double reach) {
    return Builder(set, camera, origin, kind, reach).build();
}

std::vector<DrawnBeams> parts_of(DrawnBeams drawn, std::uint64_t largest) {
    constexpr std::size_t kBeamIndices = 3 * kFaces;
    const std::size_t count = drawn.beams.size();
    // The corners of a beam are smaller than the beam.
    const std::size_t most =
        std::max<std::size_t>(1, std::min<std::uint64_t>(largest / sizeof(layout::DrawnBeam), count));
    const std::size_t most_turning = largest / sizeof(layout::TurningArea);
    std::vector<DrawnBeams> parts;
    if (count <= most && drawn.turning.size() <= most_turning) {
        parts.push_back(std::move(drawn));
        return parts;
    }
    const auto slice = [](const auto& values, std::size_t from, std::size_t to) {
        return std::vector(values.begin() + static_cast<std::ptrdiff_t>(from),
                           values.begin() + static_cast<std::ptrdiff_t>(to));
    };
    // Of beams without and with listed triangles.
    std::size_t index = 0, listed_index = kBeamIndices * drawn.plain;
    for (std::size_t first = 0, last = 0; first < count; first = last) {
        const std::uint32_t turning = drawn.beams[first].first;
        last = first + 1;
        while (last < count && last - first < most && drawn.beams[last].last - turning <= most_turning)
            ++last;
        DrawnBeams& part = parts.emplace_back();
        part.beams = slice(drawn.beams, first, last);
        part.corners = slice(drawn.corners, kCorners * first, kCorners * last);
        part.turning = slice(drawn.turning, turning, drawn.beams[last - 1].last);
        const auto take = [&](std::size_t& next, std::size_t end) {
            for (; next < end && drawn.indices[next] < kCorners * last; ++next)
                part.indices.push_back(static_cast<std::uint32_t>(drawn.indices[next] - kCorners * first));
        };
        take(index, kBeamIndices * drawn.plain);
        part.plain = part.indices.size() / kBeamIndices;
        take(listed_index, drawn.indices.size());
        for (layout::DrawnBeam& beam : part.beams) {
            beam.first -= turning;
            beam.last -= turning;
        }
    }
    return parts;
}

}  // namespace dapple::methods::adaptive_beams
