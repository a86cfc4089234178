// Volumes about beams, and the areas of rings of beams.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "methods/adaptive_beams/bounding_volume.h"
#include "methods/adaptive_beams/ring_areas.h"

namespace dapple::methods::adaptive_beams {
namespace {

BeamSection random_beam(std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    BeamSection beam;
    for (auto* cap : {&beam.near, &beam.far})
        for (glm::dvec2& point : *cap) point = {uniform(random), uniform(random)};
    beam.near_depth = uniform(random);
    beam.far_depth = beam.near_depth + 2 + uniform(random);
    return beam;
}

TEST(BoundingVolume, IsClosedConvexAndHoldsTheBeam) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    int prisms = 0;
    constexpr int kBeams = 2000;
    for (int i = 0; i < kBeams; ++i) {
        const BeamSection beam = random_beam(random);
        for (const VolumeKind kind : {VolumeKind::prism, VolumeKind::six_triangles}) {
            const BoundingVolume volume = bounding_volume(beam, kind);
            prisms += kind == VolumeKind::six_triangles && volume.kind == VolumeKind::prism ? 1 : 0;
            std::map<std::pair<int, int>, int> edges;
            for (const auto& face : volume.face)
                for (std::size_t k = 0; k < 3; ++k) ++edges[{face[k], face[(k + 1) % 3]}];
            // Every edge once each way: watertight, and turned alike.
            ASSERT_EQ(edges.size(), 24u);
            for (const auto& [edge, count] : edges) {
                ASSERT_EQ(count, 1);
                ASSERT_EQ(edges.count({edge.second, edge.first}), 1u);
            }
            for (int j = 0; j < 30; ++j) {
                glm::dvec3 share(uniform(random), uniform(random), uniform(random));
                share /= share.x + share.y + share.z;
                const double way = uniform(random);
                glm::dvec3 point(0, 0, glm::mix(beam.near_depth, beam.far_depth, way));
                for (std::size_t k = 0; k < 3; ++k)
                    point +=
                        share[static_cast<int>(k)] * glm::dvec3(glm::mix(beam.near[k], beam.far[k], way), 0);
                for (const auto& face : volume.face) {
                    const glm::dvec3 a = volume.corner[face[0]], b = volume.corner[face[1]],
                                     c = volume.corner[face[2]];
                    // Rounding, of spikes a thousand times as long as the beam is wide.
                    ASSERT_LE(glm::dot(glm::normalize(glm::cross(b - a, c - a)), point - a), 1e-9);
                }
            }
        }
    }
    printf("%d of %d random beams are drawn as prisms for want of six triangles\n", prisms, kBeams);
    EXPECT_LT(prisms, kBeams / 20);
}

/// Twice the area of a cap's picture.
double cap_area(const BoundingVolume& volume, std::size_t first) {
    const glm::dvec3 a = volume.corner[first];
    return glm::length(glm::cross(volume.corner[first + 1] - a, volume.corner[first + 2] - a));
}

TEST(BoundingVolume, HoldsAMarginWithoutSpikes) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const double thickness : {1e-6, 1e-3, 0.1, 1.0})
        for (const double margin : {0.01, 0.3})
            for (const VolumeKind kind : {VolumeKind::prism, VolumeKind::six_triangles}) {
                BeamSection beam;
                beam.near = {glm::dvec2(0, 0), {1, 0}, {uniform(random), thickness}};
                beam.far = {glm::dvec2(0.2, 0.1), {1.3, 0.1}, {0.2 + uniform(random), 0.1 + thickness}};
                beam.far_depth = 3;
                beam.near_margin = beam.far_margin = margin;
                const BoundingVolume volume = bounding_volume(beam, kind);
                for (int j = 0; j < 300; ++j) {
                    const std::size_t k = static_cast<std::size_t>(j) % 3;
                    const double way = uniform(random), angle = 7 * uniform(random);
                    const glm::dvec3 point(glm::mix(beam.near[k], beam.far[k], way) +
                                               margin * glm::dvec2(std::cos(angle), std::sin(angle)),
                                           3 * way);
                    for (const auto& face : volume.face) {
                        const glm::dvec3 a = volume.corner[face[0]], b = volume.corner[face[1]],
                                         c = volume.corner[face[2]];
                        ASSERT_LE(glm::dot(glm::normalize(glm::cross(b - a, c - a)), point - a), 1e-9);
                    }
                }
                // Triangles about boxes have twice their area; a prism has the normals of one cap at both,
                // which may make the other tens of times as large. Spikes of slivers would be 10^4 times as
                // large.
                const double box = (1.1 + 2 * margin) * (thickness + 2 * margin);
                if (kind == VolumeKind::six_triangles && volume.kind == kind) {
                    EXPECT_LT(cap_area(volume, 0), 4.1 * box) << thickness << ' ' << margin;
                    EXPECT_LT(cap_area(volume, 3), 4.1 * box) << thickness << ' ' << margin;
                }
                EXPECT_LT(cap_area(volume, 0) + cap_area(volume, 3), 100 * box) << thickness << ' ' << margin;
            }
}

