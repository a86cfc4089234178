// One beam against one segment, and the quadrature of one over its area.
#include "methods/sliced_beams/beam_slices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "methods/sliced_beams/segment_quadrature.h"

namespace dapple {
namespace {

using namespace methods::sliced_beams;

struct Beam {
    BeamCorner<double> corner[3];
    glm::dvec2 at(int k, double depth) const {
        return {corner[k].a + depth * corner[k].slope_a, corner[k].b + depth * corner[k].slope_b};
    }
    /// Whether a point is in the beam's triangle at its depth.
    bool holds(glm::dvec3 p) const {
        int positive = 0, negative = 0;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec2 x = at((k + 1) % 3, p.z) - glm::dvec2(p),
                             y = at((k + 2) % 3, p.z) - glm::dvec2(p);
            (x.x * y.y - x.y * y.x > 0 ? positive : negative) += 1;
        }
        return positive == 3 || negative == 3;
    }
};

TEST(BeamSlices, HundredThousandRandomPairsAgreeWithFineMarching) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    constexpr int kPairs = 100000, kSteps = 4000;
    int met = 0, several = 0;
    double worst = 0;
    for (int pair = 0; pair < kPairs; pair += 4) {
        Beam beam;
        glm::dvec3 middle[4], half[4];
        // Slopes as large as the beam is wide against its depth, so that it turns over within reach.
        for (auto& c : beam.corner)
            c = {uniform(random), uniform(random), uniform(random), uniform(random), 0};
        SegmentParts<double> part;
        for (int lane = 0; lane < 4; ++lane) {
            middle[lane] = {uniform(random), uniform(random), uniform(random)};
            half[lane] = {uniform(random), uniform(random), uniform(random)};
            part.a[lane] = middle[lane].x;
            part.b[lane] = middle[lane].y;
            part.depth[lane] = middle[lane].z;
            part.half_a[lane] = half[lane].x;
            part.half_b[lane] = half[lane].y;
            part.half_depth[lane] = half[lane].z;
        }
        double length[4] = {};
        int pieces[4] = {};
        const auto slices = methods::sliced_beams::slices(beam.corner, part);
        visit_pieces(
            slices, Mask<double>{} == 0, [&](const auto& enter, const auto& leave, const auto& mask) {
                for (int lane = 0; lane < 4; ++lane) {
                    if (!mask[lane]) continue;
                    length[lane] += leave[lane] - enter[lane];
                    ++pieces[lane];
                    ASSERT_LT(enter[lane], leave[lane]);
                    // Twice the area has the edges' sign all along.
                    const double t = 0.5 * (enter[lane] + leave[lane]);
                    const auto value = [&](const Quadratic<double>& q) {
                        return q.c0[lane] + t * (q.c1[lane] + t * q.c2[lane]);
                    };
                    ASSERT_NEAR(value(slices.area),
                                value(slices.edge[0]) + value(slices.edge[1]) + value(slices.edge[2]), 1e-13);
                }
            });
        // Marching every pair would take a minute: an eighth of the pairs, chosen by their place alone.
        if (pair % 32 != 0) continue;
        for (int lane = 0; lane < 4; ++lane) {
            int inside = 0;
            for (int step = 0; step < kSteps; ++step)
                inside += beam.holds(middle[lane] + ((step + 0.5) * 2 / kSteps - 1) * half[lane]) ? 1 : 0;
            met += inside > 0;
            several += pieces[lane] > 1;
            // Each end is off by half a step at most; three pieces have six ends.
            worst = std::max(worst, std::abs(length[lane] - 2.0 * inside / kSteps) * kSteps / 2);
        }
    }
    printf("marching: %d met of %d, %d in several pieces, lengths differ by %.2f steps at most\n", met,
           kPairs / 8, several, worst);
    EXPECT_LT(worst, 3.01);
    EXPECT_GT(met, 1000);
    EXPECT_GT(several, 20);
}

