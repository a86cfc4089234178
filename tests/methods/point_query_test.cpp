// Neighbours of triangles, and the signs of light paths to points.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "closed_form/gentle_sea.h"
#include "methods/sliced_beams/point_paths.h"
#include "methods/sliced_beams/point_query.h"
#include "ocean/water_surface.h"

namespace dapple {
namespace {

using light::Event;
using methods::sliced_beams::BeamNeighbors;
using methods::sliced_beams::kNoBeam;
using methods::sliced_beams::kNoVertex;
using methods::sliced_beams::Neighbor;
using methods::sliced_beams::PointHit;
using methods::sliced_beams::PointQuery;
using methods::sliced_beams::PointSummary;
using methods::sliced_beams::Receiver;

/// Waters as the program makes them, so that triangles are those of its grids.
scene::FrameScene scene_of(glm::dvec2 size, int cells_x, const scene::Waves& waves) {
    scene::FrameScene scene;
    scene::Water& water = scene.state.water.emplace();
    water.extent.size = size;
    water.absorption = {0, 0, 0};
    water.surface.waves = waves;
    water.mesh_cells = cells_x;
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    return scene;
}

// ---- neighbours -------------------------------------------------------------------------------------------

TEST(BeamNeighbors, OfAGridAreThoseOfItsTrianglesAsAMesh) {
    for (const auto& [rows, columns] :
         {std::pair(2, 2), {2, 3}, {3, 2}, {2, 17}, {17, 2}, {3, 3}, {6, 9}, {12, 5}}) {
        const glm::dvec2 size(columns - 1, rows - 1);
        const scene::FrameScene scene = scene_of(size, columns - 1, {});
        ASSERT_EQ(scene.water->rows, rows);
        ASSERT_EQ(scene.water->columns, columns);
        const std::vector<glm::uvec3>& triangles = scene.water->mesh.triangles;
        const BeamNeighbors grid(rows, columns, triangles), mesh(0, 0, triangles);
        int borders = 0;
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            for (int edge = 0; edge < 3; ++edge) {
                const Neighbor by_grid = grid.across(t, edge), by_table = mesh.across(t, edge);
                ASSERT_EQ(by_grid.triangle, by_table.triangle) << rows << 'x' << columns << ' ' << t;
                ASSERT_EQ(by_grid.vertex, by_table.vertex) << rows << 'x' << columns << ' ' << t;
                borders += by_grid.triangle == kNoBeam;
            }
        }
        EXPECT_EQ(borders, 2 * (rows - 1 + columns - 1));
    }
}

TEST(BeamNeighbors, OfAMeshShareTheEdgeAndHaveOneOtherCorner) {
    scene::FrameScene scene = scene_of({9, 6}, 9, {});
    std::vector<glm::uvec3> triangles = scene.water->mesh.triangles;
    std::shuffle(triangles.begin(), triangles.end(), std::mt19937(3));
    for (std::size_t i = 0; i < triangles.size(); ++i) {  // any corner first
        const glm::uvec3 t = triangles[i];
        if (i % 3 == 1) triangles[i] = {t.y, t.z, t.x};
        if (i % 3 == 2) triangles[i] = {t.z, t.x, t.y};
    }
    const BeamNeighbors neighbors(0, 0, triangles);
    int borders = 0;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        for (int edge = 0; edge < 3; ++edge) {
            const Neighbor n = neighbors.across(t, edge);
            if (n.triangle == kNoBeam) {
                EXPECT_EQ(n.vertex, kNoVertex);
                ++borders;
                continue;
            }
            const std::uint32_t from = triangles[t][edge], to = triangles[t][(edge + 1) % 3];
            const glm::uvec3 other = triangles[n.triangle];
            int shared = 0;  // seen over the edge it runs the other way
            for (int k = 0; k < 3; ++k)
                shared += other[k] == to && other[(k + 1) % 3] == from && other[(k + 2) % 3] == n.vertex;
            ASSERT_EQ(shared, 1);
        }
    }
    EXPECT_EQ(borders, 2 * (9 + 6));
}

// ---- signs ------------------------------------------------------------------------------------------------

/// The point queries of all sheets of the first light's chain.
template <class Real>
class Points {
public:
    Points(const scene::FrameScene& scene, Event event, double deepest)
        : sheets_(scene, event, deepest),
          neighbors_(scene.water->rows, scene.water->columns, scene.water->mesh.triangles) {
        for (const auto& sheet : sheets_.sheets())
            queries_.push_back(std::make_unique<PointQuery<Real>>(*sheet, neighbors_));
    }
    std::vector<PointSummary> summarize(const std::vector<Receiver<Real>>& points,
                                        std::size_t together = 64) const {
        std::vector<PointSummary> summaries(points.size());
        for (std::size_t first = 0; first < points.size(); first += together) {
            const std::size_t count = std::min(together, points.size() - first);
            for (const auto& query : queries_)
                query->summarize(std::span(points).subspan(first, count),
                                 std::span(summaries).subspan(first, count));
        }
        return summaries;
    }
    const std::vector<std::unique_ptr<PointQuery<Real>>>& queries() const { return queries_; }
    const test::SheetSet<Real>& sheets() const { return sheets_; }

private:
    test::SheetSet<Real> sheets_;
    BeamNeighbors neighbors_;
    std::vector<std::unique_ptr<PointQuery<Real>>> queries_;
};

