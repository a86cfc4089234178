#include "methods/adaptive_beams/bounded_beams.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/parallel.h"
#include "layout/beam_media.h"
#include "layout/beam_volume.h"
#include "media/phase.h"

namespace dapple::methods::adaptive_beams {
namespace {

static_assert(sizeof(layout::DrawnMedium) == 116);

constexpr std::size_t kTile = 1 << 12;
/// Of a beam's lattice of rays, along an edge.
constexpr std::uint32_t kMostCells = 8;
constexpr std::uint32_t kLeastPlaces = 2;  ///< on a ray

/// Rays of a lattice.
constexpr std::uint64_t lines_of(std::uint32_t cells) {
    return std::uint64_t{cells + 1} * (cells + 2) / 2;
}

bool is_lobes(scene::PhaseType type) {
    return type == scene::PhaseType::isotropic || type == scene::PhaseType::henyey_greenstein ||
           type == scene::PhaseType::two_lobe;
}

template <class T>
gpu::Buffer filled(gpu::Device& device, std::string_view name, const std::vector<T>& values) {
    gpu::Buffer buffer(device, name, std::max<std::size_t>(1, values.size()) * sizeof(T),
                       gpu::BufferMemory::device);
    std::copy(values.begin(), values.end(), buffer.as<T>().begin());
    return buffer;
}

std::vector<float> phase_values(const media::Media& media, std::vector<int>& first) {
    std::vector<float> values;
    for (std::size_t c = 0; c < media.components().size(); ++c) {
        const scene::PhaseFunction& function = *media.components()[c].phase;
        first.push_back(is_lobes(function.type) ? -1 : static_cast<int>(values.size()));
        if (first.back() < 0) continue;
        const media::Phase phase(function);
        for (std::size_t i = 0; i < layout::kPhaseValues; ++i) {
            const double place = static_cast<double>(i) / static_cast<double>(layout::kPhaseValues - 1);
            values.push_back(static_cast<float>(phase.at(1 - 2 * place * place * place * place)));
        }
    }
    return values;
}

}  // namespace

std::uint64_t least_column_bytes(std::size_t grids) {
    return lines_of(1) *
           (grids * MediaColumns::entry(kLeastPlaces) * sizeof(float) + sizeof(layout::MediaLine));
}

glm::vec3 lobes_of(const scene::PhaseFunction& phase) {
    if (phase.type == scene::PhaseType::isotropic) return {0, 0, 1};
    if (phase.type == scene::PhaseType::henyey_greenstein) return glm::dvec3(phase.anisotropy, 0, 1);
    if (phase.type == scene::PhaseType::two_lobe)
        return glm::dvec3(phase.anisotropy, phase.back_anisotropy, phase.forward_share);
    return {0, 0, -1};
}

PhaseTables::PhaseTables(gpu::Device& device, const media::Media& media)
    : values_(filled(device, "phase functions", phase_values(media, first_))) {}

gpu::Buffer BoundedSet::rays_of(gpu::Device& device, std::size_t first, std::size_t count) const {
    const auto begin = rays.begin() + static_cast<std::ptrdiff_t>(first);
    return filled(device, "rays of beams",
                  std::vector<layout::BeamRays>(begin, begin + static_cast<std::ptrdiff_t>(count)));
}

BoundedBeams::BoundedBeams(gpu::Device& device, std::uint64_t largest_buffer)
    : device_(device), largest_buffer_(largest_buffer), columns_(device) {}

void BoundedBeams::begin(const scene::FrameScene& scene, const media::Media& media, const PhaseTables& phases,
                         FrameStats& stats) {
    scene_ = &scene;
    media_ = &media;
    phases_ = &phases;
    sets_.clear();
    columns_.begin(scene, media, stats);
    for (const bool side : {false, true}) {
        rays_[side] = columns_.table(side);
        light_[side] = columns_.table(side, MediaColumns::kPlaces, false);
    }
}

std::uint32_t BoundedBeams::ray_entry() const {
    return std::max(rays_[0].entry, rays_[1].entry);
}

/// The lattices of rays of a set's beams.
struct BoundedBeams::Lattices {
    const BeamSet* set;
    std::vector<layout::BeamRays> beams;
    std::uint64_t count[kMostCells + 1] = {};  ///< of the beams that want so many cells
    std::uint32_t most = kMostCells;           ///< cells along an edge