TEST(BeamSlices, NeighboursShareTheirEdge) {
    // A fan about one vertex: along any segment through it the pieces join without gap or overlap, in float.
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(-1, 1);
    constexpr int kFan = 6;
    int met = 0;
    for (int round = 0; round < 2000; ++round) {
        BeamCorner<float> middle{0, 0, 0.02f * uniform(random), 0.02f * uniform(random), 0}, rim[kFan];
        for (int i = 0; i < kFan; ++i) {
            const float turn = 6.2831853f * static_cast<float>(i) / kFan;
            rim[i] = {std::cos(turn), std::sin(turn), 0.02f * uniform(random), 0.02f * uniform(random), 0};
        }
        SegmentParts<float> part{};
        for (int lane = 0; lane < 8; ++lane) {
            part.a[lane] = 0.2f * uniform(random);
            part.b[lane] = 0.2f * uniform(random);
            part.depth[lane] = uniform(random);
            part.half_a[lane] = 0.4f * uniform(random);
            part.half_b[lane] = 0.4f * uniform(random);
            part.half_depth[lane] = uniform(random);
        }
        std::vector<std::pair<float, float>> pieces[8];
        for (int i = 0; i < kFan; ++i) {
            const BeamCorner<float> corner[3] = {middle, rim[i], rim[(i + 1) % kFan]};
            visit_pieces(slices(corner, part), Mask<float>{} == 0,
                         [&](const auto& enter, const auto& leave, const auto& mask) {
                             for (int lane = 0; lane < 8; ++lane)
                                 if (mask[lane]) pieces[lane].emplace_back(enter[lane], leave[lane]);
                         });
        }
        for (auto& list : pieces) {
            std::sort(list.begin(), list.end());
            ASSERT_FALSE(list.empty());
            EXPECT_EQ(list.front().first, -1);
            EXPECT_EQ(list.back().second, 1);
            for (std::size_t i = 1; i < list.size(); ++i) {
                EXPECT_EQ(list[i].first, list[i - 1].second);
                ++met;
            }
        }
    }
    EXPECT_GT(met, 10000);
}

TEST(BeamSlices, KeepTheirDigitsWhereBeamsAreNarrow) {
    // Some micrometres wide, as about a focus, and crossed up to 14 mm from the segment's middle. Places are
    // multiples of 2^-29 m: exact in float, so that all that is off is off in the areas.
    constexpr float kGrid = 0x1p-29f;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto within = [&](float reach) { return kGrid * std::round(reach / kGrid * uniform(random)); };
    int pieces = 0, wrong = 0;
    for (int round = 0; round < 20000; ++round) {
        const BeamCorner<float> corner[3] = {{within(0x1p-17f), within(0x1p-17f), 0, 0, 0},
                                             {within(0x1p-17f), within(0x1p-17f), 0, 0, 0},
                                             {within(0x1p-17f), within(0x1p-17f), 0, 0, 0}};
        SegmentParts<float> part{};
        for (int lane = 0; lane < 8; ++lane) {
            part.half_a[lane] = 0x1p-6f + within(0x1p-10f);
            part.half_b[lane] = 0x1p-8f + within(0x1p-10f);
            const float at = 0.875f * uniform(random);
            part.a[lane] = -kGrid * std::round(at * part.half_a[lane] / kGrid);
            part.b[lane] = -kGrid * std::round(at * part.half_b[lane] / kGrid);
        }
        const BeamSlices<float> beam = slices(corner, part);
        visit_pieces(beam, Mask<float>{} == 0, [&](const auto& enter, const auto& leave, const auto& mask) {
            const Lanes<float> t = 0.5f * (enter + leave), area = beam.area(t);
            const Lanes<float> off = beam.edge[0](t) + beam.edge[1](t) + beam.edge[2](t) - area;
            pieces += __builtin_popcount(bits(mask));
            wrong += __builtin_popcount(bits(mask & (magnitude(off) > 0.01f * magnitude(area))));
        });
    }
    printf("narrow beams: %d pieces, of %d the edges' areas do not sum to the beam's\n", pieces, wrong);
    EXPECT_GT(pieces, 10000);
    // Of beams that are a hundred times as thin as long the last digits of t are as much.
    EXPECT_LE(wrong, pieces / 100);
}

/// Integral of g / |q| by bisection of the interval towards the ends and the least of |q|, Gauss & Legendre
/// on each part.
double integral(const std::function<double(double)>& g, double q0, double q1, double q2) {
    const auto q = [&](double u) { return std::abs(q0 + u * (q1 + u * q2)); };
    double tolerance = 0;
    for (int i = 0; i < 100; ++i) tolerance += 1e-13 * 0.02 / q(0.02 * i - 0.99);
    const std::function<double(double, double, int)> part = [&](double low, double high, int depth) {
        const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
        const auto sum = [&](double m, double h) {
            double s = 0;
            for (int j = 0; j < 3; ++j)
                s += h * kNodeWeights[j] * g(m + h * kNodes[j]) / q(m + h * kNodes[j]);
            return s;
        };
        const double whole = sum(middle, half);
        const double halves = sum(middle - half / 2, half / 2) + sum(middle + half / 2, half / 2);
        if (depth > 40 || std::abs(whole - halves) <= tolerance) return halves;
        return part(low, middle, depth + 1) + part(middle, high, depth + 1);
    };
    return part(-1, 1, 0);
}

