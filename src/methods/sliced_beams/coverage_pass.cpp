#include "methods/sliced_beams/coverage_pass.h"

#include <algorithm>
#include <optional>
#include <string>

#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "methods/sliced_beams/coverage_work.h"
#include "spirv/sliced_beams_cover_curved_comp.h"
#include "spirv/sliced_beams_cover_planar_comp.h"
#include "spirv/sliced_beams_land_comp.h"

namespace dapple::methods::sliced_beams {
namespace {

using layout::CoveragePush;
using layout::CoverageRay;
static_assert(sizeof(CoverageRay) == 20);
static_assert(sizeof(layout::CoverageCluster) == 36);
static_assert(sizeof(layout::CoverageFrame) == 48);
static_assert(sizeof(layout::LandedBeam) == 36);
static_assert(sizeof(layout::CoverageBlock) == 8);
static_assert(sizeof(layout::PlanarReceiver) == 28);
static_assert(sizeof(layout::CurvedReceiver) == 52);
static_assert(sizeof(CoveragePush) == 16);

constexpr std::size_t kBatchTiles = 1024;  ///< found before the device is asked: bounds the host's lists
constexpr std::size_t kChunkTiles = 4;
constexpr std::size_t kGroup = 64;          ///< invocations of a work group
constexpr std::size_t kMostGroups = 65535;  ///< that every device takes at once
constexpr std::size_t kVertices = 1 << 14;  ///< copied by one thread

std::array<std::uint32_t, 3> groups(std::size_t invocations) {
    return {static_cast<std::uint32_t>((invocations + kGroup - 1) / kGroup), 1, 1};
}

/// The two ways in which a sheet's tiles are worked.
enum Kind : std::size_t { planar, curved, kKinds };

/// Of a few tiles, by sheet and kind.
struct Chunk {
    std::vector<CoverageWork> works;
    QueryCounts counts;
    std::size_t on_device = 0;  ///< tiles, once a sheet
};

/// A buffer that grows to what is asked for.
class Grown {
public:
    Grown(gpu::BufferMemory memory = gpu::BufferMemory::device) : memory_(memory) {}

    gpu::Buffer& of(gpu::Device& device, std::string_view name, std::size_t bytes) {
        // A quarter more, so that like batches share a buffer; never past what a binding holds.
        if (!buffer_ || buffer_->bytes() < bytes)
            buffer_.emplace(
                device, name,
                std::max(bytes, std::min<std::size_t>(bytes + bytes / 4, device.largest_storage_range())),
                memory_);
        return *buffer_;
    }
    gpu::Buffer& operator*() { return *buffer_; }

private:
    gpu::BufferMemory memory_;
    std::optional<gpu::Buffer> buffer_;
};

/// What one sheet and kind needs on the device for a batch.
struct BatchBuffers {
    Grown clusters, frames, landed, blocks, list, receivers;
    Grown irradiance{gpu::BufferMemory::host};
};

/// Sizes of works one after another.
struct Sizes {
    std::size_t clusters = 0, frames = 0, blocks = 0, list = 0;