template <class Real>
Receiver<Real> turned_over(Receiver<Real> r) {
    r.v = -r.v;
    return r;
}

template <class Real>
class PointSigns : public testing::Test {
protected:
    static constexpr int kPoints = 120;
    /// Points within 1 m of `centre` on planes about `normal`, half of them with footprints that run the
    /// other way round: the signs at each sum to 1, though an eighth and more have more than one path.
    static void expect_one(const scene::FrameScene& scene, Event event, bool in_water, glm::dvec3 centre,
                           glm::dvec3 normal) {
        const Points<Real> points(scene, event, 30);
        ASSERT_FALSE(points.queries().empty());
        for (const auto& sheet : points.sheets().sheets()) ASSERT_EQ(sheet->sheet().in_water(), in_water);
        std::mt19937 random(11);
        std::uniform_real_distribution<double> uniform(-1, 1);
        std::vector<Receiver<Real>> receivers;
        int ways_round[2] = {0, 0};
        for (int i = 0; i < kPoints; ++i) {
            const glm::dvec3 leaning =
                glm::normalize(normal + 0.2 * glm::dvec3(uniform(random), 0, uniform(random)));
            const glm::dvec3 at =
                centre + glm::dvec3(uniform(random), 0.1 * uniform(random), uniform(random));
            auto r = test::receiver<Real>(at, leaning, {0.01, 0.02});
            if (i % 2) r = turned_over(r);
            ++ways_round[glm::dot(glm::cross(r.u, r.v), r.normal) < 0 ? 1 : 0];
            receivers.push_back(r);
        }
        ASSERT_EQ(ways_round[0], kPoints / 2);
        ASSERT_EQ(ways_round[1], kPoints / 2);
        int wrong = 0, more = 0, flagged = 0;
        for (const PointSummary& summary : points.summarize(receivers)) {
            wrong += summary.sign != 1;
            more += summary.count > 1;
            flagged += summary.fold;
            EXPECT_EQ(summary.count % 2, 1);
        }
        printf("%zu sheets: %d of %d points do not sum to 1, %d have more paths than 1, %d near a fold\n",
               points.queries().size(), wrong, kPoints, more, flagged);
        EXPECT_EQ(wrong, 0);
        EXPECT_GE(more, kPoints / 8);
    }
    /// Three times as high as the gentle sea: it focuses light at some metres.
    static scene::FrameScene sea() {
        scene::Waves waves = test::gentle_waves();
        for (scene::Wave& wave : waves.waves) wave.amplitude *= 3;
        return scene_of({8, 8}, 120, waves);
    }
    static scene::FrameScene sea_under_the_sun() {
        scene::FrameScene scene = sea();
        scene.state.lights = {test::sun_from_zenith(30)};
        return scene;
    }
    static scene::FrameScene sea_over_a_lamp(double depth) {
        scene::FrameScene scene = sea();
        scene.state.lights = {test::sun_from_zenith(0)};
        scene.state.lights[0].type = scene::LightType::point;
        scene.state.lights[0].position = {0.1, -depth, 0.2};
        return scene;
    }
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(PointSigns, Reals);

TYPED_TEST(PointSigns, OfTheRefractedSunOnAFloorSumToOne) {
    this->expect_one(this->sea_under_the_sun(), Event::transmission, true, {2, -5, 0}, {0, 1, 0});
}
TYPED_TEST(PointSigns, OfTheMirroredSunOnACeilingSumToOne) {
    this->expect_one(this->sea_under_the_sun(), Event::reflection, false, {0.9, 1.5, 0}, {0, -1, 0});
}
TYPED_TEST(PointSigns, OfALampUnderWaterOnACeilingSumToOne) {
    // From a small depth the light spreads faster than these waves gather it.
    this->expect_one(this->sea_over_a_lamp(12), Event::transmission, false, {0, 20, 0}, {0, -1, 0});
}
TYPED_TEST(PointSigns, OfALampUnderWaterMirroredOntoTheFloorSumToOne) {
    this->expect_one(this->sea_over_a_lamp(3), Event::reflection, true, {0, -4, 0}, {0, 1, 0});
}
TYPED_TEST(PointSigns, OfALampUnderWaterTotallyReflectedSumToOne) {
    // 4.5 m beside the lamp's image, which is 3 m above the floor: incidence of 56 degrees.
    this->expect_one(this->sea_over_a_lamp(1), Event::reflection, true, {4.6, -2, 0}, {0, 1, 0});
}

// ---- beyond the focus -------------------------------------------------------------------------------------

constexpr double kIndex = 1.333;
constexpr double kWave = 2 * glm::pi<double>();  // rad/m
constexpr double kSlope = 0.01;                  // paraxial laws hold to its square

/// h = a cos(kx) under an overhead sun.
scene::FrameScene sinusoid() {
    scene::Waves waves;
    waves.waves.resize(1);
    waves.waves[0].length = 1;
    waves.waves[0].amplitude = kSlope / kWave;
    scene::FrameScene scene = scene_of({5, 0.1}, 1500, waves);
    scene.state.lights = {test::sun_from_zenith(0)};
    return scene;
}

/// x - kappa / k sin(kx) on a floor, with focus under crests; reflected light lands at x + kappa / k sin(kx)
/// on a ceiling, with focus above troughs.
template <class Real>
void expect_folds(Event event) {
    const bool floor = event == Event::transmission;
    const double bend = floor ? (kIndex - 1) / kIndex : 2.0;  // of a ray over the slope of the water
    const double focus = 1 / (bend * kSlope * kWave);
    const scene::FrameScene scene = sinusoid();
    const Points<Real> points(scene, event, 3 * focus);
    const double middle = floor ? 0 : 0.5;  // m, where the light gathers
    const auto at = [&](double x, double kappa) {
        return test::receiver<Real>({middle + x, (floor ? -kappa : kappa) * focus, 0.003},
                                    {0, floor ? 1.0 : -1.0, 0}, {0.01, 0.01});
    };
    for (const double kappa : {0.5, 0.9, 1.5, 2.0}) {
        const double fold = kappa < 1 ? 0 : (std::sqrt(kappa * kappa - 1) - std::acos(1 / kappa)) / kWave;
        std::vector<Receiver<Real>> receivers;
        std::vector<int> counts;
        for (int i = -100; i <= 100; ++i) {
            const double x = 0.0049 * i;
            // The law is exact to kSlope^2, the mesh to (cell / wave)^2 of the focus's length: below 1e-3 m.
            const double to_fold = std::abs(std::abs(x) < 0.5 ? std::abs(x) : 0) - fold;
            if (std::abs(to_fold) < 1e-3) continue;
            receivers.push_back(at(x, kappa));
            // The folds of the next waves are one wave on.
            counts.push_back(std::abs(x) < fold ? 3 : 1);
        }
        const std::vector<PointSummary> summaries = points.summarize(receivers);
        int three = 0;
        for (std::size_t i = 0; i < summaries.size(); ++i) {
            EXPECT_EQ(summaries[i].count, counts[i]) << kappa << ' ' << receivers[i].position.x;
            EXPECT_EQ(summaries[i].sign, 1) << kappa << ' ' << receivers[i].position.x;
            three += summaries[i].count == 3;
        }
        EXPECT_EQ(three > 0, kappa > 1);
    }
    // At two focus lengths, below the middle: the middle has turned over, u = 2 sin(u) to both sides has not.
    bool fold = false;
    ASSERT_EQ(points.queries().size(), 1u);
    const std::vector<PointHit<Real>> hits = points.queries()[0]->hits(at(0, 2), fold);
    ASSERT_EQ(hits.size(), 3u);
    EXPECT_FALSE(fold);
    int turned = 0;
    for (const PointHit<Real>& hit : hits) {
        double x = -middle;
        for (int k = 0; k < 3; ++k)
            x += static_cast<double>(hit.weights[k]) *
                 scene.water->mesh.positions[scene.water->mesh.triangles[hit.beam][k]].x;
        const bool central = std::abs(x) < 0.1;
        EXPECT_NEAR(std::abs(kWave * x), central ? 0 : 1.89549, 2e-3);
        EXPECT_EQ(hit.sign, central ? -1 : 1);
        turned += hit.sign < 0;
    }
    EXPECT_EQ(turned, 1);
}

TYPED_TEST(PointSigns, OfOneWaveAreThreeWithinItsFoldsOnAFloor) {
    expect_folds<TypeParam>(Event::transmission);
}
TYPED_TEST(PointSigns, OfOneWaveAreThreeWithinItsFoldsOnACeiling) {
    expect_folds<TypeParam>(Event::reflection);
}

TEST(PointPaths, OfOneWaveHaveItsJacobian) {
    // det J = 1 - kappa cos(kx) at the middle of the facet, 0.01 rad from the path at most.
    const double focus = 1 / ((kIndex - 1) / kIndex * kSlope * kWave), kappa = 2;
    const scene::FrameScene scene = sinusoid();
    const rays::RayScene rays(scene);
    const light::Chain chain{0, Event::transmission};
    const auto found = methods::sliced_beams::find_point_paths(
        scene, rays, {&chain, 1}, {0.02, -kappa * focus, 0.003}, {0, 1, 0}, true);
    EXPECT_EQ(found.count, 3);
    EXPECT_EQ(found.sign_sum, 1);
    ASSERT_EQ(found.paths.size(), 3u);
    for (const auto& path : found.paths) {
        EXPECT_NEAR(path.jacobian, 1 - kappa * std::cos(kWave * path.water_point.x), 0.025);
        EXPECT_EQ(path.sign, path.jacobian > 0 ? 1 : -1);
        EXPECT_NEAR(path.way, kappa * focus, kSlope * kappa * focus);
    }
}

}  // namespace
}  // namespace dapple
