#include "methods/sliced_beams/scatter_pass.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "base/parallel.h"
#include "gpu/pass_list.h"
#include "methods/sliced_beams/scatter_query.h"
#include "methods/sliced_beams/scatter_tree.h"
#include "spirv/sliced_beams_scatter_comp.h"

namespace dapple::methods::sliced_beams {
namespace {

static_assert(sizeof(layout::ScatterRay) == 20);
static_assert(sizeof(layout::ScatterBeam) == 32);
static_assert(sizeof(layout::ScatterNode) == 56);
static_assert(sizeof(layout::ScatterSlab) == 12);
static_assert(sizeof(layout::ScatterSegment) == 28);
static_assert(sizeof(layout::ScatterSum) == 44);
static_assert(sizeof(layout::ScatterPush) == 112);

constexpr std::size_t kGroup = 64;  ///< invocations of a work group
/// Segments of a dispatch; what the shader does of each ends at what scatter.comp's kMostWork says.
constexpr std::size_t kSegmentsAtOnce = 1 << 15;
constexpr std::size_t kMostNodes = 1 << 26;  ///< whose pieces the shader can number in 32 bits
constexpr std::size_t kPatches = 16;         ///< whose segments one thread collects

template <class T>
gpu::Buffer uploaded(gpu::Device& device, std::string_view name, std::span<const T> values) {
    gpu::Buffer buffer(device, name, values.size_bytes(), gpu::BufferMemory::device);
    std::copy(values.begin(), values.end(), buffer.as<T>().begin());
    return buffer;
}

/// Segments in the water, in the order of the groups.
struct Collected {
    std::vector<layout::ScatterSegment> segments;
    std::vector<std::uint32_t> index;  ///< into the layer
};

Collected collect(const LayerSegments& segments, float longest) {
    std::vector<Collected> parts(segments.patches() / kPatches + 1);
    parallel_for(segments.patches(), kPatches, [&](std::size_t begin, std::size_t end) {
        Collected& part = parts[begin / kPatches];
        for (std::size_t patch = begin; patch < end; ++patch) {
            for (const LayerGroup& group : segments.groups(patch)) {
                if (!group.in_water) continue;
                const SegmentGroup<float>& s = group.segments;
                for (std::size_t lane = 0; lane < group.segment.size(); ++lane) {
                    if (!(s.length[lane] >= 0)) continue;
                    part.segments.push_back(
                        {{s.origin[0][lane], s.origin[1][lane], s.origin[2][lane]},
                         {s.direction[0][lane], s.direction[1][lane], s.direction[2][lane]},
                         std::min(s.length[lane], longest)});
                    part.index.push_back(group.segment[lane]);
                }
            }
        }
    });
    Collected all;
    for (const Collected& part : parts) {
        all.segments.insert(all.segments.end(), part.segments.begin(), part.segments.end());
        all.index.insert(all.index.end(), part.index.begin(), part.index.end());
    }
    return all;
}

/// Completes what a sheet has begun, whose colour stands in `scattered`.
layout::ScatterPush completed(layout::ScatterPush push, const ScatterPass::Direction& direction,
                              const EvenMedium<float>& medium) {
    push.shift = direction.light.shift;
    for (int c = 0; c < 3; ++c) {
        push.extinction[c] = medium.extinction[c];
        push.scattered[c] *= direction.share * medium.scattering[c];
    }
    // Lobes that are missing: 0 / 1.
    for (glm::vec3& lobe : push.lobes) lobe = {0, 1, 0};
    const auto lobes = medium.phase->lobes();
    for (std::size_t i = 0; i < lobes.size(); ++i)
        push.lobes[i] = {lobes[i].share, lobes[i].least, lobes[i].grows};
    push.even = medium.phase->even() ? medium.phase->constant() : 0;
    if (!medium.phase->values().empty())
        push.cells = static_cast<std::uint32_t>(medium.phase->values().size() - 2);
    return push;
}

}  // namespace

struct ScatterPass::State {
    explicit State(gpu::Device& d)
        : device(d),
          scatter(d, "light scattered out of beams", sliced_beams_scatter_comp,
                  {.storage_buffers = 8, .push_bytes = sizeof(layout::ScatterPush)}),
          segments(d, "segments", kSegmentsAtOnce * sizeof(layout::ScatterSegment),
                   gpu::BufferMemory::device),
          sums(d, "scattered light", kSegmentsAtOnce * sizeof(layout::ScatterSum)) {}

    struct Sheet {
        gpu::Buffer slabs, nodes, beams, rays, stops;
        std::uint32_t end;         ///< of the nodes
        layout::ScatterPush push;  ///< axes, colour, size
    };
    void run(const Sheet& sheet, layout::ScatterPush push, const gpu::Buffer& phases, std::size_t count,
             FrameStats& stats);

