// Bounds and sums of the pyramid over landing points.
#include <gtest/gtest.h>

#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "light/water_grids.h"
#include "methods/sliced_beams/beam_pyramid.h"
#include "methods/sliced_beams/polygon.h"

namespace dapple {
namespace {

using light::BeamSheet;
using methods::sliced_beams::BeamPyramid;
using methods::sliced_beams::Box;
using methods::sliced_beams::kNoBeam;

/// Rays that swarm to all sides from a grid or from loose triangles; some beams carry nothing.
template <class Real>
struct Swarm {
    BeamSheet<Real> sheet;
    std::vector<glm::uvec3> triangles;

    Swarm(int rows, int columns, bool indexed, unsigned seed) {
        scene::FrameScene scene = test::water_scene({3, 2});
        test::add_water(scene, {}, columns - 1, rows - 1);
        triangles = scene.water->mesh.triangles;
        sheet.rows = indexed ? 0 : rows;
        sheet.columns = indexed ? 0 : columns;
        std::mt19937 random(seed);
        const auto uniform = [&](double low, double high) {
            return static_cast<Real>(std::uniform_real_distribution<double>(low, high)(random));
        };
        if (indexed) std::shuffle(triangles.begin(), triangles.end(), random);
        for (const glm::dvec3 position : scene.water->mesh.positions) {
            sheet.rays.push_back({static_cast<Real>(position.x), static_cast<Real>(position.z),
                                  uniform(-0.8, 0.8), uniform(-0.8, 0.8)});
            sheet.start.push_back(uniform(-0.1, 0.1));
            sheet.valid.push_back(1);
        }
        for (std::size_t i = 0; i < triangles.size(); ++i)
            sheet.flux.push_back(i % 7 == 3 ? Real(0) : uniform(0, 1));
    }
};

template <class Real>
class Pyramid : public testing::Test {
protected:
    using Node = typename BeamPyramid<Real>::NodeId;

