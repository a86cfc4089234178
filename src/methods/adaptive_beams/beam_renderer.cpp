#include "methods/adaptive_beams/beam_renderer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <optional>

#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "layout/beam_volume.h"
#include "layout/paper_beam.h"
#include "media/phase.h"
#include "methods/adaptive_beams/bounded_beams.h"
#include "methods/adaptive_beams/drawn_beams.h"
#include "methods/adaptive_beams/low_pass.h"
#include "methods/adaptive_beams/paper_beams.h"
#include "methods/adaptive_beams/receiver_cell.h"
#include "spirv/adaptive_beams_beam_lobes_frag.h"
#include "spirv/adaptive_beams_beam_lobes_listed_frag.h"
#include "spirv/adaptive_beams_beam_media_frag.h"
#include "spirv/adaptive_beams_beam_media_listed_frag.h"
#include "spirv/adaptive_beams_beam_media_vert.h"
#include "spirv/adaptive_beams_beam_table_frag.h"
#include "spirv/adaptive_beams_beam_table_listed_frag.h"
#include "spirv/adaptive_beams_beam_vert.h"
#include "spirv/adaptive_beams_paper_lobes_frag.h"
#include "spirv/adaptive_beams_paper_media_frag.h"
#include "spirv/adaptive_beams_paper_media_vert.h"
#include "spirv/adaptive_beams_paper_table_frag.h"
#include "spirv/adaptive_beams_paper_vert.h"
#include "view/camera.h"

namespace dapple::methods::adaptive_beams {
namespace {

using layout::BeamFrame;
using layout::BeamPush;
static_assert(sizeof(layout::DrawnBeam) == 188);
static_assert(sizeof(layout::TurningArea) == 20);
static_assert(sizeof(layout::PaperBeam) == 124);
static_assert(sizeof(BeamPush) == 128);
static_assert(sizeof(BeamFrame) == 36);

constexpr std::size_t kTile = 1 << 14;
/// Of what pixels see: rays, shading normals, faces, and cells' two directions.
constexpr std::size_t kImages = 5;
constexpr std::size_t kIndicesABeam = 24;

/// Bytes of the columns of a part of the picture, at most.
constexpr std::uint64_t kColumnBytes = std::uint64_t{64} << 20;

gpu::RasterDescription description(bool bounded = false) {
    return {.interface = {.storage_buffers = bounded ? 9u : 5u,
                          .sampled_images = kImages,
                          .push_bytes = sizeof(BeamPush)},
            .blend = gpu::Blend::add,
            .cull = gpu::Cull::front,
            .color_formats = {gpu::Format::rgba32f, gpu::Format::rgba32f}};
}

/// At least one element: a binding is never empty.
template <class T>
gpu::Buffer filled_buffer(gpu::Device& device, std::string_view name, const std::vector<T>& values) {
    gpu::Buffer buffer(device, name, std::max<std::size_t>(1, values.size()) * sizeof(T),
                       gpu::BufferMemory::device);
    std::copy(values.begin(), values.end(), buffer.as<T>().begin());
    return buffer;
}

/// What a set, or a part of one, needs on the device.
struct SetOnDevice {
    const BeamSet& set;
    gpu::Buffer beams, corners, turning, plain, listed, frame;
    const BoundedSet* bounded;        ///< null: there are no bounded media on its side of the water
    std::optional<gpu::Buffer> rays;  ///< of its beams, in bounded->light_columns
};

/// Pipelines for beams among bounded media.
struct BoundedPipelines {
    explicit BoundedPipelines(gpu::Device& d)
        : plain(d, "beams in media", adaptive_beams_beam_media_vert, adaptive_beams_beam_media_frag,
                description(true)),
          listed(d, "beams with turning areas in media", adaptive_beams_beam_media_vert,
                 adaptive_beams_beam_media_listed_frag, description(true)),
          paper(d, "beams of the paper in media", adaptive_beams_paper_media_vert,
                adaptive_beams_paper_media_frag, description(true)) {}
    gpu::RasterPipeline plain, listed, paper;
};

}  // namespace

struct BeamRenderer::State {
    State(gpu::Device& d, std::uint64_t largest)
        : device(d),
          largest_buffer(std::min(largest, d.largest_storage_range())),
          pipelines{{{d, "beams", adaptive_beams_beam_vert, adaptive_beams_beam_lobes_frag, description()},
                     {d, "beams with turning areas", adaptive_beams_beam_vert,
                      adaptive_beams_beam_lobes_listed_frag, description()}},
                    {{d, "beams, tabulated phase", adaptive_beams_beam_vert, adaptive_beams_beam_table_frag,
                      description()},
                     {d, "beams with turning areas, tabulated phase", adaptive_beams_beam_vert,
                      adaptive_beams_beam_table_listed_frag, description()}}},
          paper{{d, "beams of the paper", adaptive_beams_paper_vert, adaptive_beams_paper_lobes_frag,
                 description()},
                {d, "beams of the paper, tabulated phase", adaptive_beams_paper_vert,
                 adaptive_beams_paper_table_frag, description()}} {}