TEST(ProductWeights, MomentsOfAllFormsAreExact) {
    // By discriminant and places of the roots: complex, double, both on one side, on both sides, one far off,
    // linear; down to gaps of 1e-6 at the nearer root.
    struct Case {
        double q0, q1, q2;
    };
    std::vector<Case> cases = {{1, 0.5, 0.3},   {1, -0.9, 0.25}, {1, 0.999, 0},       {1, -0.999999, 0},
                               {1, 0.4, 1e-9},  {1, 0.9, -1e-7}, {1, 0, 100},         {1e-6, 0, 1},
                               {1e-4, 1e-3, 1}, {1, 0, -0.9999}, {1, 0.3, -0.6},      {4, -4, 1.0001},
                               {4.41, 4.2, 1},  {4, 5, 1.00001}, {-1, 0.5, -0.3},     {1, 0.31, 0.001},
                               {1, 0.9, 0.08},  {1, -0.95, 0.1}, {1.21, -2.2, 1.0},   {1e-3, 1e-3, 2.6e-4},
                               {3, -3.1, 0.31}, {1, 0.95, 0.09}, {1, 0.95, 0.0899999}};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    while (cases.size() < 100) {
        // Roots anywhere but on the interval.
        const double p = 1 / uniform(random), r = 1 / uniform(random);
        cases.push_back({p * r, -(p + r), 1});
        const double x = 3 * uniform(random), y = std::pow(10.0, 3 * uniform(random) - 2);
        cases.push_back({x * x + y * y, -2 * x, 1});
    }
    double worst = 0;
    int peaks = 0;
    for (const Case& c : cases) {
        if (std::abs(c.q1) + 3 * std::abs(c.q2) <= kEvenEnough * std::abs(c.q0)) continue;
        double weight[3];
        ASSERT_TRUE(product_weights(c.q0, c.q1, c.q2, weight)) << c.q0 << ' ' << c.q1 << ' ' << c.q2;
        ++peaks;
        const double scale = integral([](double) { return 1.0; }, c.q0, c.q1, c.q2);
        for (int power = 0; power < 3; ++power) {
            double sum = 0;
            for (int j = 0; j < 3; ++j) sum += weight[j] * std::pow(kNodes[j], power);
            const double exact = integral([&](double u) { return std::pow(u, power); }, c.q0, c.q1, c.q2);
            const double error = std::abs(sum - exact) / scale;
            // A factor with a root 50 half-lengths off is left to the nodes. Next to a double root the
            // integral is as uncertain as the discriminant, of which q1^2 takes digits.
            const bool far = std::abs(c.q2) < 0.0205 * std::abs(c.q1);
            const double discriminant = c.q1 * c.q1 - 4 * c.q0 * c.q2;
            const double digits = 2e-15 * c.q1 * c.q1 / std::abs(discriminant);
            EXPECT_LT(error, (far ? 1e-5 : 1e-11) + digits)
                << c.q0 << ' ' << c.q1 << ' ' << c.q2 << " power " << power;
            if (!far && digits < 1e-12) worst = std::max(worst, error);
        }
    }
    printf("%d products: moments off by %.1e at most\n", peaks, worst);
    EXPECT_GT(peaks, 80);
}

TEST(ProductWeights, EvenAreasNeedNone) {
    double worst = 0;
    for (double q1 = -0.3; q1 <= 0.3001; q1 += 0.05) {
        for (const double q2 : {-(0.3 - std::abs(q1)) / 3, 0.0, (0.3 - std::abs(q1)) / 3}) {
            double sum = 0;
            for (int j = 0; j < 3; ++j) sum += kNodeWeights[j] / (1 + kNodes[j] * (q1 + kNodes[j] * q2));
            const double exact = integral([](double) { return 1.0; }, 1, q1, q2);
            worst = std::max(worst, std::abs(sum / exact - 1));
        }
    }
    printf("even areas: off by %.1e\n", worst);
    EXPECT_LT(worst, 5e-5);
}

TEST(ProductWeights, RootsWithinHaveNoIntegral) {
    double weight[3];
    EXPECT_FALSE(product_weights(0, 1, 0, weight));
    EXPECT_FALSE(product_weights(1, 1, 0, weight));
    EXPECT_FALSE(product_weights(1, -2, 1, weight));
    EXPECT_FALSE(product_weights(0.01, 0.2, 1, weight));
    EXPECT_FALSE(product_weights(0, 0, 0, weight));
    EXPECT_FALSE(product_weights(std::nan(""), 0, 1, weight));
}

}  // namespace
}  // namespace dapple