    /// Calls `visit(node)` for a node and all below it.
    template <class Visit>
    static void visit_all(const BeamPyramid<Real>& pyramid, Node node, Visit&& visit) {
        visit(node);
        if (node.level > 0)
            pyramid.visit_children(node, [&](Node child) { visit_all(pyramid, child, visit); });
    }
    static std::vector<std::uint32_t> beams_below(const BeamPyramid<Real>& pyramid, Node node) {
        std::vector<std::uint32_t> beams;
        visit_all(pyramid, node, [&](Node n) {
            if (n.level > 0) return;
            for (const std::uint32_t beam : pyramid.beams(n))
                if (beam != kNoBeam) beams.push_back(beam);
        });
        return beams;
    }
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Pyramid, Reals);

constexpr int kSizes[][2] = {{2, 2}, {2, 9}, {7, 6}, {33, 18}};

TYPED_TEST(Pyramid, EveryBeamIsInOneClusterOfEight) {
    for (const bool indexed : {false, true}) {
        for (const auto& [rows, columns] : kSizes) {
            const Swarm<TypeParam> swarm(rows, columns, indexed, 1);
            const BeamPyramid<TypeParam> pyramid(swarm.sheet, swarm.triangles, TypeParam(-0.1), TypeParam(8));
            auto beams = this->beams_below(pyramid, pyramid.root());
            std::sort(beams.begin(), beams.end());
            ASSERT_EQ(beams.size(), swarm.triangles.size());
            for (std::size_t i = 0; i < beams.size(); ++i) ASSERT_EQ(beams[i], i);
        }
    }
}

TYPED_TEST(Pyramid, BoxesHoldAllLandingPointsAtAllDepths) {
    for (const bool indexed : {false, true}) {
        for (const auto& [rows, columns] : kSizes) {
            const Swarm<TypeParam> swarm(rows, columns, indexed, 2);
            const BeamPyramid<TypeParam> pyramid(swarm.sheet, swarm.triangles, TypeParam(-0.1), TypeParam(8));
            for (const auto& [low, high] : {std::pair(-0.1, -0.1), {-0.1, 8.0}, {0.3, 0.31}, {5.0, 8.0}}) {
                this->visit_all(pyramid, pyramid.root(), [&, low = low, high = high](auto node) {
                    const Box<TypeParam> box = pyramid.box(node, TypeParam(low), TypeParam(high));
                    bool lit = false;
                    for (const std::uint32_t beam : this->beams_below(pyramid, node)) {
                        if (!(swarm.sheet.flux[beam] > 0)) continue;
                        lit = true;
                        for (int k = 0; k < 3; ++k) {
                            const auto& ray = swarm.sheet.rays[swarm.triangles[beam][k]];
                            for (const double t : {0.0, 0.3, 0.5, 0.9, 1.0}) {
                                const auto depth = TypeParam(TypeParam(low) + t * (high - low));
                                const TypeParam a = ray.a + depth * ray.slope_a;
                                const TypeParam b = ray.b + depth * ray.slope_b;
                                ASSERT_TRUE(a >= box.low_a && a <= box.high_a && b >= box.low_b &&
                                            b <= box.high_b);
                            }
                        }
                    }
                    ASSERT_EQ(lit, box.low_a <= box.high_a);
                    ASSERT_EQ(lit, !pyramid.dark(node));
                });
            }
        }
    }
}

TYPED_TEST(Pyramid, BoxesAreTightWhereTheyAreMeasured) {
    // A box that holds everything would pass the test above: at both measured depths it is the bounds of its
    // own beams, with a few roundings of room.
    const Swarm<TypeParam> swarm(33, 18, false, 3);
    const BeamPyramid<TypeParam> pyramid(swarm.sheet, swarm.triangles, TypeParam(0), TypeParam(8));
    const TypeParam room = 64 * std::numeric_limits<TypeParam>::epsilon() * 8;
    for (const TypeParam depth : {TypeParam(0), TypeParam(8)}) {
        this->visit_all(pyramid, pyramid.root(), [&](auto node) {
            TypeParam low = 1e9f, high = -1e9f;
            for (const std::uint32_t beam : this->beams_below(pyramid, node)) {
                if (!(swarm.sheet.flux[beam] > 0)) continue;
                for (int k = 0; k < 3; ++k) {
                    const auto& ray = swarm.sheet.rays[swarm.triangles[beam][k]];
                    low = std::min(low, ray.b + depth * ray.slope_b);
                    high = std::max(high, ray.b + depth * ray.slope_b);
                }
            }
            if (low > high) return;
            const Box<TypeParam> box = pyramid.box(node, depth, depth);
            ASSERT_NEAR(box.low_b, low, room);
            ASSERT_NEAR(box.high_b, high, room);
        });
    }
}

TYPED_TEST(Pyramid, BoxesHoldLandingPointsBeyondTheFarthestDepth) {
    // A footprint that leans may reach deeper than its point, by which the depths are chosen.
    const Swarm<TypeParam> swarm(33, 18, false, 6);
    const BeamPyramid<TypeParam> pyramid(swarm.sheet, swarm.triangles, TypeParam(-0.1), TypeParam(4));
    for (const auto& [low, high] : {std::pair(3.5, 4.5), {4.2, 6.0}, {-0.1, 5.0}}) {
        this->visit_all(pyramid, pyramid.root(), [&, low = low, high = high](auto node) {
            const Box<TypeParam> box = pyramid.box(node, TypeParam(low), TypeParam(high));
            for (const std::uint32_t beam : this->beams_below(pyramid, node)) {
                if (!(swarm.sheet.flux[beam] > 0)) continue;
                for (int k = 0; k < 3; ++k) {
                    const auto& ray = swarm.sheet.rays[swarm.triangles[beam][k]];
                    for (const double t : {0.0, 0.3, 0.5, 0.9, 1.0}) {
                        const auto depth = TypeParam(low + t * (high - low));
                        const TypeParam a = ray.a + depth * ray.slope_a, b = ray.b + depth * ray.slope_b;
                        ASSERT_TRUE(a >= box.low_a && a <= box.high_a && b >= box.low_b && b <= box.high_b);
                    }
                }
            }
        });
    }
}

TYPED_TEST(Pyramid, SumsAreThoseOfTheBeamsBelow) {
    for (const bool indexed : {false, true}) {
        const Swarm<TypeParam> swarm(33, 18, indexed, 4);
        const BeamPyramid<TypeParam> pyramid(swarm.sheet, swarm.triangles, TypeParam(0), TypeParam(8));
        this->visit_all(pyramid, pyramid.root(), [&](auto node) {
            double flux = 0, a = 0, b = 0, slope_a = 0, slope_b = 0, start = 0, stretch = 0;
            TypeParam first = std::numeric_limits<TypeParam>::infinity(), last = -first;
            for (const std::uint32_t beam : this->beams_below(pyramid, node)) {
                const double carried = static_cast<double>(swarm.sheet.flux[beam]);
                if (!(carried > 0)) continue;
                flux += carried;
                for (int k = 0; k < 3; ++k) {
                    const std::uint32_t vertex = swarm.triangles[beam][k];
                    const auto& ray = swarm.sheet.rays[vertex];
                    const glm::dvec2 slope(ray.slope_a, ray.slope_b);
                    a += carried * static_cast<double>(ray.a) / 3;
                    b += carried * static_cast<double>(ray.b) / 3;
                    slope_a += carried * slope.x / 3;
                    slope_b += carried * slope.y / 3;
                    start += carried * static_cast<double>(swarm.sheet.start[vertex]) / 3;
                    stretch += carried * std::sqrt(1 + glm::dot(slope, slope)) / 3;
                    first = std::min(first, swarm.sheet.start[vertex]);
                    last = std::max(last, swarm.sheet.start[vertex]);
                }
            }
            const auto& sums = pyramid.sums(node);
            // Additions in another order: an epsilon a level and beam of a cluster. Coordinates are below 4
            // m.
            const double tolerance = 32 * static_cast<double>(std::numeric_limits<TypeParam>::epsilon());
            ASSERT_NEAR(sums.flux, flux, tolerance * flux);
            ASSERT_NEAR(sums.flux_a, a, 4 * tolerance * flux);
            ASSERT_NEAR(sums.flux_b, b, 4 * tolerance * flux);
            ASSERT_NEAR(sums.flux_slope_a, slope_a, tolerance * flux);
            ASSERT_NEAR(sums.flux_slope_b, slope_b, tolerance * flux);
            ASSERT_NEAR(sums.flux_start, start, tolerance * flux);
            ASSERT_NEAR(sums.flux_stretch, stretch, tolerance * stretch);
            ASSERT_EQ(sums.first_start, first);
            ASSERT_EQ(sums.last_start, last);
        });
    }
}

TYPED_TEST(Pyramid, IndexedClustersLieTogether) {
    // Morton order: of 4 096 shuffled beams on 3 m x 2 m, a cluster of eight spans little.
    Swarm<TypeParam> swarm(65, 33, true, 5);
    for (auto& ray : swarm.sheet.rays) ray.slope_a = ray.slope_b = 0;
    const BeamPyramid<TypeParam> pyramid(swarm.sheet, swarm.triangles, TypeParam(0), TypeParam(1));
    double area = 0;
    int clusters = 0;
    this->visit_all(pyramid, pyramid.root(), [&](auto node) {
        if (node.level > 0 || pyramid.dark(node)) return;
        const auto box = pyramid.box(node, TypeParam(0), TypeParam(0));
        area += static_cast<double>((box.high_a - box.low_a) * (box.high_b - box.low_b));
        ++clusters;
    });
    EXPECT_EQ(clusters, 64 * 32 * 2 / 8);
    // Without overlap the boxes' mean would be 8 beams; some runs of the curve turn a corner.
    EXPECT_LT(area, 3 * 3.0 * 2.0);
}

TYPED_TEST(Pyramid, OfNothingIsEmpty) {
    const BeamSheet<TypeParam> sheet;
    EXPECT_TRUE((BeamPyramid<TypeParam>(sheet, {}, TypeParam(0), TypeParam(1)).empty()));
}

/// Beams through water of steep waves, and E of every receiver by all beams, landed and clipped one by one
/// without a pyramid.
template <class Real>
class LeaningPlanes : public testing::Test {
protected:
    using Receiver = methods::sliced_beams::Receiver<Real>;

