// Light paths to points under a sea of 24 waves: the certificate, counts against proven ones, the share of
// points near folds, and what a walk to a single path loses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "accuracy/scenes.h"
#include "base/parallel.h"
#include "closed_form/beam_sheets.h"
#include "methods/reference/oracle.h"
#include "methods/sliced_beams/point_query.h"

namespace dapple {
namespace {

using methods::sliced_beams::BeamNeighbors;
using methods::sliced_beams::PointQuery;
using methods::sliced_beams::PointSummary;
using methods::sliced_beams::Receiver;
using methods::sliced_beams::SheetCoverage;

constexpr double kElevation = 50;

/// DAPPLE_LONG: the same figures from more points, in minutes.
constexpr std::size_t kCertifiedPoints = DAPPLE_LONG ? 1000000 : 20000;
constexpr std::size_t kOraclePoints = DAPPLE_LONG ? 10000 : 1000;
constexpr std::size_t kFoldPoints = DAPPLE_LONG ? 100000 : 10000;

scene::FrameState sea_a_under_the_sun(double size, double cells_per_shortest_wave) {
    scene::FrameState state;
    state.water = test::sea_a(size, cells_per_shortest_wave);
    state.lights = {test::point_like_sun(kElevation)};
    return state;
}

/// The sheet of the refracted sun and its point queries.
template <class Real>
class PointSheet {
public:
    PointSheet(const scene::FrameState& state, double deepest, std::size_t remove_every = 0)
        : scene_(test::scene_of(state)),
          rays_(scene_),
          neighbors_(scene_.water->rows, scene_.water->columns, scene_.water->mesh.triangles) {
        FrameStats stats;
        auto sheets = light::water_beams<Real>(scene_, rays_, {0, light::Event::transmission}, 1, stats);
        EXPECT_EQ(sheets.size(), 1u);
        if (remove_every > 0)
            for (std::size_t i = 0; i < sheets[0].flux.size(); i += remove_every) sheets[0].flux[i] = 0;
        sheet_ = std::make_unique<SheetCoverage<Real>>(scene_, rays_, std::move(sheets[0]),
                                                       static_cast<Real>(deepest));
        query_ = std::make_unique<PointQuery<Real>>(*sheet_, neighbors_);
    }
    /// In groups of up to `together` that follow one another.
    std::vector<PointSummary> summarize(const std::vector<Receiver<Real>>& points,
                                        std::size_t together) const {
        std::vector<PointSummary> summaries(points.size());
        parallel_for(points.size(), together, [&](std::size_t begin, std::size_t end) {
            query_->summarize(std::span(points).subspan(begin, end - begin),
                              std::span(summaries).subspan(begin, end - begin));
        });
        return summaries;
    }
    const SheetCoverage<Real>& sheet() const { return *sheet_; }

private:
    scene::FrameScene scene_;
    rays::RayScene rays_;
    BeamNeighbors neighbors_;
    std::unique_ptr<SheetCoverage<Real>> sheet_;
    std::unique_ptr<PointQuery<Real>> query_;
};

using Random = std::mt19937_64;
double between(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}

template <class Real>
Receiver<Real> level_point(const glm::dvec3& at) {
    using Vec = glm::vec<3, Real>;
    return {Vec(at), Vec(Real(0.01), 0, 0), Vec(0, 0, Real(0.01)), Vec(0, 1, 0)};
}

/// Where the sun's ray through flat water at (x, z) is at that depth.
glm::dvec3 below(double x, double depth, double z) {
    return {x + depth * test::shift_of_sun(kElevation), -depth, z};
}

// ---- the certificate --------------------------------------------------------------------------------------

/// The beams make one sheet that wraps round any point far from its edge once, whatever its folds: the signs
/// of the beams that hold the point sum to 1. Groups of 50 points within 10 cm at depths of 0.5 to 20 m, half
/// of the groups on planes that lean by up to 30 degrees. Points whose sum is not 1.
template <class Real>
std::size_t count_uncertified(const PointSheet<Real>& sheet, std::size_t count, std::uint64_t seed,
                              const char* name) {
    Random random(seed);
    constexpr std::size_t kTogether = 50;
    std::vector<Receiver<Real>> points;
    while (points.size() < count) {
        const double depth = between(random, 0.5, 20), x = between(random, -1, 1), z = between(random, -1, 1);
        glm::dvec3 normal(0, 1, 0);
        if (points.size() / kTogether % 2 == 1) {
            const double lean = std::tan(between(random, 0, 30 * scene::kDegree));
            const double heading = between(random, 0, 2 * std::numbers::pi);
            normal = glm::normalize(glm::dvec3(lean * std::cos(heading), 1, lean * std::sin(heading)));
        }
        for (std::size_t i = 0; i < kTogether; ++i) {
            const double near_x = x + between(random, -0.05, 0.05), near_z = z + between(random, -0.05, 0.05);
            points.push_back(test::receiver<Real>(below(near_x, depth + between(random, -0.05, 0.05), near_z),
                                                  normal, {0.01, 0.01}));
        }
    }
    std::size_t wrong = 0, most = 0, paths = 0;
    for (const PointSummary& summary : sheet.summarize(points, kTogether)) {
        wrong += summary.sign != 1;
        paths += static_cast<std::size_t>(summary.count);
        most = std::max(most, static_cast<std::size_t>(summary.count));
    }
    printf("%s: %zu points, %.2f paths a point, %zu at most; sum of signs other than 1 at %zu\n", name,
           points.size(), static_cast<double>(paths) / static_cast<double>(points.size()), most, wrong);
    // Caustics overlap down there: without paths that turn over nothing would be certified.
    EXPECT_GT(most, 10u);
    return wrong;
}

// 4 m of water from the points' middle to the edge on all sides: more than rays of this sea stray in 20 m,
// by 0.35 m in the mean and 2.5 m at its sum of slopes.
constexpr double kSizeOfCertified = 10, kCellsOfCertified = 12;

TEST(Certificate, HoldsInFloat) {
    const PointSheet<float> sheet(sea_a_under_the_sun(kSizeOfCertified, kCellsOfCertified), 45);
    EXPECT_EQ(count_uncertified(sheet, kCertifiedPoints, 1, "float"), 0u);
}
TEST(Certificate, HoldsInDouble) {
    const PointSheet<double> sheet(sea_a_under_the_sun(kSizeOfCertified, kCellsOfCertified), 45);
    EXPECT_EQ(count_uncertified(sheet, kCertifiedPoints, 2, "double"), 0u);
}
TEST(Certificate, MissesWhatIsNotThere) {
    // One beam in a thousand left out: a point is covered by one to some score of paths.
    const PointSheet<float> sheet(sea_a_under_the_sun(kSizeOfCertified, kCellsOfCertified), 45, 1009);
    const std::size_t wrong = count_uncertified(sheet, 20000, 3, "float, a beam of 1009 missing");
    EXPECT_GT(wrong, 20u);
    EXPECT_LT(wrong, 20000u * 40 / 1009);
}

// ---- counts against the oracle ----------------------------------------------------------------------------

TEST(PathCount, IsTheOraclesAwayFromFolds) {
    const scene::FrameState state = sea_a_under_the_sun(7.5, 25);
    const PointSheet<double> sheet(state, 20);
    const oracle::Oracle oracle(*state.water, state.lights[0], state.time);
    constexpr std::size_t count = kOraclePoints;
    Random random(4);
    std::vector<glm::dvec3> places;
    std::vector<Receiver<double>> points;
    for (std::size_t i = 0; i < count; ++i) {
        places.push_back(below(between(random, -1, 1), between(random, 0.5, 8), between(random, -1, 1)));
        points.push_back(level_point<double>(places.back()));
    }
    const std::vector<PointSummary> found = sheet.summarize(points, 1);
    std::vector<oracle::Result> proven(count);
    parallel_for(count, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) proven[i] = oracle.paths(places[i], {0, 1, 0});
    });
    std::size_t flagged = 0, differ_flagged = 0, differ = 0, unproven = 0, paths = 0, most = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (!proven[i].proven) {
            ++unproven;
            EXPECT_TRUE(found[i].fold) << "on a fold";
            continue;
        }
        EXPECT_EQ(proven[i].sign(), 1);
        const std::size_t exact = proven[i].paths.size();
        paths += exact;
        most = std::max(most, exact);
        flagged += found[i].fold;
        if (static_cast<std::size_t>(found[i].count) == exact) continue;
        if (found[i].fold) {
            ++differ_flagged;
            continue;
        }
        ++differ;
        printf("at (%.6f, %.6f, %.6f): %d paths on the mesh, %zu proven\n", places[i].x, places[i].y,
               places[i].z, found[i].count, exact);
    }
    printf(
        "%zu points: %.2f paths a point, %zu at most; %zu flagged (%.2f %%), of which %zu differ; %zu "
        "differ outside the flag; %zu left undecided by the oracle\n",
        count, static_cast<double>(paths) / count, most, flagged,
        100.0 * static_cast<double>(flagged) / count, differ_flagged, differ, unproven);
    EXPECT_EQ(differ, 0u);
    // Both lists are of many paths, and the flag is not vacuous.
    EXPECT_GT(most, 10u);
    EXPECT_GT(flagged, 0u);
}

