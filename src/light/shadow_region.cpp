#include "light/shadow_region.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace dapple::light {
namespace {

constexpr int kSide = 512;  // cells along either axis of the projection
constexpr std::size_t kTile = 1 << 13;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t index_of(int column, int row) {
    return static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column);
}

struct Box {
    glm::dvec2 lower{kInfinity, kInfinity};
    glm::dvec2 upper{-kInfinity, -kInfinity};
    bool unknown = false;
};

}  // namespace

glm::dvec2 ShadowRegion::project(glm::dvec3 point) const {
    if (light_.type == scene::LightType::sun)
        return glm::dvec2(point.x, point.z) -
               glm::dvec2(light_.direction.x, light_.direction.z) * (point.y / light_.direction.y);
    const glm::dvec3 way = point - light_.position;
    const double ahead = -light_.side() * way.y;
    if (!(ahead > 0)) return glm::dvec2(std::numeric_limits<double>::quiet_NaN());
    return {std::atan(way.x / ahead), std::atan(way.z / ahead)};
}

glm::ivec2 ShadowRegion::cell(glm::dvec2 at) const {
    return glm::clamp(glm::ivec2((at - lower_) * cells_per_unit_), glm::ivec2(0), glm::ivec2(kSide - 1));
}

void ShadowRegion::mark(glm::dvec2 lower, glm::dvec2 upper) {
    const glm::ivec2 first = cell(lower), last = cell(upper);
    for (int row = first.y; row <= last.y; ++row)
        for (int column = first.x; column <= last.x; ++column) {
            // Threads may mark one cell at once; the marks are the same in any order.
            std::uint8_t& mark = marks_[index_of(column, row)];
            std::atomic_ref<std::uint8_t>(mark).store(1, std::memory_order_relaxed);
        }
}

ShadowRegion::ShadowRegion(const scene::WaterMesh& water, const WaterLight& light)
    : light_(light), everywhere_(water.rows == 0 && !water.one_sheet) {
    if (everywhere_) return;
    const scene::TriangleMesh& mesh = water.mesh;
    const auto visit_away = [&](std::size_t begin, std::size_t end, const auto& body) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::uvec3 t = mesh.triangles[i];
            if (!(incident_on_triangle(mesh, t, light) < 0)) continue;
            const glm::dvec2 a = project(mesh.positions[t.x]), b = project(mesh.positions[t.y]),
                             c = project(mesh.positions[t.z]);
            body(glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)), a.x + b.x + c.x);
        }
    };
    std::vector<Box> boxes(mesh.triangles.size() / kTile + 1);
    parallel_for(mesh.triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        Box& box = boxes[begin / kTile];
        visit_away(begin, end, [&](glm::dvec2 lower, glm::dvec2 upper, double known) {
            box.unknown |= !(std::abs(known) < kInfinity);
            box.lower = glm::min(box.lower, lower);
            box.upper = glm::max(box.upper, upper);
        });
    });
    Box all;
    for (const Box& box : boxes) {
        all.unknown |= box.unknown;
        all.lower = glm::min(all.lower, box.lower);
        all.upper = glm::max(all.upper, box.upper);
    }
    everywhere_ = all.unknown;
    if (everywhere_ || !(all.lower.x <= all.upper.x)) return;
    lower_ = all.lower;
    upper_ = all.upper;
    cells_per_unit_ = static_cast<double>(kSide) / glm::max(upper_ - lower_, glm::dvec2(1e-12));
    marks_.assign(std::size_t{kSide} * kSide, 0);
    parallel_for(mesh.triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        visit_away(begin, end, [&](glm::dvec2 lower, glm::dvec2 upper, double) { mark(lower, upper); });
    });
}

bool ShadowRegion::holds(glm::dvec3 point) const {
    if (everywhere_) return true;
    if (marks_.empty()) return false;
    const glm::dvec2 at = project(point);
    if (std::isnan(at.x)) return true;
    if (glm::any(glm::lessThan(at, lower_)) || glm::any(glm::greaterThan(at, upper_))) return false;
    const glm::ivec2 c = cell(at);
    return marks_[index_of(c.x, c.y)] != 0;
}

}  // namespace dapple::light