    /// With so many cells at most.
    std::uint64_t lines(std::uint32_t cells) const {
        std::uint64_t sum = 0;
        for (std::uint32_t c = 1; c <= kMostCells; ++c) sum += count[c] * lines_of(std::min(c, cells));
        return sum;
    }
};

namespace {

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

}  // namespace

/// Cells of a set's beams, whose rays are then two voxels apart; none of beams that meet no grid.
BoundedBeams::Lattices BoundedBeams::wanted(const BeamSet& set) const {
    Lattices lattices{&set, std::vector<layout::BeamRays>(set.triangles.size(), layout::BeamRays{0, 0})};
    double voxel = 0;
    for (const ColumnTable::Column& column : light_[set.in_water].columns)
        if (column.places > 0) {
            const auto step = static_cast<double>(columns_.step(column.part));
            voxel = voxel > 0 ? std::min(voxel, step) : step;
        }
    if (!(voxel > 0)) return lattices;
    const auto meets_grid = [&](const glm::dvec3& origin, const glm::dvec3& direction, double length) {
        const std::vector<media::Part>& parts = media_->parts();
        for (std::size_t i = 0; i < parts.size(); ++i)
            if (parts[i].on(set.in_water) && !columns_.is_box(i) &&
                !parts[i].body.overlap(origin, direction, length).empty())
                return true;
        return false;
    };
    parallel_for(lattices.beams.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const BeamCorners corners(set, i);
            const auto cells = static_cast<std::uint32_t>(
                std::clamp(std::ceil(corners.width() / (2 * voxel)), 1.0, static_cast<double>(kMostCells)));
            bool meets = false;
            corners.visit_rays(set, cells,
                               [&](const glm::dvec3& origin, const glm::dvec3& direction, double to) {
                                   const double stretch = glm::length(direction);
                                   meets = meets || meets_grid(origin, direction / stretch, to * stretch);
                               });
            lattices.beams[i].cells = meets ? cells : 0;
        }
    });
    for (const layout::BeamRays& beam : lattices.beams) ++lattices.count[beam.cells];
    return lattices;
}

/// Chooses cells, fewer where there are very many rays, and then places on each, so that buffers can be bound
/// and all is within the budget; gives each beam its rays.
void BoundedBeams::thin_out(std::vector<Lattices>& all) {
    const auto entry = [&](const Lattices& l) {
        return light_[l.set->in_water].entry * std::uint64_t{sizeof(float)};
    };
    const auto largest = [&](const Lattices& l) {
        return l.lines(l.most) * std::max<std::uint64_t>(entry(l), sizeof(layout::MediaLine));
    };
    const auto total = [&](std::uint32_t most) {
        std::uint64_t sum = 0;
        for (const Lattices& l : all)
            sum += l.lines(std::min(most, l.most)) * (entry(l) + sizeof(layout::MediaLine));
        return sum;
    };
    for (Lattices& l : all)
        while (l.most > 1 && largest(l) > largest_buffer_) l.most /= 2;
    std::uint32_t most = kMostCells;
    while (most > 1 && total(most) > kLightColumnBytes) most /= 2;
    const auto too_much = [&] {
        return total(most) > kLightColumnBytes || std::any_of(all.begin(), all.end(), [&](const Lattices& l) {
                   return largest(l) > largest_buffer_;
               });
    };
    for (std::uint32_t places = MediaColumns::kPlaces / 2; places >= kLeastPlaces && too_much(); places /= 2)
        for (const bool side : {false, true}) light_[side] = columns_.table(side, places, false);
    for (Lattices& l : all) {
        l.most = std::min(most, l.most);
        std::uint32_t first = 0;
        for (layout::BeamRays& beam : l.beams) {
            beam = {first, std::min(beam.cells, l.most)};
            first += beam.cells > 0 ? static_cast<std::uint32_t>(lines_of(beam.cells)) : 0;
        }
    }
}