    LeaningPlanes()
        : scene_(test::scene_of_water({2, 2}, 11, 11, [](double x, double z) {
              // Slopes to 0.4: light folds from 1 m on.
              const double k = 2 * glm::pi<double>() / 0.5, l = 2 * glm::pi<double>() / 1.3;
              return glm::dvec3(0.02 * std::cos(k * x) + 0.03 * std::sin(l * (z + 0.5 * x)),
                                -0.02 * k * std::sin(k * x) + 0.015 * l * std::cos(l * (z + 0.5 * x)),
                                0.03 * l * std::cos(l * (z + 0.5 * x)));
          })) {
        scene_.state.lights = {test::sun_from_zenith(40)};
    }

    double by_all_beams(const methods::sliced_beams::SheetCoverage<Real>& coverage,
                        const Receiver& receiver) const {
        using namespace methods::sliced_beams;
        const Receiver local = coverage.in_sheet(receiver);
        const LandingFrame<Real> frame(local);
        double power = 0;
        const auto beams = static_cast<std::uint32_t>(coverage.triangles().size());
        for (std::uint32_t first = 0; first < beams; first += kClusterBeams) {
            std::array<std::uint32_t, kClusterBeams> cluster;
            for (std::uint32_t i = 0; i < kClusterBeams; ++i)
                cluster[i] = first + i < beams ? first + i : kNoBeam;
            ClusterRays<Real> rays;
            load(coverage.sheet(), coverage.triangles(), cluster, rays);
            for (int c = 0; c < kChunks<Real>; ++c) {
                LandedChunk<Real> landed;
                land(rays, c, frame, landed);
                const auto share = covered_share<Real>(landed.beams);
                for (int lane = 0; lane < kLanes<Real>; ++lane) {
                    if (!landed.lands[lane]) continue;
                    Real x[3], y[3], past[3];
                    for (int k = 0; k < 3; ++k) {
                        x[k] = landed.beams.x[k][lane];
                        y[k] = landed.beams.y[k][lane];
                        past[k] = landed.past_start[k][lane];
                    }
                    const bool whole = past[0] >= 0 && past[1] >= 0 && past[2] >= 0;
                    const Real part = whole ? share[lane] : clip_beam(x, y, past).share;
                    power += static_cast<double>(part) * static_cast<double>(rays.flux[c][lane]);
                }
            }
        }
        const Real area = glm::length(glm::cross(receiver.u, receiver.v));
        return power * coverage.sheet().color.x / static_cast<double>(area);
    }

