#include "methods/adaptive_beams/beam_renderer.h"

#include <algorithm>
#include <cassert>
#include <optional>

#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "layout/beam_volume.h"
#include "layout/paper_beam.h"
#include "media/phase.h"
#include "methods/adaptive_beams/drawn_beams.h"
#include "methods/adaptive_beams/paper_beams.h"
#include "spirv/adaptive_beams_beam_lobes_frag.h"
#include "spirv/adaptive_beams_beam_lobes_listed_frag.h"
#include "spirv/adaptive_beams_beam_table_frag.h"
#include "spirv/adaptive_beams_beam_table_listed_frag.h"
#include "spirv/adaptive_beams_beam_vert.h"
#include "spirv/adaptive_beams_paper_lobes_frag.h"
#include "spirv/adaptive_beams_paper_table_frag.h"
#include "spirv/adaptive_beams_paper_vert.h"
#include "view/camera.h"

namespace dapple::methods::adaptive_beams {
namespace {

using layout::BeamFrame;
using layout::BeamPush;
static_assert(sizeof(layout::DrawnBeam) == 172);
static_assert(sizeof(layout::TurningArea) == 16);
static_assert(sizeof(layout::PaperBeam) == 124);
static_assert(sizeof(BeamPush) == 120);
static_assert(sizeof(BeamFrame) == 36);

constexpr std::size_t kTile = 1 << 14;
constexpr std::size_t kPhaseValues = 2048;
constexpr std::size_t kIndicesABeam = 24;

gpu::RasterDescription description() {
    return {.interface = {.storage_buffers = 5, .sampled_images = 3, .push_bytes = sizeof(BeamPush)},
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
};

bool is_lobes(scene::PhaseType type) {
    return type == scene::PhaseType::isotropic || type == scene::PhaseType::henyey_greenstein ||
           type == scene::PhaseType::two_lobe;
}

/// Mean cosines of two lobes and the first one's share; for other functions nothing of use.
glm::vec3 lobes(const scene::PhaseFunction& phase) {
    if (phase.type == scene::PhaseType::isotropic) return {0, 0, 1};
    if (phase.type == scene::PhaseType::henyey_greenstein) return glm::dvec3(phase.anisotropy, 0, 1);
    return glm::dvec3(phase.anisotropy, phase.back_anisotropy, phase.forward_share);
}

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

    BeamPush push(const BeamSet& set, glm::dvec2 offset) const;
    void write_pixels(const view::SegmentLayer* segments, const view::ReceiverLayer* receivers,
                      std::span<glm::vec4> pixels, std::span<glm::vec4> normals,
                      std::span<glm::vec4> faces) const;

    gpu::Device& device;
    std::uint64_t largest_buffer = 0;
    gpu::RasterPipeline pipelines[2][2];  ///< phase function tabulated, beams with listed triangles
    gpu::RasterPipeline paper[2];
    Shading shading = Shading::exact;
    const scene::FrameScene* scene = nullptr;
    std::optional<view::Camera> camera;
    std::vector<SetOnDevice> sets;
    std::optional<gpu::Buffer> phase_table;
};

BeamRenderer::BeamRenderer(gpu::Device& device, std::uint64_t largest_buffer)
    : state_(std::make_unique<State>(device, largest_buffer)) {}
BeamRenderer::~BeamRenderer() = default;

void BeamRenderer::begin(const scene::FrameScene& scene, std::span<const BeamSet> sets, VolumeKind volumes,
                         Shading shading, FrameStats& stats) {
    const ScopedPass pass(stats, "beam volumes");
    State& s = *state_;
    s.scene = &scene;
    s.shading = shading;
    s.camera.emplace(scene.state.camera, scene.state.clip.width, scene.state.clip.height);
    s.sets.clear();
    std::size_t beams = 0, prisms = 0, turning = 0, lost = 0;
    for (const BeamSet& set : sets) {
        if (set.triangles.empty()) continue;
        DrawnBeams drawn = drawn_beams(set, *s.camera, scene.origin, volumes);
        beams += drawn.beams.size();
        prisms += drawn.prisms;
        turning += drawn.beams.size() - drawn.plain;
        const PaperBeams in_paper = shading == Shading::paper ? paper_beams(set) : PaperBeams{};
        lost += in_paper.lost;
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
                               std::vector<BeamFrame>{{axes[0], axes[1], axes[2]}})});
            in_paper_part = next;
        }
    }
    std::vector<float> table(1, 0.0f);
    if (scene.state.water && !is_lobes(scene.state.water->phase.type)) {
        const media::Phase phase(scene.state.water->phase);
        table.resize(kPhaseValues);
        for (std::size_t i = 0; i < kPhaseValues; ++i) {
            const double place = static_cast<double>(i) / static_cast<double>(kPhaseValues - 1);
            table[i] = static_cast<float>(phase.at(1 - 2 * place * place * place * place));
        }
    }
    s.phase_table.emplace(filled_buffer(s.device, "phase function", table));
    stats.count("beams drawn", static_cast<double>(beams));
    stats.count("beams in a prism", static_cast<double>(prisms));
    if (lost > 0) stats.count("beams lost to grazing triangles", static_cast<double>(lost));
    stats.count("beams with turning areas", static_cast<double>(turning));
}