/// Share of points of a square metre of that depth that are flagged.
double flagged_share(const PointSheet<double>& sheet, double depth, double half, std::size_t count) {
    Random random(5);
    std::vector<Receiver<double>> points;
    // Groups of 20 near each other.
    while (points.size() < count) {
        const double x = between(random, -half, half), z = between(random, -half, half);
        for (int i = 0; i < 20; ++i)
            points.push_back(level_point<double>(
                below(x + between(random, -0.02, 0.02), depth, z + between(random, -0.02, 0.02))));
    }
    std::size_t flagged = 0;
    for (const PointSummary& summary : sheet.summarize(points, 20)) flagged += summary.fold;
    return static_cast<double>(flagged) / static_cast<double>(points.size());
}

TEST(FoldFlag, SharesByDepth) {
    const PointSheet<double> sheet(sea_a_under_the_sun(6, 25), 20);
    for (const double depth : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0}) {
        const double share = flagged_share(sheet, depth, 1, kFoldPoints);
        printf("%.1f m deep, 25 cells per shortest wave: %.3f %% flagged\n", depth, 100 * share);
        if (depth == 4) {
            EXPECT_LE(share, 0.02);
            EXPECT_GT(share, 0.0001);
        }
    }
}

TEST(FoldFlag, FallsWithTheSquareOfTheCell) {
    // Least squares of log(share) over log(cells).
    double sum = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
    for (const double cells : {12.0, 25.0, 50.0, 100.0}) {
        if (!DAPPLE_LONG && cells > 50) continue;  // 3.5 M beams
        const PointSheet<double> sheet(sea_a_under_the_sun(2.4, cells), 8);
        const double share = flagged_share(sheet, 4, 0.5, kFoldPoints);
        printf("4 m deep, %3.0f cells per shortest wave: %.4f %% flagged\n", cells, 100 * share);
        ASSERT_GT(share, 0);
        const double x = std::log(cells), y = std::log(share);
        sum += 1;
        sum_x += x;
        sum_y += y;
        sum_xx += x * x;
        sum_xy += x * y;
    }
    const double exponent = -(sum * sum_xy - sum_x * sum_y) / (sum * sum_xx - sum_x * sum_x);
    printf("falls with the power %.2f of the cell\n", exponent);
    EXPECT_NEAR(exponent, 2, 0.3);
}

