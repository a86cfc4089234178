#include "methods/adaptive_beams/bounded_beams.h"

#include <algorithm>
#include <cmath>
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

static_assert(sizeof(layout::DrawnMedium) == 112);

constexpr std::size_t kTile = 1 << 12;
constexpr std::size_t kHead = 2;  ///< words before the media that are drawn

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
}

std::uint32_t BoundedBeams::ray_entry() const {
    return std::max(rays_[0].entry, rays_[1].entry);
}

std::size_t BoundedBeams::media_bytes(bool in_water) const {
    return kHead * sizeof(std::uint32_t) +
           light_.tables[in_water].columns.size() * sizeof(layout::DrawnMedium);
}

void BoundedBeams::write_media(BoundedSet& bounded) const {
    const BeamSet& set = *bounded.set;
    const ColumnTable &rays = rays_[set.in_water], &light = light_.tables[set.in_water];
    const std::uint32_t head[kHead] = {ray_entry(), light.entry};
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
        medium.light_first = light.columns[i].first;
        medium.in_light = light.columns[i].places > 0 ? 1 : 0;
        if (columns_.is_box(part)) {
            const media::Body::Place& place = media_->parts()[part].body.place();
            const glm::mat3 turn(place.turn * set.world_from_mesh);
            medium.turn_x = turn[0];
            medium.turn_y = turn[1];
            medium.turn_z = turn[2];
            medium.shift = place.shift;
        }
    }
    std::copy_n(head, kHead, bounded.media.as<std::uint32_t>().begin());
    std::memcpy(static_cast<std::byte*>(bounded.media.data()) + sizeof(head), drawn.data(),
                drawn.size() * sizeof(layout::DrawnMedium));
}

std::vector<const BoundedSet*> BoundedBeams::add(std::span<const BeamSet> sets, FrameStats& stats) {
    auto pass = std::make_unique<ScopedPass>(stats, "columns of media");
    std::vector<const BoundedSet*> added(sets.size(), nullptr);
    std::vector<std::size_t> index;
    std::vector<LightLattices> all;
    VoxelsCrossed voxels;
    voxels.fill(std::vector<double>(media_->parts().size(), 0));
    for (std::size_t i = 0; i < sets.size(); ++i) {
        if (sets[i].triangles.empty() || !media_->bounded(sets[i].in_water)) continue;
        index.push_back(i);
        all.push_back(light_lattices(sets[i], *media_, columns_, voxels[sets[i].in_water]));
    }
    light_ = thin_out(all, columns_, voxels, largest_buffer_);
    if (light_.thinned > 0) stats.count("beams with thinned columns", static_cast<double>(light_.thinned));
    pass.reset();
    for (std::size_t i = 0; i < all.size(); ++i) {
        pass = std::make_unique<ScopedPass>(stats, "columns of media");
        const BeamSet& set = *all[i].set;
        const ColumnTable& light = light_.tables[set.in_water];
        const std::size_t count = all[i].lines();
        gpu::Buffer media(device_, "media", media_bytes(set.in_water), gpu::BufferMemory::device);
        gpu::Buffer columns(device_, "columns along light",
                            std::max<std::uint64_t>(1, light.entry * count) * sizeof(float));
        std::optional<gpu::Buffer> lines;
        if (count > 0) {
            lines.emplace(device_, "rays of light", count * sizeof(layout::MediaLine),
                          gpu::BufferMemory::device);
            write_lines(all[i], lines->as<layout::MediaLine>());
        }
        added[index[i]] = &sets_.emplace_back(
            BoundedSet{&set, std::move(media), std::move(columns), std::move(all[i].beams)});
        pass.reset();
        if (count == 0) continue;
        gpu::PassList passes(device_);
        columns_.add(passes, light, set.in_water, *lines, count, sets_.back().light_columns, light.entry);
        passes.run(stats);
    }
    return added;
}

layout::MediaLine BoundedBeams::camera_line(const PictureRays& picture, std::size_t pixel) const {
    const view::SegmentLayer& segments = *picture.segments;
    const auto width = static_cast<std::size_t>(scene_->state.clip.width);
    for (std::uint32_t k = segments.first[pixel]; k < segments.first[pixel + 1]; ++k) {
        if (!segments.primary[k]) continue;
        glm::dvec3 origin, direction;
        picture.camera->ray(glm::dvec2(pixel % width, pixel / width) + picture.offset, origin, direction);
        return {origin - scene_->origin, direction, 0, segments.length[k],
                segments.in_water[k] != 0 ? 1.0f : 0.0f};
    }
    return {{}, {0, 1, 0}, 0, 0, 0};
}

void BoundedBeams::look_along(const PictureRays& picture, FrameStats& stats) {
    const ScopedPass pass(stats, "columns of media");
    const std::vector<media::Part>& parts = media_->parts();
    const std::size_t pixels = picture.segments ? picture.segments->first.size() - 1 : 0;
    /// Of a tile of pixels.
    struct Crossed {
        VoxelsCrossed voxels;
        std::size_t thinned = 0;
    };
    Crossed all;
    all.voxels.fill(std::vector<double>(parts.size(), 0));
    std::vector<Crossed> tiles(pixels / kTile + 1, all);
    parallel_for(pixels, kTile, [&](std::size_t begin, std::size_t end) {
        Crossed& tile = tiles[begin / kTile];
        for (std::size_t pixel = begin; pixel < end; ++pixel) {
            const layout::MediaLine line = camera_line(picture, pixel);
            const bool in_water = line.in_water > 0;
            bool thinned = false;
            for (std::size_t part = 0; part < parts.size(); ++part) {
                if (!parts[part].on(in_water)) continue;
                const double voxels =
                    columns_.voxels(part, line.origin, line.direction, static_cast<double>(line.end));
                double& most = tile.voxels[in_water][part];
                most = std::max(most, voxels);
                thinned = thinned || std::ceil(voxels) + 1 > MediaColumns::kMostPlaces;
            }
            tile.thinned += thinned ? 1 : 0;
        }
    });
    for (const Crossed& tile : tiles) {
        all.thinned += tile.thinned;
        for (const bool side : {false, true})
            for (std::size_t part = 0; part < parts.size(); ++part)
                all.voxels[side][part] = std::max(all.voxels[side][part], tile.voxels[side][part]);
    }
    if (all.thinned > 0) stats.count("camera rays with thinned columns", static_cast<double>(all.thinned));
    for (const bool side : {false, true}) rays_[side] = columns_.table(side, all.voxels[side]);
    for (BoundedSet& set : sets_) write_media(set);
}

RayColumns BoundedBeams::ray_columns(const PictureRays& picture, std::size_t first, std::size_t count) const {
    // Without segments nothing looks columns up, but something must be bound.
    if (!picture.segments) count = 0;
    RayColumns result{
        count,
        gpu::Buffer(device_, "camera rays", std::max<std::size_t>(1, count) * sizeof(layout::MediaLine),
                    gpu::BufferMemory::device),
        gpu::Buffer(device_, "columns along camera rays",
                    std::max<std::size_t>(1, count) * ray_entry() * sizeof(float))};
    const std::span<layout::MediaLine> lines = result.lines.as<layout::MediaLine>();
    parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) lines[i] = camera_line(picture, first + i);
    });
    return result;
}

void BoundedBeams::add_passes(gpu::PassList& passes, const RayColumns& columns) const {
    if (columns.count == 0) return;
    for (const bool side : {false, true})
        columns_.add(passes, rays_[side], side, columns.lines, columns.count, columns.values, ray_entry());
}

}  // namespace dapple::methods::adaptive_beams