void BoundedBeams::write_lines(const Lattices& lattices, std::span<layout::MediaLine> lines) const {
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

gpu::Buffer BoundedBeams::media_of(const BeamSet& set) const {
    const ColumnTable &rays = rays_[set.in_water], &light = light_[set.in_water];
    const std::uint32_t head[] = {ray_entry(), light.entry};
    std::vector<layout::DrawnMedium> drawn;
    const auto& components = media_->components();
    const auto append = [&](std::size_t component) {
        layout::DrawnMedium& medium = drawn.emplace_back();
        medium.extinction = components[component].extinction;
        medium.scattering = components[component].scattering;
        medium.lobes = lobes_of(*components[component].phase);
        medium.phase_table = phases_->first(component);
    };
    for (std::size_t i = 0; i < rays.columns.size(); ++i) {
        const std::size_t part = rays.columns[i].part;
        append(media_->parts()[part].component);
        layout::DrawnMedium& medium = drawn.back();
        medium.step = columns_.step(part);
        medium.thickest = columns_.thickest(part);
        medium.steepest =
            2 * medium.thickest * std::max({medium.extinction.x, medium.extinction.y, medium.extinction.z});
        medium.ray_first = rays.columns[i].first;
        medium.ray_places = rays.columns[i].places;
        medium.light_first = light.columns[i].first;
        medium.light_places = light.columns[i].places;
        if (columns_.is_box(part)) {
            const media::Body::Place& place = media_->parts()[part].body.place();
            const glm::mat3 turn(place.turn * set.world_from_mesh);
            medium.turn_x = turn[0];
            medium.turn_y = turn[1];
            medium.turn_z = turn[2];
            medium.shift = place.shift;
        }
    }
    gpu::Buffer media(device_, "media", sizeof(head) + drawn.size() * sizeof(layout::DrawnMedium),
                      gpu::BufferMemory::device);
    std::copy_n(head, 2, media.as<std::uint32_t>().begin());
    std::memcpy(static_cast<std::byte*>(media.data()) + sizeof(head), drawn.data(),
                drawn.size() * sizeof(layout::DrawnMedium));
    return media;
}

std::vector<const BoundedSet*> BoundedBeams::add(std::span<const BeamSet> sets, FrameStats& stats) {
    auto pass = std::make_unique<ScopedPass>(stats, "columns of media");
    std::vector<const BoundedSet*> added(sets.size(), nullptr);
    std::vector<std::size_t> index;
    std::vector<Lattices> all;
    for (std::size_t i = 0; i < sets.size(); ++i) {
        if (sets[i].triangles.empty() || !media_->bounded(sets[i].in_water)) continue;
        index.push_back(i);
        all.push_back(wanted(sets[i]));
    }
    thin_out(all);
    pass.reset();
    for (std::size_t i = 0; i < all.size(); ++i) {
        pass = std::make_unique<ScopedPass>(stats, "columns of media");
        const BeamSet& set = *all[i].set;
        const ColumnTable& light = light_[set.in_water];
        const std::size_t count = all[i].lines(all[i].most);
        gpu::Buffer media = media_of(set);
        gpu::Buffer columns(device_, "columns along light",
                            std::max<std::uint64_t>(1, light.entry * count) * sizeof(float));
        std::optional<gpu::Buffer> lines;
        if (count > 0) {
            lines.emplace(device_, "rays of light", count * sizeof(layout::MediaLine),
                          gpu::BufferMemory::device);
            write_lines(all[i], lines->as<layout::MediaLine>());
        }
        added[index[i]] =
            &sets_.emplace_back(BoundedSet{std::move(media), std::move(columns), std::move(all[i].beams)});
        pass.reset();
        if (count == 0) continue;
        gpu::PassList passes(device_);
        columns_.add(passes, light, set.in_water, *lines, count, sets_.back().light_columns, light.entry);
        passes.run(stats);
    }
    return added;
}

RayColumns BoundedBeams::ray_columns(const view::SegmentLayer* segments, std::size_t first, std::size_t count,
                                     const view::Camera& camera, glm::dvec2 offset) const {
    // Without segments nothing looks columns up, but something must be bound.
    if (!segments) count = 0;
    RayColumns result{
        count,
        gpu::Buffer(device_, "camera rays", std::max<std::size_t>(1, count) * sizeof(layout::MediaLine),
                    gpu::BufferMemory::device),
        gpu::Buffer(device_, "columns along camera rays",
                    std::max<std::size_t>(1, count) * ray_entry() * sizeof(float))};
    const std::span<layout::MediaLine> lines = result.lines.as<layout::MediaLine>();
    const auto width = static_cast<std::size_t>(scene_->state.clip.width);
    parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            layout::MediaLine line{{}, {0, 1, 0}, 0, 0, 0};
            const std::size_t pixel = first + i;
            for (std::uint32_t k = segments->first[pixel]; k < segments->first[pixel + 1]; ++k) {
                if (!segments->primary[k]) continue;
                glm::dvec3 origin, direction;
                camera.ray(glm::dvec2(pixel % width, pixel / width) + offset, origin, direction);
                line = {origin - scene_->origin, direction, 0, segments->length[k],
                        segments->in_water[k] != 0 ? 1.0f : 0.0f};
                break;
            }
            lines[i] = line;
        }
    });
    return result;
}

void BoundedBeams::add_passes(gpu::PassList& passes, const RayColumns& columns) const {
    if (columns.count == 0) return;
    for (const bool side : {false, true})
        columns_.add(passes, rays_[side], side, columns.lines, columns.count, columns.values, ray_entry());
}

}  // namespace dapple::methods::adaptive_beams