// ---- a walk to one path -----------------------------------------------------------------------------------

struct Walk {
    bool found = false;
    double irradiance = 0;  ///< W/m^2
};
/// A generic manifold walk: Newton's method from where the straight line from point to sun leaves the water,
/// each step halved until it comes nearer; at most 64 steps, to a micrometre. Its light is flux / |det J|, at
/// most 200 times the flux, as renderers clamp it.
Walk walk_to_one_path(const oracle::Oracle& oracle, const glm::dvec3& point, const glm::dvec3& sun) {
    const glm::dvec2 target(point.x, point.z);
    glm::dvec2 at = target + glm::dvec2(sun.x, sun.z) / sun.y * -point.y;
    oracle::LandingPoint landed = oracle.land(at, point.y);
    for (int step = 0; step < 64; ++step) {
        const glm::dvec2 miss = target - landed.position;
        if (glm::length(miss) < 1e-6) {
            const double stretch = std::abs(glm::determinant(landed.jacobian));
            return {true, landed.flux * std::min(200.0, 1 / stretch)};
        }
        const glm::dvec2 newton = glm::inverse(landed.jacobian) * miss;
        double share = 1;
        for (; share > 1e-4; share *= 0.5) {
            const oracle::LandingPoint tried = oracle.land(at + share * newton, point.y);
            if (tried.lands && glm::length(target - tried.position) < glm::length(miss)) {
                at += share * newton;
                landed = tried;
                break;
            }
        }
        if (share <= 1e-4) return {};
    }
    return {};
}

