#include "methods/sliced_beams/coverage_work.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods::sliced_beams {
namespace {

layout::CoverageFrame frame_of(const Receiver<float>& receiver) {
    const LandingFrame<float> f(receiver);
    return {f.position, f.normal, f.along_x, f.along_y};
}

}  // namespace

CoverageWorkBuilder::CoverageWorkBuilder(const Tile<float>& tile, std::span<const std::size_t> pixels)
    : tile_(tile), pixels_(pixels), planar_(tile.planar()) {}

void CoverageWorkBuilder::add_to(CoverageWork& work) const {
    const auto first_cluster = static_cast<std::uint32_t>(work.clusters.size());
    add_clusters(work);
    add_lists(work, first_cluster);
    if (planar_)
        add_planar(work);
    else
        add_curved(work);
    const std::size_t blocks = (tile_.locals_.size() + kBlockReceivers - 1) / kBlockReceivers;
    for (const auto& local : tile_.locals_) work.pixels.push_back(pixels_[local.index]);
    work.pixels.resize(work.pixels.size() + blocks * kBlockReceivers - tile_.locals_.size(), kNoPixel);
}

void CoverageWorkBuilder::add_clusters(CoverageWork& work) const {
    const auto frame = static_cast<std::uint32_t>(work.frames.size());
    for (const auto& node : tile_.clusters_) {
        layout::CoverageCluster& cluster = work.clusters.emplace_back();
        const auto beams = tile_.pyramid_.beams(node);
        std::copy(beams.begin(), beams.end(), cluster.beam);
        cluster.frame = planar_ ? frame : 0;
    }
}

/// The clusters that can matter to each block, by the bounds of their beams at the block's own depths.
void CoverageWorkBuilder::add_lists(CoverageWork& work, std::uint32_t first_cluster) const {
    const auto& nodes = tile_.clusters_;
    std::vector<Box<float>> boxes(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) boxes[i] = tile_.box(nodes[i]);
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const auto& locals = tile_.locals_;
    for (std::size_t first = 0; first < locals.size(); first += kBlockReceivers) {
        Box<float> bounds{infinity, -infinity, infinity, -infinity};
        float low = infinity, high = -infinity;
        for (std::size_t i = first; i < std::min(first + kBlockReceivers, locals.size()); ++i) {
            const auto& local = locals[i];
            const glm::vec3 p = local.receiver.position;
            bounds.low_a = std::min(bounds.low_a, p.x - local.half_a);
            bounds.high_a = std::max(bounds.high_a, p.x + local.half_a);
            bounds.low_b = std::min(bounds.low_b, p.y - local.half_b);
            bounds.high_b = std::max(bounds.high_b, p.y + local.half_b);
            low = std::min(low, p.z - local.half_depth);
            high = std::max(high, p.z + local.half_depth);
        }
        // Where the tile is level in the light, its own boxes are as good.
        // Positions are rounded, and those of a planar tile lie off its plane by as much as planar() takes
        // for rounding; seen along the axis that is more by the plane's slant.
        const Receiver<float>& r = locals[first].receiver;
        const float size = std::max({std::abs(r.position.x), std::abs(r.position.y), std::abs(r.position.z)});
        const float margin =
            32 * std::numeric_limits<float>::epsilon() * size / std::max(std::abs(r.normal.z), 0.01f);
        bounds = {bounds.low_a - margin, bounds.high_a + margin, bounds.low_b - margin,
                  bounds.high_b + margin};
        low -= margin;
        high += margin;
        const bool slanted = 2 * (high - low) < tile_.high_ - tile_.low_;
        const auto box = [&](const auto& node) {
            return planar_ ? tile_.box(node, r, low, high) : tile_.pyramid_.box(node, low, high, tile_.lean_);
        };
        layout::CoverageBlock& block = work.blocks.emplace_back();
        block.first = static_cast<std::uint32_t>(work.list.size());
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (overlap(boxes[i], bounds) && (!slanted || overlap(box(nodes[i]), bounds)))
                work.list.push_back(first_cluster + static_cast<std::uint32_t>(i));
        block.last = static_cast<std::uint32_t>(work.list.size());
    }
}

/// As Tile::add_planar: beams are landed in the frame of the first receiver and moved to the others'.
void CoverageWorkBuilder::add_planar(CoverageWork& work) const {
    const Receiver<float>& first = tile_.locals_.front().receiver;
    const layout::CoverageFrame frame = work.frames.emplace_back(frame_of(first));
    for (const auto& local : tile_.locals_) {
        const Receiver<float>& r = local.receiver;
        const glm::vec3 offset = r.position - first.position;
        const float ux = glm::dot(frame.along_x, r.u), uy = glm::dot(frame.along_y, r.u);
        const float vx = glm::dot(frame.along_x, r.v), vy = glm::dot(frame.along_y, r.v);
        const float scale = 1 / (ux * vy - uy * vx);
        work.planar.push_back({{glm::dot(frame.along_x, offset), glm::dot(frame.along_y, offset)},
                               {scale * vy, -scale * vx},
                               {-scale * uy, scale * ux},
                               local.inverse_area});
    }
    const std::size_t missing = kBlockReceivers * work.blocks.size() - work.planar.size();
    work.planar.resize(work.planar.size() + missing, layout::PlanarReceiver{});
}

void CoverageWorkBuilder::add_curved(CoverageWork& work) const {
    for (const auto& local : tile_.locals_)
        work.curved.push_back({frame_of(local.receiver), local.inverse_area});
    const std::size_t missing = kBlockReceivers * work.blocks.size() - work.curved.size();
    layout::CurvedReceiver none = work.curved.back();
    none.inverse_area = 0;
    work.curved.resize(work.curved.size() + missing, none);
}

}  // namespace dapple::methods::sliced_beams