    scene::FrameScene scene_;
};
TYPED_TEST_SUITE(LeaningPlanes, Reals);

TYPED_TEST(LeaningPlanes, TilesFindAllBeamsThatLandOnThem) {
    // Straight edges between landed corners may leave the bounds of a beam's slices where a corner lands
    // beyond the depths that bounds are for, as along the sixth of these planes.
    const test::SheetSet<TypeParam> sheets(this->scene_, light::Event::transmission, 1.6);
    ASSERT_EQ(sheets.sheets().size(), 1u);
    const auto& coverage = *sheets.sheets()[0];
    constexpr int kReceivers = 600;
    const glm::dvec3 refracted = coverage.sheet().world_from_mesh[2];
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const glm::dvec3 turned : {glm::dvec3(0, 1, 0),
                                    {1, 1, 0},
                                    {-1, 1, 0},
                                    {0.3, 1, 1},
                                    {-1, 0, 0},
                                    {-0.2, 0, 1},
                                    {-1, -0.4, 0.3}}) {
        const glm::dvec3 normal = glm::normalize(turned);
        double worst = 0;
        int lit = 0;
        // Footprints far smaller than the beams of 18 cm, and larger.
        for (const double size : {0.001, 0.02, 0.4}) {
            for (int i = 0; i < kReceivers; ++i) {
                const glm::dvec3 at(0.55 + 0.3 * uniform(random), -0.9 + 0.5 * uniform(random),
                                    0.3 * uniform(random));
                const auto receiver = test::receiver<TypeParam>(at, normal, {size, 0.7 * size});
                const double expected = this->by_all_beams(coverage, receiver);
                const double found = sheets.irradiance(receiver).x;
                // Of E of flat water, 2.3 W/m^2.
                worst = std::max(worst, std::abs(found - expected) / std::max(1.0, expected));
                lit += expected > 0;
            }
        }
        printf("normal %4.1f %4.1f %4.1f: %d of %d lit, off by %.1e\n", turned.x, turned.y, turned.z, lit,
               3 * kReceivers, worst);
        EXPECT_GT(lit, kReceivers);
        // Along the walls some beams land a kilometre long, and corners are rounded by their distance; what a
        // tile does not find is missing whole.
        EXPECT_LT(worst, 1e3 * static_cast<double>(std::numeric_limits<TypeParam>::epsilon()) *
                             (glm::dot(normal, refracted) > -0.2 ? 1e3 : 1));
    }
}

}  // namespace
}  // namespace dapple