    Sizes& operator+=(const CoverageWork& work) {
        clusters += work.clusters.size();
        frames += work.frames.size();
        blocks += work.blocks.size();
        list += work.list.size();
        return *this;
    }
};

/// Copies one work behind those before it, whose sizes are `before`.
void copy_work(const CoverageWork& work, const Sizes& before, BatchBuffers& to) {
    const auto at = []<class T>(std::span<T> values, std::size_t first) {
        return values.begin() + static_cast<std::ptrdiff_t>(first);
    };
    const auto first_cluster = static_cast<std::uint32_t>(before.clusters);
    const auto first_frame = static_cast<std::uint32_t>(before.frames);
    const auto first_entry = static_cast<std::uint32_t>(before.list);
    std::transform(work.clusters.begin(), work.clusters.end(),
                   at((*to.clusters).as<layout::CoverageCluster>(), before.clusters),
                   [&](layout::CoverageCluster c) {
                       c.frame += first_frame;
                       return c;
                   });
    std::transform(work.blocks.begin(), work.blocks.end(),
                   at((*to.blocks).as<layout::CoverageBlock>(), before.blocks), [&](auto block) {
                       return layout::CoverageBlock{block.first + first_entry, block.last + first_entry};
                   });
    std::transform(work.list.begin(), work.list.end(), at((*to.list).as<std::uint32_t>(), before.list),
                   [&](std::uint32_t cluster) { return cluster + first_cluster; });
    const std::size_t receivers = kBlockReceivers * before.blocks;
    if (work.frames.empty()) {
        std::copy(work.curved.begin(), work.curved.end(),
                  at((*to.receivers).as<layout::CurvedReceiver>(), receivers));
    } else {
        std::copy(work.frames.begin(), work.frames.end(),
                  at((*to.frames).as<layout::CoverageFrame>(), before.frames));
        std::copy(work.planar.begin(), work.planar.end(),
                  at((*to.receivers).as<layout::PlanarReceiver>(), receivers));
    }
}

}  // namespace

struct CoveragePass::State {
    explicit State(gpu::Device& d)
        : device(d),
          land(d, "landing of beams", sliced_beams_land_comp,
               {.storage_buffers = 6, .push_bytes = sizeof(CoveragePush)}),
          cover_planar(d, "coverage of planes", sliced_beams_cover_planar_comp,
                       {.storage_buffers = 5, .push_bytes = sizeof(CoveragePush)}),
          cover_curved(d, "coverage of curved surfaces", sliced_beams_cover_curved_comp,
                       {.storage_buffers = 8, .push_bytes = sizeof(CoveragePush)}) {}

    void find(const ReceiverGroup& group, const LightLattice* lattice, Chunk& chunk,
              std::vector<glm::vec3>& irradiance) const;
    std::size_t chunks_that_fit(std::span<const Chunk> chunks) const;
    void run(std::span<const Chunk> chunks, LayerResult& result, FrameStats& stats);
    void record(std::size_t key, std::span<const Chunk> chunks, std::span<const Sizes> before,
                const Sizes& all, gpu::PassList& passes);

    struct Sheet {
        gpu::Buffer rays, power;
    };
    gpu::Device& device;
    gpu::ComputePipeline land, cover_planar, cover_curved;
    Sheets sheets;
    std::optional<gpu::Buffer> triangles;
    std::vector<Sheet> on_device;       ///< beside `sheets`
    std::vector<BatchBuffers> batches;  ///< by sheet and kind
};

CoveragePass::CoveragePass(gpu::Device& device) : state_(std::make_unique<State>(device)) {}
CoveragePass::~CoveragePass() = default;

bool CoveragePass::begin(Sheets sheets) {
    State& s = *state_;
    s.sheets = {};
    s.on_device.clear();
    s.triangles.reset();
    s.batches.resize(kKinds * sheets.size());
    if (sheets.empty()) return true;
    const std::span<const glm::uvec3> triangles = sheets.front()->triangles();
    const std::size_t vertices = sheets.front()->sheet().rays.size();
    if (std::max(triangles.size_bytes(), vertices * sizeof(CoverageRay)) > s.device.largest_storage_range())
        return false;
    constexpr auto device_memory = gpu::BufferMemory::device;
    s.triangles.emplace(s.device, "water triangles", triangles.size_bytes(), device_memory);
    std::copy(triangles.begin(), triangles.end(), s.triangles->as<glm::uvec3>().begin());
    for (const auto& coverage : sheets) {
        const light::BeamSheet<float>& sheet = coverage->sheet();
        gpu::Buffer rays(s.device, "rays", vertices * sizeof(CoverageRay), device_memory);
        gpu::Buffer power(s.device, "power of beams", sheet.flux.size() * sizeof(glm::vec3), device_memory);
        const std::span<CoverageRay> to = rays.as<CoverageRay>();
        parallel_for(vertices, kVertices, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const auto& ray = sheet.rays[i];
                to[i] = {{ray.a, ray.b, ray.slope_a, ray.slope_b}, sheet.start[i]};
            }
        });
        const std::span<glm::vec3> powers = power.as<glm::vec3>();
        const glm::vec3 color(sheet.color);
        parallel_for(powers.size(), kVertices, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) powers[i] = color * (sheet.flux[i] * sheet.tint_of(i));
        });
        s.on_device.push_back({std::move(rays), std::move(power)});
    }
    s.sheets = sheets;
    return true;
}