    gpu::Device& device;
    gpu::ComputePipeline scatter;
    gpu::Buffer segments, sums;
    std::map<std::size_t, Sheet> sheets;
};

ScatterPass::ScatterPass(gpu::Device& device) : state_(std::make_unique<State>(device)) {}
ScatterPass::~ScatterPass() = default;

void ScatterPass::clear() {
    state_->sheets.clear();
}

bool ScatterPass::takes(std::size_t index) const {
    return state_->sheets.contains(index);
}

bool ScatterPass::take(const ScatterSheet<float>& sheet, std::size_t index) {
    const ScatterTree tree(sheet);
    if (tree.beams.empty()) return false;
    const auto fits = [&](const auto& values) {
        return values.size() * sizeof(values[0]) <= state_->device.largest_storage_range();
    };
    if (!fits(tree.nodes) || !fits(tree.beams) || !fits(tree.rays) || tree.nodes.size() > kMostNodes)
        return false;
    gpu::Device& device = state_->device;
    const light::BeamSheet<float>& from = sheet.coverage().sheet();
    layout::ScatterPush push{};
    push.axis_a = glm::vec3(from.world_from_mesh[0]);
    push.axis_b = glm::vec3(from.world_from_mesh[1]);
    push.axis_depth = glm::vec3(from.world_from_mesh[2]);
    push.scattered = glm::vec3(from.color);
    push.largest = tree.largest;
    push.slabs = static_cast<std::uint32_t>(tree.slabs.size());
    State::Sheet taken{uploaded<layout::ScatterSlab>(device, "slabs of depth", tree.slabs),
                       uploaded<layout::ScatterNode>(device, "nodes of beams", tree.nodes),
                       uploaded<layout::ScatterBeam>(device, "beams", tree.beams),
                       uploaded<layout::ScatterRay>(device, "rays in media", tree.rays),
                       uploaded<float>(device, "stops of rays", tree.stops),
                       tree.slabs.back().end,
                       push};
    state_->sheets.insert_or_assign(index, std::move(taken));
    return true;
}

/// One direction of a sheet and some segments, until all have been walked to their ends.
void ScatterPass::State::run(const Sheet& sheet, layout::ScatterPush push, const gpu::Buffer& phases,
                             std::size_t count, FrameStats& stats) {
    const auto found = sums.as<layout::ScatterSum>().first(count);
    std::fill(found.begin(), found.end(), layout::ScatterSum{});
    push.count = static_cast<std::uint32_t>(count);
    do {
        gpu::PassList passes(device);
        gpu::Bindings bindings{.buffers = {&sheet.slabs, &sheet.nodes, &sheet.beams, &sheet.rays,
                                           &sheet.stops, &phases, &segments, &sums},
                               .writes = {&sums}};
        bindings.set_push(push);
        passes.compute("scattering", scatter, std::move(bindings),
                       {static_cast<std::uint32_t>((count + kGroup - 1) / kGroup), 1, 1});
        passes.run(stats);
    } while (std::any_of(found.begin(), found.end(), [&](const auto& sum) { return sum.node < sheet.end; }));
}

void ScatterPass::add(const LayerSegments& layer, std::span<const Direction> directions,
                      const EvenMedium<float>& medium, std::span<glm::vec3> radiance, ScatterCounts& counts,
                      FrameStats& stats) {
    if (directions.empty()) return;
    State& s = *state_;
    Collected all;
    std::optional<gpu::Buffer> phases;
    {
        const ScopedPass pass(stats, "scattering");
        const float longest = medium.least > 0 ? static_cast<float>(media::kOpaque) / medium.least
                                               : std::numeric_limits<float>::max();
        all = collect(layer, longest);
        const float none[1] = {0};
        const auto values = medium.phase->values();
        phases.emplace(uploaded<float>(s.device, "phase function", values.empty() ? none : values));
    }
    for (std::size_t first = 0; first < all.index.size(); first += kSegmentsAtOnce) {
        const std::size_t count = std::min(kSegmentsAtOnce, all.index.size() - first);
        std::copy_n(all.segments.begin() + static_cast<std::ptrdiff_t>(first), count,
                    s.segments.as<layout::ScatterSegment>().begin());
        for (const Direction& direction : directions) {
            const State::Sheet& sheet = s.sheets.at(direction.sheet);
            s.run(sheet, completed(sheet.push, direction, medium), *phases, count, stats);
            const ScopedPass pass(stats, "scattering");
            const auto sums = s.sums.as<layout::ScatterSum>();
            for (std::size_t i = 0; i < count; ++i) {
                const layout::ScatterSum& sum = sums[i];
                radiance[all.index[first + i]] += sum.radiance;
                counts.clusters += sum.clusters;
                counts.beams += sum.beams;
                counts.intervals += sum.intervals;
                counts.peaks += sum.peaks;
                counts.cut += sum.cut;
                counts.foci += sum.foci;
                counts.dropped += sum.dropped;
            }
        }
    }
    stats.count("segments walked on the device", static_cast<double>(all.index.size() * directions.size()));
}

}  // namespace dapple::methods::sliced_beams