    /// Of the rows of a picture from `first_row` on.
    BeamPush push(const BeamSet& set, int sample, int first_row) const;
    void write_pixels(const view::SegmentLayer* segments, const view::ReceiverLayer* receivers,
                      std::size_t first, std::array<std::span<glm::vec4>, kImages> texels) const;
    const gpu::RasterPipeline& pipeline(const SetOnDevice& set, bool listed) const;
    void render_rows(const PictureRays& rays, const view::ReceiverLayer* receivers, int first_row, int rows,
                     BeamSums& sums, FrameStats& stats);

    gpu::Device& device;
    std::uint64_t largest_buffer = 0;
    gpu::RasterPipeline pipelines[2][2];  ///< phase function tabulated, beams with listed triangles
    gpu::RasterPipeline paper[2];
    Shading shading = Shading::exact;
    const scene::FrameScene* scene = nullptr;
    std::optional<view::Camera> camera;
    std::vector<SetOnDevice> sets;
    std::optional<PhaseTables> phases;
    std::optional<media::Media> media;
    bool has_bounded = false;  ///< the scene has bounded media
    std::optional<BoundedBeams> bounded;
    std::optional<BoundedPipelines> bounded_pipelines;
};

BeamRenderer::BeamRenderer(gpu::Device& device, std::uint64_t largest_buffer)
    : state_(std::make_unique<State>(device, largest_buffer)) {}
BeamRenderer::~BeamRenderer() = default;

void BeamRenderer::begin(const scene::FrameScene& scene, std::span<const BeamSet> sets, VolumeKind volumes,
                         Shading shading, FrameStats& stats) {
    State& s = *state_;
    s.scene = &scene;
    s.shading = shading;
    s.camera.emplace(scene.state.camera, scene.state.clip.width, scene.state.clip.height);
    s.sets.clear();
    s.media.emplace(scene);
    s.phases.emplace(s.device, *s.media);
    s.has_bounded = s.media->bounded(false) || s.media->bounded(true);
    if (s.has_bounded) {
        if (!s.bounded) s.bounded.emplace(s.device, s.largest_buffer);
        if (!s.bounded_pipelines) s.bounded_pipelines.emplace(s.device);
        s.bounded->begin(scene, *s.media, *s.phases, stats);
    }
    std::vector<const BoundedSet*> bounded(sets.size(), nullptr);
    if (s.has_bounded) bounded = s.bounded->add(sets, stats);
    const ScopedPass pass(stats, "beam volumes");
    const double reach = shading == Shading::exact ? longest_reach(scene.state.clip.samples) : 0;
    std::size_t beams = 0, prisms = 0, turning = 0, lost = 0;
    for (std::size_t i = 0; i < sets.size(); ++i) {
        const BeamSet& set = sets[i];
        if (set.triangles.empty()) continue;
        DrawnBeams drawn = drawn_beams(set, *s.camera, scene.origin, volumes, reach);
        beams += drawn.beams.size();
        prisms += drawn.prisms;
        turning += drawn.beams.size() - drawn.plain;
        const PaperBeams in_paper = shading == Shading::paper ? paper_beams(set) : PaperBeams{};
        lost += in_paper.lost;
        std::size_t first_beam = 0;
        const glm::mat3 axes(set.world_from_mesh);
        auto in_paper_part = in_paper.beams.begin();
        for (const DrawnBeams& part : parts_of(std::move(drawn), s.largest_buffer)) {
            const auto faces = part.indices.begin();
            const auto split = faces + static_cast<std::ptrdiff_t>(kIndicesABeam * part.plain);
            const auto next = shading == Shading::paper
                                  ? in_paper_part + static_cast<std::ptrdiff_t>(part.beams.size())
                                  : in_paper_part;
            s.sets.push_back(
                {set,
                 shading == Shading::paper
                     ? filled_buffer(s.device, "beams of the paper",
                                     std::vector<layout::PaperBeam>(in_paper_part, next))
                     : filled_buffer(s.device, "beams", part.beams),
                 filled_buffer(s.device, "corners of beams", part.corners),
                 filled_buffer(s.device, "turning areas", part.turning),
                 filled_buffer(s.device, "faces of beams", std::vector<std::uint32_t>(faces, split)),
                 filled_buffer(s.device, "faces of beams",
                               std::vector<std::uint32_t>(split, part.indices.end())),
                 filled_buffer(s.device, "axes of beams",
                               std::vector<BeamFrame>{{axes[0], axes[1], axes[2]}}),
                 bounded[i],
                 bounded[i] ? std::optional(bounded[i]->rays_of(s.device, first_beam, part.beams.size()))
                            : std::nullopt});
            in_paper_part = next;
            first_beam += part.beams.size();
        }
    }
    stats.count("beams drawn", static_cast<double>(beams));
    stats.count("beams in a prism", static_cast<double>(prisms));
    if (lost > 0) stats.count("beams lost to grazing triangles", static_cast<double>(lost));
    stats.count("beams with turning areas", static_cast<double>(turning));
}

BeamPush BeamRenderer::State::push(const BeamSet& set, int sample, int first_row) const {
    BeamPush push{};
    glm::dvec2 offset = view::Camera::sample_offset(sample, scene->state.clip.samples);
    push.in_cell = ReceiverCell(sample, scene->state.clip.samples).point;
    // A camera's rays are affine in the pixel: from four of them.
    const glm::dmat3 mesh_from_world = glm::transpose(set.world_from_mesh);
    const auto ray = [&](glm::dvec2 pixel, glm::dvec3& origin, glm::dvec3& direction) {
        camera->ray(pixel, origin, direction);
        direction /= glm::dot(direction, camera->forward());
        origin = mesh_from_world * (origin - scene->origin);
        direction = mesh_from_world * direction;
    };
    const double width = scene->state.clip.width, height = scene->state.clip.height;
    glm::dvec3 origin, origin_x, origin_y, direction, direction_x, direction_y;
    offset.y += first_row;
    ray(offset, origin, direction);
    ray(offset + glm::dvec2(width, 0), origin_x, direction_x);
    ray(offset + glm::dvec2(0, height), origin_y, direction_y);
    push.origin = origin;
    push.origin_u = (origin_x - origin) / width;
    push.origin_v = (origin_y - origin) / height;
    push.direction = direction;
    push.direction_u = (direction_x - direction) / width;
    push.direction_v = (direction_y - direction) / height;
    push.in_water = set.in_water ? 1.0f : 0.0f;
    push.shift = 0.5 - offset;  // of the rows' own first one
    if (set.in_water && scene->state.water) {
        const scene::Water& water = *scene->state.water;
        push.extinction = water.extinction();
        push.scattering = water.scattering;
        push.phase = lobes_of(water.phase);
    }
    return push;
}

void BeamRenderer::State::write_pixels(const view::SegmentLayer* segments,
                                       const view::ReceiverLayer* receivers, std::size_t first,
                                       std::array<std::span<glm::vec4>, kImages> texels) const {
    const ReceiverCell cell(receivers ? receivers->sample : 0, scene->state.clip.samples);
    parallel_for(texels[0].size(), kTile, [&](std::size_t begin, std::size_t end) {
        const auto& [pixels, normals, faces, right, down] = texels;
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t at = first + i;
            for (const std::span<glm::vec4> image : texels) image[i] = glm::vec4(0);
            if (segments) {
                for (std::uint32_t k = segments->first[at]; k < segments->first[at + 1]; ++k) {
                    if (!segments->primary[k]) continue;
                    pixels[i].x = segments->length[k];
                    pixels[i].z = segments->in_water[k] != 0 ? 1.0f : 0.0f;
                    break;
                }
            }
            if (receivers && seen_directly(receivers->flags[at])) {
                const int sample = receivers->sample;
                const glm::dvec2 pixel(at % static_cast<std::size_t>(receivers->width),
                                       at / static_cast<std::size_t>(receivers->width));
                glm::dvec3 origin, direction;
                camera->ray(pixel + view::Camera::sample_offset(sample, scene->state.clip.samples), origin,
                            direction);
                const glm::dvec3 position = glm::dvec3(receivers->position[at]) + scene->origin;
                pixels[i].y = static_cast<float>(glm::dot(position - origin, direction));
                pixels[i].z = (receivers->flags[at] & view::kInWater) != 0 ? 1.0f : 0.0f;
                normals[i] = glm::vec4(receivers->shading_normal[at], 0);
                faces[i] = glm::vec4(receivers->geometric_normal[at], receivers->object[at]);
                cell.write(*receivers, at, right[i], down[i]);
            }
        }
    });
}