BeamPush BeamRenderer::State::push(const BeamSet& set, glm::dvec2 offset) const {
    BeamPush push{};
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
    push.shift = 0.5 - offset;
    if (set.in_water && scene->state.water) {
        const scene::Water& water = *scene->state.water;
        push.extinction = water.extinction();
        push.scattering = water.scattering;
        push.phase = lobes(water.phase);
    }
    return push;
}

void BeamRenderer::State::write_pixels(const view::SegmentLayer* segments,
                                       const view::ReceiverLayer* receivers, std::span<glm::vec4> pixels,
                                       std::span<glm::vec4> normals, std::span<glm::vec4> faces) const {
    parallel_for(pixels.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            pixels[i] = normals[i] = faces[i] = glm::vec4(0);
            if (segments) {
                for (std::uint32_t k = segments->first[i]; k < segments->first[i + 1]; ++k) {
                    if (!segments->primary[k]) continue;
                    pixels[i].x = segments->length[k];
                    pixels[i].z = segments->in_water[k] != 0 ? 1.0f : 0.0f;
                    break;
                }
            }
            if (receivers && seen_directly(receivers->flags[i])) {
                const int sample = receivers->sample;
                const glm::dvec2 pixel(i % static_cast<std::size_t>(receivers->width),
                                       i / static_cast<std::size_t>(receivers->width));
                glm::dvec3 origin, direction;
                camera->ray(pixel + view::Camera::sample_offset(sample, scene->state.clip.samples), origin,
                            direction);
                const glm::dvec3 position = glm::dvec3(receivers->position[i]) + scene->origin;
                pixels[i].y = static_cast<float>(glm::dot(position - origin, direction));
                pixels[i].z = (receivers->flags[i] & view::kInWater) != 0 ? 1.0f : 0.0f;
                normals[i] = glm::vec4(receivers->shading_normal[i], 0);
                faces[i] = glm::vec4(receivers->geometric_normal[i], receivers->object[i]);
            }
        }
    });
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

    const std::size_t bytes = count * sizeof(glm::vec4);
    gpu::Buffer first(s.device, "pixels or scattered light", bytes);
    gpu::Buffer second(s.device, "normals or irradiance", bytes);
    gpu::Buffer third(s.device, "faces", bytes);
    const auto image = [&](const char* name) {
        return gpu::Image(s.device, name, clip.width, clip.height, gpu::Format::rgba32f);
    };
    const gpu::Image pixels = image("pixels"), normals = image("normals"), faces = image("faces"),
                     scattered = image("scattered light"), irradiance = image("irradiance");
    {
        const ScopedPass pass(stats, "beam raster");
        s.write_pixels(segments, receivers, first.as<glm::vec4>(), second.as<glm::vec4>(),
                       third.as<glm::vec4>());
    }
    const int sample = segments ? segments->sample : receivers->sample;
    const glm::dvec2 offset = view::Camera::sample_offset(sample, clip.samples);
    gpu::PassList passes(s.device);
    passes.copy("beam raster", first, pixels);
    passes.copy("beam raster", second, normals);
    passes.copy("beam raster", third, faces);
    gpu::Targets targets{.colors = {&scattered, &irradiance}};
    const bool tabulated = s.scene->state.water && !is_lobes(s.scene->state.water->phase.type);
    for (const SetOnDevice& set : s.sets) {
        for (const bool listed : {false, true}) {
            const gpu::Buffer& indices = listed ? set.listed : set.plain;
            if (indices.bytes() < kIndicesABeam * sizeof(std::uint32_t)) continue;
            gpu::Bindings bindings{
                .buffers = {&set.beams, &set.corners, &set.turning, &*s.phase_table, &set.frame},
                .images = {&pixels, &normals, &faces}};
            bindings.set_push(s.push(set.set, offset));
            const gpu::RasterPipeline& pipeline = s.shading == Shading::paper
                                                      ? s.paper[tabulated ? 1 : 0]
                                                      : s.pipelines[tabulated ? 1 : 0][listed ? 1 : 0];
            passes.draw("beam raster", pipeline, std::move(bindings), targets,
                        {.vertices = static_cast<std::uint32_t>(indices.bytes() / sizeof(std::uint32_t)),
                         .index_buffer = &indices});
            targets.clear = false;
        }
    }
    passes.copy("beam raster", scattered, first);
    passes.copy("beam raster", irradiance, second);
    passes.run(stats);

    const ScopedPass pass(stats, "beam raster");
    const std::span<const glm::vec4> s_texels = first.as<glm::vec4>(), e_texels = second.as<glm::vec4>();
    double fragments = 0;
    for (std::size_t i = 0; i < count; ++i) {
        sums.scattered[i] = glm::vec3(s_texels[i]);
        sums.irradiance[i] = glm::vec3(e_texels[i]);
        fragments += static_cast<double>(s_texels[i].w);
    }
    stats.count("beam fragments", fragments);
    return sums;
}

}  // namespace dapple::methods::adaptive_beams
