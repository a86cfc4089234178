// Receivers that a wide sun lets share the nodes of a lattice, against the same asked one by one.
#include <gtest/gtest.h>

#include <cmath>

#include "base/stats.h"
#include "gpu/validated_device.h"
#include "light/water_beams.h"
#include "methods/coverage_scene.h"
#include "methods/sliced_beams/layer_tiles.h"
#include "methods/sliced_beams/sheet_coverage.h"

namespace dapple {
namespace {

using methods::CoverageBackend;
using methods::LayerResult;
using namespace methods::sliced_beams;

constexpr double kDisc = 6;  // deg: on the floor 2 m down 30 cm wide, 10 to 20 pixels
constexpr light::Chain kChain{0, light::Event::transmission};

std::vector<std::unique_ptr<SheetCoverage<float>>> sheets_of(const scene::FrameScene& scene,
                                                             const rays::RayScene& rays, int sun_samples) {
    std::vector<std::unique_ptr<SheetCoverage<float>>> sheets;
    FrameStats stats;
    for (light::BeamSheet<float>& sheet : light::water_beams<float>(scene, rays, kChain, sun_samples, stats))
        sheets.push_back(std::make_unique<SheetCoverage<float>>(scene, rays, std::move(sheet), 10.0f));
    return sheets;
}

std::vector<glm::vec3> one_by_one(const scene::FrameScene& scene, const view::ReceiverLayer& layer,
                                  int sun_samples) {
    const rays::RayScene rays(scene);
    const auto sheets = sheets_of(scene, rays, sun_samples);
    const LayerTiles tiles(layer, scene.state.clip);
    std::vector<glm::vec3> irradiance(layer.pixels(), glm::vec3(0));
    QueryCounts counts;
    for (std::size_t tile = 0; tile < tiles.count(); ++tile) {
        for (const ReceiverGroup& group : tiles.groups(tile)) {
            if (!group.in_water) continue;
            std::vector<glm::vec3> own(group.pixels.size(), glm::vec3(0));
            for (const auto& sheet : sheets) sheet->add(group.receivers, group.object, own, counts);
            for (std::size_t k = 0; k < own.size(); ++k) irradiance[group.pixels[k]] = own[k];
        }
    }
    return irradiance;
}

/// Mean distance over the mean.
double distance(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        difference += std::abs(static_cast<double>(a[i].y) - static_cast<double>(b[i].y));
        sum += static_cast<double>(b[i].y);
    }
    return difference / sum;
}

TEST(CoverageLattice, SharedReceiversAreAsNearTheTruthAsThoseAskedOneByOne) {
    const scene::FrameScene scene = test::pool_scene(160, 90, 100, kDisc);
    test::CoverageFrame frame(test::validated_device(), scene);
    methods::SlicedBeams method(CoverageBackend::cpu);
    FrameStats stats;
    const std::vector<glm::vec3> shared = frame.irradiance(method, stats)[0].irradiance;
    const std::vector<glm::vec3> alone = one_by_one(scene, frame.layers()[0], 1);
    // The disc in 19 parts, each widened by less than a quarter as much.
    const std::vector<glm::vec3> truth = one_by_one(scene, frame.layers()[0], 19);
    const double of_shared = distance(shared, truth), of_alone = distance(alone, truth);
    printf("%.0f nodes; L1 from the disc in parts %.4f, one by one %.4f; between them %.4f\n",
           stats.counted("lattice nodes"), of_shared, of_alone, distance(shared, alone));
    // Many to a node, or there would be nothing to share.
    EXPECT_GT(stats.counted("lattice nodes"), 500);
    EXPECT_LT(stats.counted("lattice nodes"), 160 * 90 / 4);
    // The lattice's parallelograms lie otherwise than the pixels', so that the two differ by as much as
    // either is off from an ellipse; interpolation between nodes 0.3 to 0.43 of their width apart adds a
    // tenth of that at most.
    EXPECT_LT(of_shared, 1.1 * of_alone);
    EXPECT_LT(of_alone, 0.06);
}

TEST(CoverageLattice, KeepsTheEdgesOfShadows) {
    const scene::FrameScene scene = test::pool_scene(320, 180, 100, kDisc);
    test::CoverageFrame frame(test::validated_device(), scene);
    methods::SlicedBeams method(CoverageBackend::cpu);
    FrameStats stats;
    const std::vector<glm::vec3> shared = frame.irradiance(method, stats)[0].irradiance;
    const std::vector<glm::vec3> alone = one_by_one(scene, frame.layers()[0], 1);
    // Where light ends from a pixel to the next.
    double difference = 0, light = 0;
    std::size_t edges = 0;
    for (std::size_t i = 1; i < alone.size(); ++i) {
        const auto at = static_cast<double>(alone[i].y), beside = static_cast<double>(alone[i - 1].y);
        if (std::max(at, beside) == 0 || std::min(at, beside) > 0.2 * std::max(at, beside)) continue;
        ++edges;
        light += at + beside;
        difference += std::abs(at - static_cast<double>(shared[i].y)) +
                      std::abs(beside - static_cast<double>(shared[i - 1].y));
    }
    printf("%.0f nodes; %zu edges, L1 there %.1e\n", stats.counted("lattice nodes"), edges,
           difference / light);
    EXPECT_GT(stats.counted("lattice nodes"), 500);
    EXPECT_GT(edges, 100u);
    // No more than the 0.9 % by which the two differ anywhere; interpolated across the edges it is 2 %.
    EXPECT_LT(difference, 0.009 * light);
}

TEST(CoverageLattice, GivesTheSameBitsForLayersTogetherAndOnTheDevice) {
    const scene::FrameScene scene = test::pool_scene(160, 90, 100, kDisc);
    test::CoverageFrame frame(test::validated_device(), scene);
    methods::SlicedBeams cpu(CoverageBackend::cpu), compute(CoverageBackend::compute);
    FrameStats stats, together;
    const LayerResult first = frame.irradiance(cpu, stats)[0];
    const LayerResult device = frame.irradiance(compute, stats)[0];
    ASSERT_GT(stats.counted("lattice nodes"), 0);
    // Another layer asks for nodes of its own, and for others before these.
    view::ReceiverLayer other = frame.layers()[0];
    for (glm::vec3& position : other.position) position.x += 0.013f;
    frame.layers().push_back(other);
    const std::vector<LayerResult> both = frame.irradiance(cpu, together);
    EXPECT_EQ(first.irradiance, both[0].irradiance);
    EXPECT_NE(first.irradiance, both[1].irradiance);
    double largest = 0, sum = 0;
    for (std::size_t i = 0; i < first.irradiance.size(); ++i) {
        largest =
            std::max(largest, static_cast<double>(std::abs(first.irradiance[i].y - device.irradiance[i].y)));
        sum += static_cast<double>(first.irradiance[i].y);
    }
    EXPECT_LE(largest,
              1e-5 * sum / static_cast<double>(first.irradiance.size()) * 10);  // sums in other order
}

TEST(CoverageLattice, IsNotUsedWithoutADisc) {
    const scene::FrameScene scene = test::pool_scene(160, 90, 100, 0);
    test::CoverageFrame frame(test::validated_device(), scene);
    methods::SlicedBeams method(CoverageBackend::cpu);
    FrameStats stats;
    frame.irradiance(method, stats);
    EXPECT_EQ(stats.counted("lattice nodes"), 0);
}

/// Under a slanting sun the water above a receiver lies at any depth of the sheet's axis: the way is told by
/// the receiver's depth alone.
TEST(CoverageLattice, TheDiscsImageIsAsWideEverywhereAtOneDepth) {
    const scene::FrameScene scene = test::pool_scene(16, 9, 100, 0.53);
    const rays::RayScene rays(scene);
    const auto sheets = sheets_of(scene, rays, 1);
    const SheetCoverage<float>& sheet = *sheets.at(0);
    const auto image = [&](float x, float depth) {
        const Receiver<float> r = sheet.in_sheet(
            {{x, -depth - static_cast<float>(scene.origin.y), 0}, {1e-4f, 0, 0}, {0, 0, 1e-4f}, {0, 1, 0}});
        return std::sqrt(glm::length(glm::cross(r.u, r.v)));
    };
    EXPECT_NEAR(image(-2, 2) / image(2, 2), 1, 1e-3);
    EXPECT_NEAR(image(0, 2) / image(0, 1), 2, 1e-3);
    // sqrt 3 semi-axes wide, 0.53 deg / 2 over the index and a way of 2 m / cos: foreshortening and what
    // refraction does to the slant circle come to some tenths.
    EXPECT_NEAR(image(0, 2), std::sqrt(3.0) * 0.53 / 2 * scene::kDegree / 1.333 * 2, 0.3 * 0.012);
}

}  // namespace
}  // namespace dapple