/// The tiles of one group of receivers, one a sheet: their work for the device, or at once their light.
void CoveragePass::State::find(const ReceiverGroup& group, const LightLattice* lattice, Chunk& chunk,
                               std::vector<glm::vec3>& irradiance) const {
    irradiance.assign(group.pixels.size(), glm::vec3(0));
    for (std::size_t s = 0; s < sheets.size(); ++s) {
        const SheetCoverage<float>& sheet = *sheets[s];
        if (sheet.sheet().in_water() != group.in_water || sheet.pyramid().empty()) continue;
        const auto alone = [&](const ReceiverGroup& part, std::span<glm::vec3> to) {
            Tile<float> tile(sheet, part.receivers, part.object, to, chunk.counts);
            if (!tile.find()) return;
            if (tile.plain()) {
                const CoverageWorkBuilder builder(tile, part.pixels);
                CoverageWork& work = chunk.works[kKinds * s + (builder.planar() ? planar : curved)];
                if (work.clusters.size() + builder.clusters() <= kMostClusters) {
                    builder.add_to(work);
                    ++chunk.on_device;
                    return;
                }
            }
            tile.cover();
        };
        if (lattice)
            lattice->add_with(s, group, irradiance, alone);
        else
            alone(group, irradiance);
    }
}

void CoveragePass::irradiance(const LayerTiles& tiles, const LightLattice* lattice, LayerResult& result,
                              QueryCounts& counts, FrameStats& stats) {
    std::size_t on_device = 0;
    for (std::size_t first = 0; first < tiles.count(); first += kBatchTiles) {
        const std::size_t batch = std::min(kBatchTiles, tiles.count() - first);
        std::vector<Chunk> chunks((batch + kChunkTiles - 1) / kChunkTiles);
        {
            const ScopedPass pass(stats, "coverage");
            parallel_for(batch, kChunkTiles, [&](std::size_t begin, std::size_t end) {
                Chunk& chunk = chunks[begin / kChunkTiles];
                chunk.works.resize(kKinds * state_->sheets.size());
                std::vector<glm::vec3> irradiance;
                for (std::size_t tile = begin; tile < end; ++tile) {
                    for (const ReceiverGroup& group : tiles.groups(first + tile)) {
                        state_->find(group, lattice, chunk, irradiance);
                        for (std::size_t k = 0; k < group.pixels.size(); ++k) {
                            result.irradiance[group.pixels[k]] = irradiance[k];
                            result.covered[group.pixels[k]] = 1;
                        }
                    }
                }
            });
        }
        for (const Chunk& chunk : chunks) {
            counts.add(chunk.counts);
            on_device += chunk.on_device;
        }
        std::span<const Chunk> left = chunks;
        while (!left.empty()) {
            const std::size_t fit = state_->chunks_that_fit(left);
            state_->run(left.first(fit), result, stats);
            left = left.subspan(fit);
        }
    }
    stats.count("tiles covered on the device", static_cast<double>(on_device));
}

/// How many of the next chunks the device's bindings and dispatches hold; at least one.
std::size_t CoveragePass::State::chunks_that_fit(std::span<const Chunk> chunks) const {
    const std::size_t range = device.largest_storage_range();
    const std::size_t most_clusters =
        std::min(range / (kClusterBeams * sizeof(layout::LandedBeam)), kMostGroups * kGroup / kClusterBeams);
    std::vector<Sizes> sizes(batches.size());
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        for (std::size_t key = 0; key < sizes.size(); ++key) {
            sizes[key] += chunks[i].works[key];
            const bool fits =
                sizes[key].clusters <= most_clusters && sizes[key].list * sizeof(std::uint32_t) <= range;
            if (!fits && i > 0) return i;
        }
    }
    return chunks.size();
}

