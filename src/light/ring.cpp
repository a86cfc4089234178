#include "light/ring.h"

#include <algorithm>

#include "base/parallel.h"

namespace dapple::light {
namespace {

bool meets(const TexelBox& part, glm::dvec2 lower, glm::dvec2 upper) {
    return upper.x >= part.first_column && lower.x <= part.first_column + part.columns &&
           upper.y >= part.first_row && lower.y <= part.first_row + part.rows;
}

/// Projects points of the water to columns and rows of the map.
class Projector {
public:
    explicit Projector(const MapPlan& plan)
        : plan_(plan), texel_from_map_(glm::inverse(plan.texel)), corner_(plan.corner()) {}
    /// False for a point that is no nearer to the water than the light.
    bool project(glm::dvec3 point, glm::dvec2& texel) const {
        const double w = 1 - plan_.inverse_height * point.y;
        texel = texel_from_map_ * ((glm::dvec2(point.x, point.z) - plan_.shear * point.y) / w - corner_);
        return w > 0;
    }

private:
    const MapPlan& plan_;
    glm::dmat2 texel_from_map_;
    glm::dvec2 corner_;
};

bool may_meet(const MapPlan& plan, const Projector& projector, const scene::TriangleMesh& water,
              glm::uvec3 corners) {
    constexpr double kRoom = 0.01;  // texels: what the device's own rounding moves
    glm::dvec2 lower(0), upper(0);
    for (int i = 0; i < 3; ++i) {
        glm::dvec2 texel;
        if (!projector.project(water.positions[corners[i]], texel)) return true;
        lower = i == 0 ? texel : glm::min(lower, texel);
        upper = i == 0 ? texel : glm::max(upper, texel);
    }
    return std::any_of(plan.parts.begin(), plan.parts.end(),
                       [&](const TexelBox& part) { return meets(part, lower - kRoom, upper + kRoom); });
}

}  // namespace

std::vector<TexelBox> ring(int columns, int rows, TexelRange hole_x, TexelRange hole_z) {
    const auto held = [](std::int64_t value, int most) {
        return static_cast<int>(std::clamp<std::int64_t>(value, 0, most));
    };
    const int left = held(hole_x.low, columns), right = held(hole_x.high + 1, columns);
    const int top = held(hole_z.low, rows), bottom = held(hole_z.high + 1, rows);
    if (left >= right || top >= bottom) return {{0, 0, columns, rows}};
    std::vector<TexelBox> parts;
    for (const TexelBox& part :
         {TexelBox{0, 0, columns, top}, TexelBox{0, top, left, bottom - top},
          TexelBox{right, top, columns - right, bottom - top}, TexelBox{0, bottom, columns, rows - bottom}}) {
        if (part.columns > 0 && part.rows > 0) parts.push_back(part);
    }
    return parts;
}

std::vector<glm::uvec3> triangles_of_ring(const MapPlan& plan, const scene::TriangleMesh& water) {
    constexpr std::size_t kTile = 1 << 14;
    const Projector projector(plan);
    std::vector<std::vector<glm::uvec3>> tiles(water.triangles.size() / kTile + 1);
    parallel_for(water.triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            if (may_meet(plan, projector, water, water.triangles[t]))
                tiles[begin / kTile].push_back(water.triangles[t]);
        }
    });
    std::vector<glm::uvec3> kept;
    for (const std::vector<glm::uvec3>& tile : tiles) kept.insert(kept.end(), tile.begin(), tile.end());
    return kept;
}

}  // namespace dapple::light
