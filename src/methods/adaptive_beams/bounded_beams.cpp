#include "methods/adaptive_beams/bounded_beams.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>

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
    for (const bool side : {false, true}) rays_[side] = columns_.table(side);
}

std::uint32_t BoundedBeams::ray_entry() const {
    return std::max(rays_[0].entry, rays_[1].entry);
}

/// Rays of beams, and in `beams` which are whose: so many that they are two voxels apart, but `most` cells
/// along an edge; none of beams that meet no grid.
std::vector<layout::MediaLine> BoundedBeams::rays_of_beams(const BeamSet& set, double voxel,
                                                           std::uint32_t most,
                                                           std::vector<layout::BeamRays>& beams) const {
    const auto meets_grid = [&](const glm::dvec3& origin, const glm::dvec3& direction, double length) {
        const std::vector<media::Part>& parts = media_->parts();
        for (std::size_t i = 0; i < parts.size(); ++i)
            if (parts[i].on(set.in_water) && !columns_.is_box(i) &&
                !parts[i].body.overlap(origin, direction, length).empty())
                return true;
        return false;
    };
    const std::size_t tiles = (beams.size() + kTile - 1) / kTile;
    std::vector<std::vector<layout::MediaLine>> of_tile(tiles);
    parallel_for(beams.size(), kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<layout::MediaLine>& lines = of_tile[begin / kTile];
        for (std::size_t i = begin; i < end; ++i) {
            glm::dvec3 start[3], slope[3], stop[3];
            double length[3];
            for (int k = 0; k < 3; ++k) {
                const BeamSet::Vertex& v = set.vertices[set.triangles[i][k]];
                slope[k] = {v.slope_a, v.slope_b, 1};
                start[k] = glm::dvec3(v.a, v.b, 0) + static_cast<double>(v.start) * slope[k];
                length[k] = static_cast<double>(v.end) - static_cast<double>(v.start);
                stop[k] = start[k] + length[k] * slope[k];
            }
            double width = 0;
            for (int k = 0; k < 3; ++k)
                width = std::max({width, glm::distance(start[k], start[(k + 1) % 3]),
                                  glm::distance(stop[k], stop[(k + 1) % 3])});
            const auto cells = static_cast<std::uint32_t>(
                std::clamp(std::ceil(width / (2 * voxel)), 1.0, static_cast<double>(most)));
            const std::size_t first = lines.size();
            bool meets = false;
            for (std::uint32_t a = 0; a <= cells; ++a)
                for (std::uint32_t b = 0; a + b <= cells; ++b) {
                    const glm::dvec3 share = glm::dvec3(cells - a - b, a, b) / static_cast<double>(cells);
                    const auto mean = [&](const glm::dvec3(&of)[3]) {
                        return set.world_from_mesh * (share.x * of[0] + share.y * of[1] + share.z * of[2]);
                    };
                    const glm::dvec3 origin = mean(start), direction = mean(slope);
                    const double end_of_ray = share.x * length[0] + share.y * length[1] + share.z * length[2];
                    const double stretch = glm::length(direction);
                    meets = meets || meets_grid(origin, direction / stretch, end_of_ray * stretch);
                    lines.push_back(
                        {origin, direction, 0, static_cast<float>(end_of_ray), set.in_water ? 1.0f : 0.0f});
                }
            beams[i] = {static_cast<std::uint32_t>(first), meets ? cells : 0};
            if (!meets) lines.resize(first);
        }
    });
    std::vector<layout::MediaLine> all;
    for (std::size_t tile = 0; tile < tiles; ++tile) {
        for (std::size_t i = tile * kTile; i < std::min(beams.size(), (tile + 1) * kTile); ++i)
            beams[i].first += static_cast<std::uint32_t>(all.size());
        all.insert(all.end(), of_tile[tile].begin(), of_tile[tile].end());
    }
    return all;
}

const BoundedSet& BoundedBeams::add(const BeamSet& set, FrameStats& stats) {
    auto pass = std::make_unique<ScopedPass>(stats, "columns of media");
    // Where there are very many rays, fewer of them, and then fewer places on each.
    ColumnTable light = columns_.table(set.in_water, MediaColumns::kPlaces, false);
    double voxel = 0;
    for (const ColumnTable::Column& column : light.columns)
        if (column.places > 0) {
            const auto step = static_cast<double>(columns_.step(column.part));
            voxel = voxel > 0 ? std::min(voxel, step) : step;
        }
    std::vector<layout::BeamRays> beams(set.triangles.size(), layout::BeamRays{0, 0});
    std::vector<layout::MediaLine> lines;
    const auto bytes = [&](std::size_t count) { return std::uint64_t{light.entry} * count * sizeof(float); };
    for (std::uint32_t most = kMostCells; most > 0 && voxel > 0; most /= 2) {
        lines = rays_of_beams(set, voxel, most, beams);
        if (bytes(lines.size()) <= largest_buffer_) break;
    }
    for (std::uint32_t places = MediaColumns::kPlaces / 2;
         places >= 2 && bytes(lines.size()) > largest_buffer_; places /= 2)
        light = columns_.table(set.in_water, places, false);

    const ColumnTable& rays = rays_[set.in_water];
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
    BoundedSet& added = sets_.emplace_back(
        BoundedSet{std::move(media),
                   gpu::Buffer(device_, "columns along light",
                               std::max<std::uint64_t>(bytes(lines.size()), sizeof(float))),
                   std::move(beams)});
    const gpu::Buffer uploaded = filled(device_, "rays of light", lines);
    pass.reset();
    if (lines.empty()) return added;
    gpu::PassList passes(device_);
    columns_.add(passes, light, set.in_water, uploaded, lines.size(), added.light_columns, light.entry);
    passes.run(stats);
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
