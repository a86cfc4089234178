// Light that a cloud of voxels scatters and dims under flat water, against fine marching.
#include <gtest/gtest.h>

#include "closed_form/beam_sheets.h"
#include "closed_form/cloud.h"
#include "closed_form/flat_scene.h"
#include "closed_form/segment_row.h"
#include "media/media.h"
#include "methods/sliced_beams/volume_light.h"

namespace dapple {
namespace {

using test::Ends;

constexpr double kIndex = 1.333;

/// Flat water of cells `cell` m wide with a cloud of voxels 0.1 m apart in it; the steepest change of its
/// density is 1.4 a metre.
scene::FrameScene cloudy_pool(double cell, double extinction) {
    constexpr double size = 7;
    const int cells = static_cast<int>(size / cell);
    scene::FrameScene scene = test::scene_of_flat_water({size, size}, cells, cells);
    scene.state.lights = {test::sun_from_zenith(30)};
    scene.state.water->absorption = {0.2, 0.1, 0.05};
    scene::Medium& cloud = scene.state.media.emplace_back();
    cloud.type = scene::MediumType::grid;
    cloud.side = scene::MediumSide::water;
    cloud.extinction = extinction * glm::dvec3(0.5, 0.8, 1);
    cloud.albedo = {0.9, 0.8, 0.7};
    cloud.transform.position = {0, -1.3, 0};
    scene.medium_grids = {test::cloud(0.3)};
    return scene;
}

std::vector<Ends> segments() {
    std::vector<Ends> all;
    for (int i = 0; i < 24; ++i) {
        const double turn = 0.9 * i, off = 0.05 * (i % 7) - 0.15;
        const glm::dvec3 across(std::cos(turn), 0, std::sin(turn)), centre(off, -1.3 + 0.04 * (i % 9), -off);
        const glm::dvec3 direction = glm::normalize(across + glm::dvec3(0, 0.3 * std::sin(1.7 * i), 0));
        all.push_back({centre - 1.6 * direction, centre + 1.6 * direction});
    }
    // Up and down, and nearly along the light and against it.
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 at(0.09 * i - 0.3, 0, 0.05 * i);
        all.push_back({at + glm::dvec3(0, -2.5, 0), at + glm::dvec3(0, -0.1, 0)});
        all.push_back({at + glm::dvec3(0, -0.1, 0), at + glm::dvec3(0.9, -2.4, 0)});
    }
    return all;
}

std::vector<glm::vec3> scattered(const scene::FrameScene& scene, const std::vector<Ends>& ends) {
    const test::SheetSet<float> set(scene, light::Event::transmission, 4);
    const view::SegmentLayer layer = test::row_of_segments(ends);
    std::vector<glm::vec3> radiance(ends.size(), glm::vec3(0));
    FrameStats stats;
    methods::sliced_beams::ScatterCounts counts;
    methods::sliced_beams::VolumeLight(scene, set.sheets(), stats).add(layer, radiance, counts);
    return radiance;
}

/// By steps of 0.8 mm. The refracted sun is one direction, and its way through the cloud exact.
glm::dvec3 marched(const scene::FrameScene& scene, const media::Media& media, const Ends& ends) {
    const double sin_t = std::sin(glm::radians(30.0)) / kIndex, cos_t = std::sqrt(1 - sin_t * sin_t);
    const glm::dvec3 sun = scene.state.lights[0].direction;
    const glm::dvec3 travel = glm::normalize(glm::dvec3(sun.x * sin_t / 0.5, -cos_t, sun.z * sin_t / 0.5));
    const scene::Medium& cloud = scene.state.media[0];
    const glm::dvec3 fluence =
        scene.state.lights[0].irradiance * test::flat_floor(30, 1, kIndex).irradiance / cos_t;
    const double length = glm::length(ends.to - ends.from);
    const int steps = static_cast<int>(length / 0.8e-3);
    const double step = length / steps;
    glm::dvec3 sum(0), seen(0);
    for (int i = 0; i < steps; ++i) {
        const glm::dvec3 p = glm::mix(ends.from, ends.to, (i + 0.5) / steps);
        const double density = media.density(1, p, true);
        const glm::dvec3 lost = scene.state.water->extinction() + density * cloud.extinction;
        const glm::dvec3 met =
            density > 0 ? media.optical_depth(p, -travel, -p.y / cos_t, true) : glm::dvec3(0);
        sum += step * density * cloud.extinction * cloud.albedo * glm::exp(-seen - 0.5 * step * lost - met);
        seen += step * lost;
    }
    return 0.25 / glm::pi<double>() * fluence * sum;
}

/// Beams narrower than voxels are taken in one part an interval, wider ones piece by piece, and in a dense
/// cloud beams' own rays are not enough to tell its face.
TEST(ScatterGrid, OfACloudIsFineMarching) {
    const std::vector<Ends> ends = segments();
    struct Case {
        double cell, extinction, most;
    };
    // Along a ray columns are off by an optical depth of 5e-3 at most, where the density bends most. Between
    // rays 0.2 m apart ripples 0.7 m long are off by a fifth.
    for (const auto& [cell, extinction, most] :
         {Case{0.03, 3, 1e-3}, Case{0.2, 3, 1e-2}, Case{0.03, 40, 2e-3}, Case{0.2, 40, 1e-2}}) {
        const scene::FrameScene scene = cloudy_pool(cell, extinction);
        const media::Media media(scene);
        const std::vector<glm::vec3> found = scattered(scene, ends);
        double worst = 0, absolute = 0, whole = 0;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const glm::dvec3 expected = marched(scene, media, ends[i]);
            for (int c = 0; c < 3; ++c) {
                const double off = static_cast<double>(found[i][c]) - expected[c];
                worst = std::max(worst, std::abs(off) / expected[c]);
                absolute += std::abs(off);
                whole += expected[c];
            }
        }
        printf("cells of %.2f m, %2.0f /m: S off by %.1e, L1 %.1e\n", cell, extinction, worst,
               absolute / whole);
        EXPECT_LT(absolute, most * whole);
    }
}

}  // namespace
}  // namespace dapple
