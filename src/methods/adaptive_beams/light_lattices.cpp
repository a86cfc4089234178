#include "methods/adaptive_beams/light_lattices.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr std::size_t kTile = 1 << 12;
constexpr double kVoxelsApart = 2;         ///< of the rays of a beam
constexpr std::uint32_t kLeastPlaces = 2;  ///< on a ray

/// Rays of a lattice.
constexpr std::uint64_t lines_of(std::uint32_t cells) {
    return std::uint64_t{cells + 1} * (cells + 2) / 2;
}

/// The three rays of a beam, from its surface to its end, in the axes of its set.
struct BeamCorners {
    glm::dvec3 start[3], slope[3];
    double length[3];

    BeamCorners(const BeamSet& set, std::size_t beam) {
        for (int k = 0; k < 3; ++k) {
            const BeamSet::Vertex& v = set.vertices[set.triangles[beam][k]];
            slope[k] = {v.slope_a, v.slope_b, 1};
            start[k] = glm::dvec3(v.a, v.b, 0) + static_cast<double>(v.start) * slope[k];
            length[k] = static_cast<double>(v.end) - static_cast<double>(v.start);
        }
    }
    double width() const {
        double widest = 0;
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3;
            widest = std::max(
                {widest, glm::distance(start[k], start[next]),
                 glm::distance(start[k] + length[k] * slope[k], start[next] + length[next] * slope[next])});
        }
        return widest;
    }
    /// Visits the rays of its lattice, in the order of layout::BeamRays: origin and direction in the world,
    /// and the depth at which the ray ends.
    template <class Visit>
    void visit_rays(const BeamSet& set, std::uint32_t cells, Visit&& visit) const {
        for (std::uint32_t a = 0; a <= cells; ++a)
            for (std::uint32_t b = 0; a + b <= cells; ++b) {
                const glm::dvec3 share = glm::dvec3(cells - a - b, a, b) / static_cast<double>(cells);
                const auto mean = [&](const glm::dvec3(&of)[3]) {
                    return set.world_from_mesh * (share.x * of[0] + share.y * of[1] + share.z * of[2]);
                };
                visit(mean(start), mean(slope),
                      share.x * length[0] + share.y * length[1] + share.z * length[2]);
            }
    }
};

std::uint32_t capped(std::uint32_t cells) {
    return std::min(cells, LightLattices::kMostCells);
}

}  // namespace

std::uint64_t least_column_bytes(std::size_t grids) {
    return lines_of(1) *
           (grids * MediaColumns::entry(kLeastPlaces) * sizeof(float) + sizeof(layout::MediaLine));
}

std::uint64_t LightLattices::lines(std::uint32_t cells) const {
    std::uint64_t sum = 0;
    for (std::uint32_t c = 1; c <= kMostCells; ++c) sum += count[c] * lines_of(std::min(c, cells));
    return sum;
}

LightLattices light_lattices(const BeamSet& set, const media::Media& media, const MediaColumns& columns,
                             std::vector<double>& voxels) {
    const std::size_t beams = set.triangles.size();
    LightLattices lattices{&set, std::vector<layout::BeamRays>(beams, layout::BeamRays{0, 0}),
                           std::vector<float>(beams, 0)};
    std::vector<std::size_t> grids;
    double voxel = 0;
    for (std::size_t part = 0; part < media.parts().size(); ++part) {
        if (!media.parts()[part].on(set.in_water) || columns.is_box(part)) continue;
        const auto step = static_cast<double>(columns.step(part));
        voxel = voxel > 0 ? std::min(voxel, step) : step;
        grids.push_back(part);
    }
    if (!(voxel > 0)) return lattices;
    std::vector<std::vector<double>> crossed(beams / kTile + 1, std::vector<double>(voxels.size(), 0));
    parallel_for(beams, kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<double>& most = crossed[begin / kTile];
        for (std::size_t i = begin; i < end; ++i) {
            const BeamCorners corners(set, i);
            const auto cells = static_cast<std::uint32_t>(
                std::clamp(std::ceil(corners.width() / (kVoxelsApart * voxel)), 1.0, 1e6));
            double of_beam = 0;
            corners.visit_rays(
                set, capped(cells), [&](const glm::dvec3& origin, const glm::dvec3& direction, double to) {
                    const double stretch = glm::length(direction);
                    for (const std::size_t part : grids) {
                        const double on_ray = columns.voxels(part, origin, direction / stretch, to * stretch);
                        most[part] = std::max(most[part], on_ray);
                        of_beam = std::max(of_beam, on_ray);
                    }
                });
            lattices.beams[i].cells = of_beam > 0 ? cells : 0;
            lattices.voxels[i] = static_cast<float>(of_beam);
        }
    });
    for (const std::vector<double>& tile : crossed)
        for (std::size_t part = 0; part < voxels.size(); ++part)
            voxels[part] = std::max(voxels[part], tile[part]);
    for (const layout::BeamRays& beam : lattices.beams) ++lattices.count[capped(beam.cells)];
    return lattices;
}