TEST(OnePathOnly, LosesLightWithDepth) {
    const scene::FrameState state = sea_a_under_the_sun(6, 25);
    const PointSheet<double> sheet(state, 20);
    const oracle::Oracle oracle(*state.water, state.lights[0], state.time);
    constexpr int side = 80, count = side * side;
    constexpr double half = 1;  // m, of the floor that is looked at
    std::vector<double> lost;
    for (const double depth : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0}) {
        // The light on this floor by the analytic map: from 2 mm cells of water, each at its middle. The
        // floor's edge cuts 2000 of these, which leaves some 5e-5 of noise.
        constexpr int cells = 1000;
        std::vector<double> rows(cells, 0);
        const glm::dvec3 middle = below(0, depth, 0);
        parallel_for(cells, 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row)
                for (int column = 0; column < cells; ++column) {
                    const oracle::LandingPoint p =
                        oracle.land({4.0 / cells * (column + 0.5) - 2,
                                     4.0 / cells * (static_cast<double>(row) + 0.5) - 2},
                                    -depth);
                    if (std::abs(p.position.x - middle.x) < half && std::abs(p.position.y - middle.z) < half)
                        rows[row] += p.flux * (4.0 / cells) * (4.0 / cells);
                }
        });
        double truth = 0;
        for (const double row : rows) truth += row / (4 * half * half);
        // Ours: the mean over one footprint of that size, and over pixels of 2.5 cm.
        glm::dvec3 whole(0);
        methods::sliced_beams::QueryCounts counts;
        std::vector<double> walked(count);
        std::vector<std::uint8_t> found(count);
        Random random(6);
        std::vector<glm::dvec3> places;
        std::vector<Receiver<double>> pixels;
        for (int i = 0; i < count; ++i) {
            const int row = i / side, column = i % side;
            const double x = half * ((2.0 * column + 1) / side - 1);
            const double z = half * ((2.0 * row + 1) / side - 1);
            pixels.push_back(
                test::receiver<double>(below(x, depth, z), {0, 1, 0}, glm::dvec2(2 * half / side)));
            const double stray = half / side;
            places.push_back(
                below(x + between(random, -stray, stray), depth, z + between(random, -stray, stray)));
        }
        for (std::size_t first = 0; first < count; first += side) {
            for (std::size_t part = first; part < first + side; part += 40) {
                std::vector<glm::dvec3> e(40, glm::dvec3(0));
                sheet.sheet().add(std::span(pixels).subspan(part, 40), 0, e, counts);
                for (const glm::dvec3& value : e) whole += value / static_cast<double>(count);
            }
        }
        parallel_for(count, 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Walk walk = walk_to_one_path(oracle, places[i], state.lights[0].direction);
                walked[i] = walk.irradiance;
                found[i] = walk.found;
            }
        });
        double mean = 0, roots = 0;
        for (std::size_t i = 0; i < count; ++i) {
            mean += walked[i] / count;
            roots += found[i];
        }
        lost.push_back(1 - mean / truth);
        printf(
            "%.1f m deep: one path only: %5.1f %% of the light lost, no path found at %4.1f %% of the "
            "points; "
            "all paths: %+.1e lost\n",
            depth, 100 * lost.back(), 100 * (1 - roots / count), 1 - whole.x / truth);
        // Floor light of a mesh of 25 cells a wave, at the floor's edges and in the mean transmittance.
        EXPECT_NEAR(whole.x / truth, 1, 1e-3) << depth;
    }
    // Above the first folds there is one path and little to lose; then it is lost faster and faster.
    EXPECT_LT(lost[0], 0.01);
    EXPECT_GT(lost[3], 0.2);
    EXPECT_GT(lost[6], 0.6);
    EXPECT_TRUE(std::ranges::is_sorted(lost.begin() + 1, lost.end()));
}

}  // namespace
}  // namespace dapple