const gpu::RasterPipeline& BeamRenderer::State::pipeline(const SetOnDevice& set, bool listed) const {
    if (set.bounded) {
        const BoundedPipelines& all = *bounded_pipelines;
        return shading == Shading::paper ? all.paper : (listed ? all.listed : all.plain);
    }
    const int tabulated = phases->first(0) >= 0 ? 1 : 0;
    return shading == Shading::paper ? paper[tabulated] : pipelines[tabulated][listed ? 1 : 0];
}

BeamSums BeamRenderer::render(const view::SegmentLayer* segments, const view::ReceiverLayer* receivers,
                              FrameStats& stats) {
    State& s = *state_;
    const scene::Clip& clip = s.scene->state.clip;
    assert(!segments || (segments->width == clip.width && segments->height == clip.height));
    assert(!receivers || (receivers->width == clip.width && receivers->height == clip.height));
    const std::size_t count = static_cast<std::size_t>(clip.width) * static_cast<std::size_t>(clip.height);
    BeamSums sums{std::vector<glm::vec3>(count, glm::vec3(0)), std::vector<glm::vec3>(count, glm::vec3(0))};
    if (s.sets.empty()) return sums;
    int rows = clip.height;
    const int sample = segments ? segments->sample : receivers->sample;
    const PictureRays rays{segments, &*s.camera, view::Camera::sample_offset(sample, clip.samples)};
    if (s.has_bounded) s.bounded->look_along(rays, stats);
    if (s.has_bounded && segments) {
        const std::uint64_t row =
            s.bounded->ray_entry() * sizeof(float) * static_cast<std::uint64_t>(clip.width);
        rows = static_cast<int>(std::clamp<std::uint64_t>(
            std::min(kColumnBytes, s.largest_buffer) / std::max<std::uint64_t>(1, row), 1,
            static_cast<std::uint64_t>(clip.height)));
    }
    for (int first = 0; first < clip.height; first += rows)
        s.render_rows(rays, receivers, first, std::min(rows, clip.height - first), sums, stats);
    const double deviation = s.scene->state.caustics.adaptive_beams.paper_low_pass;
    if (s.shading == Shading::paper && receivers && deviation > 0) {
        const ScopedPass pass(stats, "low-pass");
        std::vector<std::uint8_t> covered(count);
        for (std::size_t i = 0; i < count; ++i) covered[i] = seen_directly(receivers->flags[i]) ? 1 : 0;
        low_pass(sums.irradiance, covered, clip.width, deviation);
    }
    return sums;
}