void CoveragePass::State::run(std::span<const Chunk> chunks, LayerResult& result, FrameStats& stats) {
    std::vector<std::vector<Sizes>> before(batches.size());
    std::vector<Sizes> all(batches.size());
    gpu::PassList passes(device);
    bool any = false;
    {
        const ScopedPass pass(stats, "coverage");
        for (std::size_t key = 0; key < batches.size(); ++key) {
            for (const Chunk& chunk : chunks) {
                before[key].push_back(all[key]);
                all[key] += chunk.works[key];
            }
            if (all[key].list == 0) continue;
            record(key, chunks, before[key], all[key], passes);
            any = true;
        }
    }
    if (!any) return;
    passes.run(stats);
    const ScopedPass pass(stats, "coverage");
    parallel_for(chunks.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            for (std::size_t key = 0; key < batches.size(); ++key) {
                if (all[key].list == 0) continue;
                const CoverageWork& work = chunks[c].works[key];
                const std::span<const glm::vec3> from = (*batches[key].irradiance)
                                                            .as<glm::vec3>()
                                                            .subspan(kBlockReceivers * before[key][c].blocks);
                for (std::size_t i = 0; i < work.pixels.size(); ++i)
                    if (work.pixels[i] != kNoPixel) result.irradiance[work.pixels[i]] += from[i];
            }
        }
    });
}

void CoveragePass::State::record(std::size_t key, std::span<const Chunk> chunks,
                                 std::span<const Sizes> before, const Sizes& all, gpu::PassList& passes) {
    const bool flat = key % kKinds == planar;
    const std::size_t receivers = kBlockReceivers * all.blocks;
    BatchBuffers& b = batches[key];
    const gpu::Buffer& clusters =
        b.clusters.of(device, "clusters", all.clusters * sizeof(layout::CoverageCluster));
    const gpu::Buffer& blocks = b.blocks.of(device, "blocks", all.blocks * sizeof(layout::CoverageBlock));
    const gpu::Buffer& list = b.list.of(device, "lists", all.list * sizeof(std::uint32_t));
    const gpu::Buffer& places =
        b.receivers.of(device, "receivers",
                       receivers * (flat ? sizeof(layout::PlanarReceiver) : sizeof(layout::CurvedReceiver)));
    const gpu::Buffer& irradiance =
        b.irradiance.of(device, "irradiance of receivers", receivers * sizeof(glm::vec3));
    if (flat) {
        b.frames.of(device, "frames", all.frames * sizeof(layout::CoverageFrame));
        b.landed.of(device, "landed beams", all.clusters * kClusterBeams * sizeof(layout::LandedBeam));
    }
    parallel_for(chunks.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) copy_work(chunks[c].works[key], before[c], b);
    });

    const SheetCoverage<float>& coverage = *sheets[key / kKinds];
    const Sheet& sheet = on_device[key / kKinds];
    CoveragePush push{glm::vec3(coverage.extinction()), static_cast<std::uint32_t>(all.blocks)};
    if (flat) {
        const gpu::Buffer &frames = *b.frames, &landed = *b.landed;
        gpu::Bindings landing{
            .buffers = {&sheet.rays, &sheet.power, &*triangles, &clusters, &frames, &landed},
            .writes = {&landed}};
        CoveragePush beams = push;
        beams.count = static_cast<std::uint32_t>(all.clusters * kClusterBeams);
        landing.set_push(beams);
        passes.compute("coverage", land, std::move(landing), groups(beams.count));
        gpu::Bindings covering{.buffers = {&landed, &blocks, &list, &places, &irradiance},
                               .writes = {&irradiance}};
        covering.set_push(push);
        passes.compute("coverage", cover_planar, std::move(covering), groups(all.blocks));
    } else {
        gpu::Bindings covering{.buffers = {&sheet.rays, &sheet.power, &*triangles, &clusters, &blocks, &list,
                                           &places, &irradiance},
                               .writes = {&irradiance}};
        covering.set_push(push);
        passes.compute("coverage", cover_curved, std::move(covering), groups(all.blocks));
    }
}

}  // namespace dapple::methods::sliced_beams
