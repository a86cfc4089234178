#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "light/water_beams.h"
#include "methods/sliced_beams/sheet_coverage.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

/// Sliced beams without a camera: chosen receivers under a water mesh made by the test, in double or float.
namespace dapple::test {

/// Height and slopes along x and z at (x, z), m.
using HeightField = std::function<glm::dvec3(double x, double z)>;

/// Water of cells_x by cells_z cells over size.x by size.y m about the origin, cut into triangles as the
/// ocean's is.
inline scene::FrameScene scene_of_water(glm::dvec2 size, int cells_x, int cells_z,
                                        const HeightField& height) {
    scene::FrameScene scene;
    scene.state.water.emplace();
    scene.state.water->extent.size = size;
    scene.state.water->absorption = {0, 0, 0};
    auto water = std::make_shared<scene::WaterMesh>();
    water->columns = cells_x + 1;
    water->rows = cells_z + 1;
    for (int row = 0; row <= cells_z; ++row) {
        for (int column = 0; column <= cells_x; ++column) {
            const double x = size.x * (static_cast<double>(column) / cells_x - 0.5);
            const double z = size.y * (static_cast<double>(row) / cells_z - 0.5);
            const glm::dvec3 h = height(x, z);
            water->mesh.positions.emplace_back(x, h.x, z);
            water->mesh.normals.push_back(glm::normalize(glm::dvec3(-h.y, 1, -h.z)));
            water->height_bound = std::max(water->height_bound, std::abs(h.x));
        }
    }
    water->largest_height = water->height_bound;
    for (int row = 0; row < cells_z; ++row) {
        for (int column = 0; column < cells_x; ++column) {
            const auto corner = static_cast<std::uint32_t>(row * water->columns + column);
            const auto below = corner + static_cast<std::uint32_t>(water->columns);
            water->mesh.triangles.emplace_back(corner, below, corner + 1);
            water->mesh.triangles.emplace_back(corner + 1, below, below + 1);
        }
    }
    scene.water = water;
    return scene;
}

inline scene::FrameScene scene_of_flat_water(glm::dvec2 size, int cells_x, int cells_z) {
    return scene_of_water(size, cells_x, cells_z, [](double, double) { return glm::dvec3(0); });
}

/// A rectangle of `size` about `centre` (relative to the origin), with the first edge across `normal` and
/// nearest to +x (to +y for walls that face along x).
template <class Real>
methods::sliced_beams::Receiver<Real> receiver(glm::dvec3 centre, glm::dvec3 normal, glm::dvec2 size) {
    const glm::dvec3 towards = std::abs(normal.x) > 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = glm::normalize(towards - glm::dot(towards, normal) * normal);
    using Vec = glm::vec<3, Real>;
    return {Vec(centre), Vec(size.x * u), Vec(size.y * glm::cross(u, normal)), Vec(normal)};
}

/// All sheets of a light's chain over a scene, which must outlive this.
template <class Real>
class SheetSet {
public:
    using Receiver = methods::sliced_beams::Receiver<Real>;

    /// No receiver lies deeper than `deepest` m along any axis.
    SheetSet(const scene::FrameScene& scene, light::Event event, double deepest, int sun_samples = 1)
        : rays_(scene) {
        FrameStats stats;
        for (auto& sheet : light::water_beams<Real>(scene, rays_, {0, event}, sun_samples, stats))
            sheets_.push_back(std::make_unique<methods::sliced_beams::SheetCoverage<Real>>(
                scene, rays_, std::move(sheet), static_cast<Real>(deepest)));
    }

    /// W/m^2, channels apart; receivers of one tile at a time, in their order.
    std::vector<glm::dvec3> irradiance(const std::vector<Receiver>& receivers) const {
        constexpr auto tile = static_cast<std::size_t>(methods::sliced_beams::kTileReceivers);
        std::vector<glm::vec<3, Real>> sums(receivers.size(), glm::vec<3, Real>(0));
        methods::sliced_beams::QueryCounts counts;
        for (const auto& sheet : sheets_) {
            for (std::size_t first = 0; first < receivers.size(); first += tile) {
                const std::size_t count = std::min(tile, receivers.size() - first);
                sheet->add(std::span(receivers).subspan(first, count), 0,
                           std::span(sums).subspan(first, count), counts);
            }
        }
        return {sums.begin(), sums.end()};
    }
    glm::dvec3 irradiance(const Receiver& receiver) const {
        return irradiance(std::vector<Receiver>{receiver})[0];
    }

    /// What the beams carry, W.
    glm::dvec3 power() const {
        glm::dvec3 sum(0);
        for (const auto& sheet : sheets_)
            for (std::size_t i = 0; i < sheet->sheet().flux.size(); ++i) sum += sheet->sheet().power(i);
        return sum;
    }
    const std::vector<std::unique_ptr<methods::sliced_beams::SheetCoverage<Real>>>& sheets() const {
        return sheets_;
    }

private:
    rays::RayScene rays_;
    std::vector<std::unique_ptr<methods::sliced_beams::SheetCoverage<Real>>> sheets_;
};

}  // namespace dapple::test