LightTables thin_out(std::span<LightLattices> all, const MediaColumns& columns, const VoxelsCrossed& voxels,
                     std::uint64_t largest_buffer) {
    LightTables result;
    double most_voxels = 0;
    for (const std::vector<double>& side : voxels)
        for (const double part : side) most_voxels = std::max(most_voxels, part);
    std::uint32_t places = MediaColumns::places(most_voxels), cells = LightLattices::kMostCells;
    const auto lay_out = [&] {
        for (const bool side : {false, true})
            result.tables[side] = columns.table(side, voxels[side], places, false);
    };
    const auto entry = [&](const LightLattices& l) {
        return result.tables[l.set->in_water].entry * std::uint64_t{sizeof(float)};
    };
    const auto is_large = [&](const LightLattices& l) {
        return l.lines() * std::max<std::uint64_t>(entry(l), sizeof(layout::MediaLine)) > largest_buffer;
    };
    const auto too_much = [&] {
        std::uint64_t sum = 0;
        for (const LightLattices& l : all) sum += l.lines() * (entry(l) + sizeof(layout::MediaLine));
        return sum > kLightColumnBytes;
    };
    // In voxels, places stay as near to each other as rays.
    const auto has_places_to_spare = [&] {
        const double across = kVoxelsApart * LightLattices::kMostCells / cells;
        return places > kLeastPlaces && (cells == 1 || 2 * most_voxels <= across * places);
    };
    const auto halve_cells = [&](const auto& which) {
        bool any = false;
        for (LightLattices& l : all) {
            if (l.most == 1 || !which(l)) continue;
            l.most /= 2;
            any = true;
        }
        return any;
    };
    lay_out();
    for (;;) {
        const bool much = too_much();
        if (!much && std::none_of(all.begin(), all.end(), is_large)) break;
        if (!has_places_to_spare()) {
            if (much && cells > 1) {
                cells /= 2;
                halve_cells([&](const LightLattices& l) { return l.most > cells; });
                continue;
            }
            if (halve_cells(is_large)) continue;
            if (places == kLeastPlaces) break;
        }
        places = std::max(kLeastPlaces, (places + 1) / 2);
        lay_out();
    }
    for (LightLattices& l : all) {
        std::uint32_t first = 0;
        for (std::size_t i = 0; i < l.beams.size(); ++i) {
            layout::BeamRays& beam = l.beams[i];
            if (beam.cells == 0) continue;
            result.thinned +=
                beam.cells > l.most || std::ceil(static_cast<double>(l.voxels[i])) + 1 > places ? 1 : 0;
            beam = {first, std::min(beam.cells, l.most)};
            first += static_cast<std::uint32_t>(lines_of(beam.cells));
        }
    }
    return result;
}

void write_lines(const LightLattices& lattices, std::span<layout::MediaLine> lines) {
    const BeamSet& set = *lattices.set;
    parallel_for(lattices.beams.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (lattices.beams[i].cells == 0) continue;
            std::size_t at = lattices.beams[i].first;
            BeamCorners(set, i).visit_rays(
                set, lattices.beams[i].cells,
                [&](const glm::dvec3& origin, const glm::dvec3& direction, double to) {
                    lines[at++] = {origin, direction, 0, static_cast<float>(to), set.in_water ? 1.0f : 0.0f};
                });
        }
    });
}

}  // namespace dapple::methods::adaptive_beams
