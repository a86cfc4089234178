#include "methods/sliced_beams/layer_tiles.h"

#include <algorithm>
#include <cmath>

#include "view/camera.h"

namespace dapple::methods::sliced_beams {
namespace {

constexpr std::size_t kSide = 8;
/// Cosine between receivers' normals that tells one face from another: receivers of one plane are faster to
/// serve.
constexpr float kSameFace = 0.7f;
static_assert(kSide * kSide == kTileReceivers);

}  // namespace

ReceiverGroup ReceiverGroup::only(std::span<const std::size_t> indices) const {
    ReceiverGroup group{object, in_water, {}, {}, {}};
    for (const std::size_t i : indices) {
        group.pixels.push_back(pixels[i]);
        group.receivers.push_back(receivers[i]);
        group.points.push_back(points[i]);
    }
    return group;
}

LayerTiles::LayerTiles(const view::ReceiverLayer& layer, const scene::Clip& clip)
    : layer_(layer),
      across_((static_cast<std::size_t>(layer.width) + kSide - 1) / kSide),
      down_((static_cast<std::size_t>(layer.height) + kSide - 1) / kSide) {
    const view::Camera::SampleCell cell = view::Camera::sample_cell(layer.sample, clip.samples);
    const glm::dvec2 offset = view::Camera::sample_offset(layer.sample, clip.samples);
    shift_ = glm::vec2(cell.corner + 0.5 * cell.size - offset);
    size_ = glm::vec2(cell.size);
}

std::vector<ReceiverGroup> LayerTiles::groups(std::size_t tile) const {
    const std::size_t width = static_cast<std::size_t>(layer_.width);
    const std::size_t height = static_cast<std::size_t>(layer_.height);
    const std::size_t left = tile % across_ * kSide, top = tile / across_ * kSide;
    std::vector<ReceiverGroup> groups;
    // Two by two pixels, so that four receivers that follow each other lie together.
    for (std::size_t i = 0; i < kSide * kSide; ++i) {
        const std::size_t block = i / 4;
        const std::size_t x = left + 2 * (block % (kSide / 2)) + i % 2;
        const std::size_t y = top + 2 * (block / (kSide / 2)) + i / 2 % 2;
        if (x < width && y < height && (layer_.flags[y * width + x] & view::kReceiver))
            add(y * width + x, groups);
    }
    return groups;
}

void LayerTiles::add(std::size_t pixel, std::vector<ReceiverGroup>& groups) const {
    // Light is caught on the plane of the shading normal, like that of other lights.
    const glm::vec3 normal = layer_.shading_normal[pixel];
    const auto on_plane = [&](glm::vec3 edge) { return edge - glm::dot(edge, normal) * normal; };
    const glm::vec3 u = on_plane(layer_.footprint_u[pixel]), v = on_plane(layer_.footprint_v[pixel]);
    const float area = glm::length(glm::cross(u, v));
    if (!(area > 0) || !std::isfinite(area)) return;  // a footprint that says nothing: left to others
    const std::uint32_t object = layer_.object[pixel];
    const bool in_water = (layer_.flags[pixel] & view::kInWater) != 0;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const ReceiverGroup& g) {
        return g.object == object && g.in_water == in_water &&
               glm::dot(g.receivers.front().normal, normal) > kSameFace;
    });
    if (group == groups.end()) {
        group = groups.insert(groups.end(), ReceiverGroup{object, in_water, {}, {}, {}});
        group->pixels.reserve(kTileReceivers);
        group->receivers.reserve(kTileReceivers);
        group->points.reserve(kTileReceivers);
    }
    const glm::vec3 point = layer_.position[pixel];
    group->pixels.push_back(pixel);
    group->receivers.push_back({point + shift_.x * u + shift_.y * v, size_.x * u, size_.y * v, normal});
    group->points.push_back({point, size_.x * u, size_.y * v, normal});
}

}  // namespace dapple::methods::sliced_beams
