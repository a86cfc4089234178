#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <string>
#include <vector>

#include "closed_form/flat_scene.h"
#include "light/water_beams.h"
#include "methods/sliced_beams/sheet_coverage.h"
#include "render/frame_scene_builder.h"

/// What the hard cases share: light caught by planes that close a scene in, without a camera.
namespace dapple::test {

/// A rectangle that catches light on one side: corner, edges, m, world. cross(v, u) points to that side.
struct Catcher {
    glm::dvec3 corner, u, v;
};

/// The six insides of a box.
inline std::vector<Catcher> inside_of_box(glm::dvec3 low, glm::dvec3 high) {
    const glm::dvec3 x(high.x - low.x, 0, 0), y(0, high.y - low.y, 0), z(0, 0, high.z - low.z);
    return {{low, x, z}, {low + y, z, x}, {low, z, y}, {low + x, y, z}, {low, y, x}, {low + z, x, y}};
}

/// The sheets of one chain of a scene without objects, and what their light comes to.
class CaughtLight {
public:
    CaughtLight(const scene::FrameState& state, light::Event event)
        : scene_(render::FrameSceneBuilder().build(state)), rays_(scene_) {
        for (auto& sheet : light::water_beams<float>(scene_, rays_, {0, event}, 1, stats_)) {
            for (std::size_t i = 0; i < sheet.flux.size(); ++i) carried_ += sheet.power(i).r;
            sheets_.push_back(std::make_unique<methods::sliced_beams::SheetCoverage<float>>(
                scene_, rays_, std::move(sheet), kDeepest));
        }
    }

    /// Power on the catchers in the red channel, W, each in `parts` by `parts` receivers; not absorbed.
    double on(const std::vector<Catcher>& catchers, int parts = 64) const {
        double sum = 0;
        for (const Catcher& catcher : catchers) sum += on(catcher, parts);
        return sum;
    }
    double on(const Catcher& catcher, int parts) const {
        constexpr int kSide = 8;  // of a tile of receivers
        const glm::dvec3 u = catcher.u / static_cast<double>(parts);
        const glm::dvec3 v = catcher.v / static_cast<double>(parts);
        const glm::dvec3 normal = glm::normalize(glm::cross(v, u));
        double sum = 0;
        const int across = parts / kSide;
        for (int tile = 0; tile < across * across; ++tile) {
            std::vector<methods::sliced_beams::Receiver<float>> receivers;
            for (int k = 0; k < kSide * kSide; ++k) {
                const int row = tile / across * kSide + k / kSide, column = tile % across * kSide + k % kSide;
                const double i = row + 0.5, j = column + 0.5;
                receivers.push_back({glm::vec3(catcher.corner + i * u + j * v - scene_.origin), glm::vec3(u),
                                     glm::vec3(v), glm::vec3(normal)});
            }
            std::vector<glm::vec3> irradiance(receivers.size(), glm::vec3(0));
            for (const auto& sheet : sheets_) sheet->add(receivers, 0, irradiance, counts_);
            for (const glm::vec3& e : irradiance) {
                EXPECT_TRUE(std::isfinite(e.x + e.y + e.z));
                sum += static_cast<double>(e.x);
            }
        }
        return sum * glm::length(glm::cross(u, v));
    }

    /// W in the red channel, of the beams.
    double carried() const { return carried_; }
    /// What the catchers asked for so far miss of beams that meet their planes from both sides, W.
    double parted() const { return counts_.parted; }
    /// A count of the stats of a light that is white, W.
    double lost(const std::string& name) const { return stats_.counted(name); }
    /// All that no beam carries.
    double lost() const {
        return lost("lost to wave shadow, W") + lost("lost to total reflection, W") +
               lost("lost outside cones, W") + lost("lost to normals not finite, W");
    }
    const scene::FrameScene& scene() const { return scene_; }

private:
    static constexpr float kDeepest = 40;  // m along any axis
    scene::FrameScene scene_;
    rays::RayScene rays_;
    FrameStats stats_;
    std::vector<std::unique_ptr<methods::sliced_beams::SheetCoverage<float>>> sheets_;
    double carried_ = 0;
    mutable methods::sliced_beams::QueryCounts counts_;
};

/// What the light sends onto the sides of the water's triangles that face it, and what the water would pass
/// if every triangle were a plane: W for a sun of 1 W/m^2 in air. Written apart from the program's physics.
struct SunOnMesh {
    double met = 0;
    double passed = 0;
};
inline SunOnMesh sun_on_mesh(const scene::TriangleMesh& mesh, glm::dvec3 direction, double index) {
    SunOnMesh sum;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
        const glm::dvec3 across = glm::cross(b - a, c - a);
        const double met = -0.5 * glm::dot(across, direction);
        if (!(met > 0) || !std::isfinite(met)) continue;
        const double i = std::acos(std::min(1.0, 2 * met / glm::length(across)));
        const double t_angle = std::asin(std::sin(i) / index);
        const double s = std::sin(i - t_angle) / std::sin(i + t_angle);
        const double p = std::tan(i - t_angle) / std::tan(i + t_angle);
        sum.met += met;
        sum.passed += i < 1e-6 ? met * 4 * index / std::pow(index + 1, 2) : met * (1 - 0.5 * (s * s + p * p));
    }
    return sum;
}

/// A white sun of 1 W/m^2 without a disc.
inline scene::Light white_sun(double zenith_degrees) {
    scene::Light sun = sun_from_zenith(zenith_degrees);
    sun.irradiance = glm::dvec3(1);
    return sun;
}

/// Open water of `patch` m over a floor, nothing absorbed.
inline scene::FrameState clear_sea(double patch, double zenith_degrees, int cells) {
    scene::FrameState state = pool_over_floor(patch, 2, 8, 32);
    state.caustics.method = "sliced_beams";
    state.water->extent.kind = scene::ExtentKind::open_water;
    state.water->absorption = glm::dvec3(0);
    state.water->mesh_cells = cells;
    state.lights = {white_sun(zenith_degrees)};
    return state;
}

inline scene::Wave wave(double length, double heading_degrees, double amplitude, double phase = 0) {
    scene::Wave w;
    w.length = length;
    w.heading = glm::radians(heading_degrees);
    w.amplitude = amplitude;
    w.phase = phase;
    return w;
}

}  // namespace dapple::test