void BeamRenderer::State::render_rows(const PictureRays& rays, const view::ReceiverLayer* receivers,
                                      int first_row, int rows, BeamSums& sums, FrameStats& stats) {
    const scene::Clip& clip = scene->state.clip;
    const auto width = static_cast<std::size_t>(clip.width);
    const std::size_t count = width * static_cast<std::size_t>(rows),
                      first_pixel = width * static_cast<std::size_t>(first_row);
    const std::size_t bytes = count * sizeof(glm::vec4);
    const auto image = [&](const char* name) {
        return gpu::Image(device, name, clip.width, rows, gpu::Format::rgba32f);
    };
    constexpr std::array<const char*, kImages> kNames{"pixels", "normals", "faces", "cells to the right",
                                                      "cells down"};
    std::vector<gpu::Buffer> texels;
    std::vector<gpu::Image> images;
    for (const char* name : kNames) {
        texels.emplace_back(device, name, bytes);
        images.push_back(image(name));
    }
    const gpu::Image scattered = image("scattered light"), irradiance = image("irradiance");
    const int sample = rays.segments ? rays.segments->sample : receivers->sample;
    gpu::PassList passes(device);
    std::optional<RayColumns> columns;
    {
        const ScopedPass pass(stats, "beam raster");
        write_pixels(rays.segments, receivers, first_pixel,
                     {texels[0].as<glm::vec4>(), texels[1].as<glm::vec4>(), texels[2].as<glm::vec4>(),
                      texels[3].as<glm::vec4>(), texels[4].as<glm::vec4>()});
        if (has_bounded) columns.emplace(bounded->ray_columns(rays, first_pixel, count));
    }
    for (std::size_t i = 0; i < kImages; ++i) passes.copy("beam raster", texels[i], images[i]);
    if (columns) bounded->add_passes(passes, *columns);
    gpu::Targets targets{.colors = {&scattered, &irradiance}};
    for (const SetOnDevice& set : sets) {
        for (const bool listed : {false, true}) {
            const gpu::Buffer& indices = listed ? set.listed : set.plain;
            if (indices.bytes() < kIndicesABeam * sizeof(std::uint32_t)) continue;
            gpu::Bindings bindings{
                .buffers = {&set.beams, &set.corners, &set.turning, &phases->table(), &set.frame},
                .images = {&images[0], &images[1], &images[2], &images[3], &images[4]}};
            if (set.bounded)
                bindings.buffers.insert(bindings.buffers.end(), {&set.bounded->media, &columns->values,
                                                                 &set.bounded->light_columns, &*set.rays});
            bindings.set_push(push(set.set, sample, first_row));
            passes.draw("beam raster", pipeline(set, listed), std::move(bindings), targets,
                        {.vertices = static_cast<std::uint32_t>(indices.bytes() / sizeof(std::uint32_t)),
                         .index_buffer = &indices});
            targets.clear = false;
        }
    }
    // Texels have been read by then.
    passes.copy("beam raster", scattered, texels[0]);
    passes.copy("beam raster", irradiance, texels[1]);
    passes.run(stats);

    const ScopedPass pass(stats, "beam raster");
    const std::span<const glm::vec4> s_texels = texels[0].as<glm::vec4>(),
                                     e_texels = texels[1].as<glm::vec4>();
    double fragments = 0;
    for (std::size_t i = 0; i < count; ++i) {
        sums.scattered[first_pixel + i] = glm::vec3(s_texels[i]);
        sums.irradiance[first_pixel + i] = glm::vec3(e_texels[i]);
        fragments += static_cast<double>(s_texels[i].w);
    }
    stats.count("beam fragments", fragments);
}

}  // namespace dapple::methods::adaptive_beams