TEST(BoundingVolume, OfPlanarSidesIsAPrism) {
    BeamSection beam;
    beam.near = {glm::dvec2(0, 0), {1, 0}, {0, 1}};
    beam.far = {glm::dvec2(3, 1), {4, 1}, {3, 2}};
    beam.far_depth = 5;
    const BoundingVolume volume = bounding_volume(beam, VolumeKind::six_triangles);
    EXPECT_EQ(volume.kind, VolumeKind::prism);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_LT(glm::distance(volume.corner[k], glm::dvec3(beam.near[k], 0)), 1e-12);
        EXPECT_LT(glm::distance(volume.corner[3 + k], glm::dvec3(beam.far[k], 5)), 1e-12);
    }
}

/// Rays of a random lens: a grid of 8 by 8 cells, some of which turn over before depth 4.
BeamSet random_set() {
    std::mt19937 random(8);
    std::uniform_real_distribution<float> uniform(-1, 1);
    constexpr std::uint32_t kCells = 8;
    BeamSet set;
    for (std::uint32_t row = 0; row <= kCells; ++row)
        for (std::uint32_t column = 0; column <= kCells; ++column)
            set.vertices.push_back({0.1f * static_cast<float>(column), 0.1f * static_cast<float>(row),
                                    0.05f * uniform(random), 0.05f * uniform(random), 0.02f * uniform(random),
                                    4 + uniform(random)});
    for (std::uint32_t row = 0; row < kCells; ++row)
        for (std::uint32_t column = 0; column < kCells; ++column) {
            const std::uint32_t i = row * (kCells + 1) + column;
            set.triangles.emplace_back(i, i + kCells + 1, i + 1);
            set.triangles.emplace_back(i + 1, i + kCells + 1, i + kCells + 2);
        }
    for (std::size_t i = 0; i < set.triangles.size(); ++i)
        set.flux.push_back(glm::vec3(1 + uniform(random), 1, 2));
    return set;
}

TEST(RingAreas, CarryAllFluxThroughEveryPlane) {
    const BeamSet set = random_set();
    const RingAreas rings(set);
    EXPECT_GT(rings.turning.size(), 50u);  // the test has foci
    glm::dvec3 flux(0);
    for (const glm::vec3& f : set.flux) flux += glm::dvec3(f);
    double worst = 0;
    for (const double depth : {0.1, 0.7, 1.3, 2.2, 3.0, 3.7}) {
        glm::dvec3 sum(0);
        for (const glm::uvec3& triangle : set.triangles) {
            glm::dvec3 density(0);  // the mean over a triangle of what is interpolated in it
            for (int k = 0; k < 3; ++k)
                density += rings.flux[triangle[k]] / (3 * rings.area(set, triangle[k], depth));
            sum += std::abs(area_function(set, triangle, depth).q.x) * density;
        }
        for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(sum[c] / flux[c] - 1));
    }
    EXPECT_LT(worst, 1e-10);  // rounding of double, times the areas' cancellation
}

}  // namespace
}  // namespace dapple::methods::adaptive_beams
