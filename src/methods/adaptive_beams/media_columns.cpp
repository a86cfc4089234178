#include "methods/adaptive_beams/media_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "grids/dense_bricks.h"
#include "spirv/adaptive_beams_columns_comp.h"

namespace dapple::methods::adaptive_beams {
namespace {

static_assert(sizeof(layout::MediaLine) == 36);
static_assert(sizeof(layout::MediaBody) == 128);
static_assert(sizeof(layout::ColumnPush) == 24);

constexpr std::size_t kGroup = 64;  // local_size_x of columns.comp
constexpr std::size_t kMostGroups = 65535;

/// A part on the device.
struct Uploaded {
    gpu::Buffer body, blocks;
    gpu::Image bricks;
    float step, thickest;
};

/// m: the mean width of a voxel, where local units are voxels.
double voxel(const media::Body::Place& place) {
    double squares = 0;
    for (int axis = 0; axis < 3; ++axis) squares += glm::dot(place.turn[axis], place.turn[axis]);
    return std::sqrt(3 / squares);
}

}  // namespace

struct MediaColumns::State {
    explicit State(gpu::Device& to)
        : device(to),
          pipeline(to, "columns of media", adaptive_beams_columns_comp,
                   {.storage_buffers = 4, .sampled_images = 1, .push_bytes = sizeof(layout::ColumnPush)}) {}

    Uploaded upload(const scene::FrameScene& scene, const media::Part& part, FrameStats& stats) const;

    gpu::Device& device;
    gpu::ComputePipeline pipeline;
    const media::Media* media = nullptr;
    std::vector<Uploaded> parts;
};

Uploaded MediaColumns::State::upload(const scene::FrameScene& scene, const media::Part& part,
                                     FrameStats& stats) const {
    auto pass = std::make_unique<ScopedPass>(stats, "columns of media");
    const std::size_t medium = part.component - 1;
    const media::Body::Place& place = part.body.place();
    layout::MediaBody body{};
    body.turn_x = place.turn[0];
    body.turn_y = place.turn[1];
    body.turn_z = place.turn[2];
    body.shift = place.shift;
    body.low = place.low;
    body.high = place.high;
    body.density = static_cast<float>(place.density);
    grids::DenseBricks bricks;
    float thickest = body.density, step = std::numeric_limits<float>::max();
    if (scene.state.media[medium].type == scene::MediumType::grid) {
        const grids::DensityGrid& grid = *scene.medium_grids[medium];
        try {
            bricks = grids::dense_bricks(grid, device.largest_volume());
        } catch (const Error& error) {
            throw Error(error.code(), "medium " + scene.state.media[medium].name + ": " + error.what());
        }
        body.density *= bricks.scale;
        thickest *= grid.maximum();
        step = static_cast<float>(voxel(place));
        body.grid = 1;
        body.first_block = bricks.first;
        body.blocks = bricks.count;
        body.bricks = bricks.size;
        body.texel = 1.0f / glm::vec3(bricks.extent());
        stats.count("texels of grids", static_cast<double>(bricks.texels.size()));
    } else {
        bricks.texels.assign(1, 0);
        bricks.brick.assign(1, -1);
    }
    const glm::ivec3 extent = body.grid == 1 ? bricks.extent() : glm::ivec3(1);
    gpu::Buffer texels(device, "texels of a grid", bricks.texels.size() * sizeof(std::uint16_t));
    std::copy(bricks.texels.begin(), bricks.texels.end(), texels.as<std::uint16_t>().begin());
    bricks.texels = {};  // before the image takes as much
    Uploaded uploaded{gpu::Buffer(device, "body of a medium", sizeof(body)),
                      gpu::Buffer(device, "blocks of a grid", bricks.brick.size() * sizeof(std::int32_t)),
                      gpu::Image(device, "bricks of a grid", {extent.x, extent.y, extent.z}), step, thickest};
    uploaded.body.as<layout::MediaBody>()[0] = body;
    std::copy(bricks.brick.begin(), bricks.brick.end(), uploaded.blocks.as<std::int32_t>().begin());
    pass.reset();
    gpu::PassList passes(device);
    passes.copy("columns of media", texels, uploaded.bricks);
    passes.run(stats);
    return uploaded;
}

MediaColumns::MediaColumns(gpu::Device& device) : state_(std::make_unique<State>(device)) {}
MediaColumns::~MediaColumns() = default;

void MediaColumns::begin(const scene::FrameScene& scene, const media::Media& media, FrameStats& stats) {
    State& s = *state_;
    s.media = &media;
    s.parts.clear();
    for (const media::Part& part : media.parts()) s.parts.push_back(s.upload(scene, part, stats));
}

std::uint32_t MediaColumns::places(double voxels) {
    return static_cast<std::uint32_t>(std::clamp(std::ceil(voxels) + 1, static_cast<double>(kLeastPlaces),
                                                 static_cast<double>(kMostPlaces)));
}

double MediaColumns::voxels(std::size_t part, const glm::dvec3& origin, const glm::dvec3& direction,
                            double length) const {
    if (is_box(part)) return 0;
    const media::Body& body = state_->media->parts()[part].body;
    const media::Interval overlap = body.overlap(origin, direction, length);
    return overlap.empty() ? 0 : (overlap.end - overlap.begin) * glm::length(body.place().turn * direction);
}

ColumnTable MediaColumns::table(bool in_water, std::span<const double> voxels, std::uint32_t most,
                                bool boxes) const {
    ColumnTable table;
    const std::vector<media::Part>& parts = state_->media->parts();
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (!parts[i].on(in_water)) continue;
        const std::uint32_t wanted = is_box(i) ? (boxes ? 2u : 0u) : std::min(most, places(voxels[i]));
        table.columns.push_back({i, table.entry, wanted});
        if (wanted > 0) table.entry += entry(wanted);
    }
    return table;
}

void MediaColumns::add(gpu::PassList& passes, const ColumnTable& table, bool in_water,
                       const gpu::Buffer& lines, std::size_t count, const gpu::Buffer& columns,
                       std::uint32_t entry) const {
    for (const ColumnTable::Column& column : table.columns) {
        if (column.places == 0) continue;
        const Uploaded& part = state_->parts[column.part];
        gpu::Bindings bindings{.buffers = {&lines, &part.body, &part.blocks, &columns},
                               .images = {&part.bricks},
                               .writes = {&columns}};
        bindings.set_push(layout::ColumnPush{static_cast<std::uint32_t>(count), entry, column.first,
                                             column.places, kLeastPlaces, in_water ? 1.0f : 0.0f});
        const std::size_t groups = std::clamp<std::size_t>((count + kGroup - 1) / kGroup, 1, kMostGroups);
        passes.compute("columns of media", state_->pipeline, std::move(bindings),
                       {static_cast<std::uint32_t>(groups), 1, 1});
    }
}

bool MediaColumns::is_box(std::size_t part) const {
    return state_->parts[part].step == std::numeric_limits<float>::max();
}
float MediaColumns::step(std::size_t part) const {
    return state_->parts[part].step;
}
float MediaColumns::thickest(std::size_t part) const {
    return state_->parts[part].thickest;
}

}  // namespace dapple::methods::adaptive_beams
