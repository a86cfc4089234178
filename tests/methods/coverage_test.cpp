// The kernel of sliced beams against polygon clipping in long double.
#include "methods/sliced_beams/coverage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <random>
#include <vector>

#include "methods/sliced_beams/polygon.h"

namespace dapple {
namespace {

using namespace methods::sliced_beams;

struct Point {
    long double x, y;
};
using Polygon = std::vector<Point>;

long double signed_area(const Polygon& polygon) {
    long double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        sum += p.x * q.y - q.x * p.y;
    }
    return sum / 2;
}

/// The part of a convex polygon where nx x + ny y <= limit.
Polygon cut(const Polygon& polygon, long double nx, long double ny, long double limit) {
    Polygon kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const long double at_p = nx * p.x + ny * p.y - limit, at_q = nx * q.x + ny * q.y - limit;
        if (at_p <= 0) kept.push_back(p);
        if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0)) {
            const long double t = at_p / (at_p - at_q);
            kept.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
        }
    }
    return kept;
}

Polygon within_square(Polygon polygon) {
    polygon = cut(polygon, 1, 0, 0.5L);
    polygon = cut(polygon, -1, 0, 0.5L);
    polygon = cut(polygon, 0, 1, 0.5L);
    return cut(polygon, 0, -1, 0.5L);
}

template <class Real>
struct Triangle {
    Real x[3], y[3];

    Polygon polygon() const { return {{x[0], y[0]}, {x[1], y[1]}, {x[2], y[2]}}; }
    long double area() const { return std::abs(signed_area(polygon())); }
    long double exact_share() const { return std::abs(signed_area(within_square(polygon()))) / area(); }
    long double reach() const {
        long double reach = 1;
        for (int k = 0; k < 3; ++k)
            reach = std::max(
                {reach, std::abs(static_cast<long double>(x[k])), std::abs(static_cast<long double>(y[k]))});
        return reach;
    }
    long double size() const {
        const auto [low_x, high_x] = std::minmax_element(x, x + 3);
        const auto [low_y, high_y] = std::minmax_element(y, y + 3);
        return std::max(static_cast<long double>(*high_x) - *low_x,
                        static_cast<long double>(*high_y) - *low_y);
    }
    /// Far from being taken for a line: the kernel's own bound is at 256.
    bool clearly_wide() const {
        return area() > 300 * static_cast<long double>(std::numeric_limits<Real>::epsilon()) *
                            (size() + 0.5L) * size();
    }
};

template <class Real>
LandedBeams<Real> in_lanes(const std::vector<Triangle<Real>>& triangles) {
    LandedBeams<Real> beams{};
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kLanes<Real>); ++lane) {
        const Triangle<Real>& t = triangles[lane % triangles.size()];
        for (int k = 0; k < 3; ++k) {
            beams.x[k][lane] = t.x[k];
            beams.y[k][lane] = t.y[k];
        }
    }
    return beams;
}

template <class Real>
Real share_of(const Triangle<Real>& triangle) {
    return covered_share<Real>(in_lanes<Real>({triangle}))[0];
}

template <class Real>
class Coverage : public testing::Test {
protected:
    static constexpr Real kEpsilon = std::numeric_limits<Real>::epsilon();
    std::mt19937_64 random{7};

    Real uniform(double low, double high) {
        return static_cast<Real>(std::uniform_real_distribution<double>(low, high)(random));
    }
    /// About (x, y), of size `scale`, flattened across a random direction by `flatness`.
    Triangle<Real> triangle_about(double x, double y, double scale, double flatness) {
        Triangle<Real> t;
        const double turn = static_cast<double>(uniform(0, 6.3));
        for (int k = 0; k < 3; ++k) {
            const double along = scale * static_cast<double>(uniform(-1, 1));
            const double across = scale * flatness * static_cast<double>(uniform(-1, 1));
            t.x[k] = static_cast<Real>(x + along * std::cos(turn) - across * std::sin(turn));
            t.y[k] = static_cast<Real>(y + along * std::sin(turn) + across * std::cos(turn));
        }
        return t;
    }
    /// What the rounding of a few operations on corners is worth: edges are off by epsilon times the corners'
    /// distance, over what length of them lies in the square; areas by epsilon times the size's square.
    static long double tolerance(const Triangle<Real>& t) {
        const long double size = t.size(), whole = t.area();
        const long double edges = t.reach() * std::min(size, 1.0L);
        const long double area = std::min(1.0L, 1 / whole) * size * size;
        return kEpsilon * (1 + 4 * (edges + area) / whole);
    }
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Coverage, Reals);

TYPED_TEST(Coverage, ShareIsThatOfTheClippedPolygon) {
    std::size_t partly = 0, wide = 0;
    long double worst = 0;
    for (const double scale : {1e-4, 1e-2, 0.3, 1.0, 5.0, 100.0, 3000.0}) {
        for (const double flatness : {1.0, 0.1, 1e-3}) {
            for (int i = 0; i < 2000; ++i) {
                // Small ones about the square's border and corners, large ones about all of it.
                const double spread = 0.5 + 0.6 * scale;
                double x = static_cast<double>(this->uniform(-spread, spread));
                const double y = static_cast<double>(this->uniform(-spread, spread));
                if (scale < 0.1) x = (x < 0 ? -0.5 : 0.5) + scale * x;
                const Triangle<TypeParam> t = this->triangle_about(x, y, scale, flatness);
                if (!t.clearly_wide()) continue;
                ++wide;
                const long double exact = t.exact_share();
                const long double share = share_of(t);
                ASSERT_LE(std::abs(share - exact), this->tolerance(t))
                    << scale << ' ' << flatness << ": " << t.x[0] << ',' << t.y[0] << ' ' << t.x[1] << ','
                    << t.y[1] << ' ' << t.x[2] << ',' << t.y[2];
                worst = std::max(worst, std::abs(share - exact) / this->tolerance(t));
                partly += exact > 0 && exact < 1;
            }
        }
    }
    printf("%zu triangles, %zu of them cut: worst error %.2Lf of the tolerance\n", wide, partly, worst);
    EXPECT_GT(partly, 5000u);
    EXPECT_GT(worst, 0.01L);  // the tolerance is not so wide that it says nothing
}

TYPED_TEST(Coverage, LanesDoNotMix) {
    std::vector<Triangle<TypeParam>> triangles;
    for (int i = 0; i < kLanes<TypeParam>; ++i)
        triangles.push_back(this->triangle_about(0.3, -0.2, 1 + i, i % 2 ? 1 : 0));  // lines between others
    const Lanes<TypeParam> together = covered_share<TypeParam>(in_lanes(triangles));
    for (std::size_t i = 0; i < triangles.size(); ++i) EXPECT_EQ(together[i], share_of(triangles[i])) << i;
}

TYPED_TEST(Coverage, WholeAndEmptySharesAreExact) {
    for (int i = 0; i < 1000; ++i) {
        const auto inside = this->triangle_about(this->uniform(-0.2, 0.2), this->uniform(-0.2, 0.2), 0.2, 1);
        ASSERT_EQ(share_of(inside), 1);
        const auto outside = this->triangle_about(5, this->uniform(-4, 4), 3, 1);
        ASSERT_EQ(share_of(outside), 0);
    }
}

TYPED_TEST(Coverage, ATriangleAboutTheWholeSquareGivesItsAreasRatio) {
    for (const double scale : {3.0, 50.0, 2000.0}) {
        const TypeParam s = static_cast<TypeParam>(scale);
        const Triangle<TypeParam> t{{-s, s, 0}, {-s, -s, s}};
        EXPECT_LE(std::abs(share_of(t) * t.area() - 1), this->kEpsilon * scale);
    }
}

TYPED_TEST(Coverage, TouchingFromOutsideCoversNothing) {
    using T = Triangle<TypeParam>;
    // Along an edge, from all sides, with a corner, and with the hypotenuse through a corner.
    for (const T& t : {T{{-0.5, 0.5, 0}, {0.5, 0.5, 1}}, T{{-0.5, 0.5, 0}, {-0.5, -0.5, -1}},
                       T{{0.5, 0.5, 2}, {-0.5, 0.5, 0}}, T{{-0.5, -0.5, -2}, {-2, 2, 0}},
                       T{{0.5, 1, 2}, {0.5, 1, 0.75}}, T{{1.5, -0.5, 1.5}, {-0.5, 1.5, 1.5}}})
        EXPECT_EQ(share_of(t), 0);
    // From inside, the square's own halves: nothing is lost at shared lines.
    EXPECT_EQ(share_of(T{{-0.5, 0.5, -0.5}, {-0.5, -0.5, 0.5}}), 1);
    EXPECT_EQ(share_of(T{{0.5, 0.5, -0.5}, {-0.5, 0.5, 0.5}}), 1);
    // Twice the square's side: a quarter of this right triangle's legs ... half of its area.
    EXPECT_EQ(share_of(T{{-0.5, 1.5, -0.5}, {-0.5, -0.5, 1.5}}), TypeParam(0.5));
}

TYPED_TEST(Coverage, BeamsOnALineCountByTheirLongestEdge) {
    using T = Triangle<TypeParam>;
    const TypeParam tolerance = 4 * this->kEpsilon;
    EXPECT_NEAR(share_of(T{{-1, 0, 1}, {0, 0, 0}}), 0.5, tolerance);             // across the middle
    EXPECT_NEAR(share_of(T{{0, 1, 2}, {-1, 0, 1}}), 0, tolerance);               // through a corner
    EXPECT_NEAR(share_of(T{{-1, 1, 1}, {-1, 1, 1}}), 0.5, tolerance);            // along a diagonal
    EXPECT_NEAR(share_of(T{{0, 0, 0}, {0, 4, 1}}), 0.125, tolerance);            // upright, begins inside
    EXPECT_NEAR(share_of(T{{-3, 5, 2}, {0.25, 0.25, 0.25}}), 0.125, tolerance);  // level
    EXPECT_EQ(share_of(T{{-3, 5, 2}, {0.75, 0.75, 0.75}}), 0);                   // beside
    EXPECT_EQ(share_of(T{{0.1f, 0.1f, 0.1f}, {0.2f, 0.2f, 0.2f}}), 1);           // a point inside
    EXPECT_EQ(share_of(T{{0.6f, 0.6f, 0.6f}, {0.2f, 0.2f, 0.2f}}), 0);           // and one outside
}

TYPED_TEST(Coverage, CornersThatAreNotFiniteCoverNothingOrPart) {
    using T = Triangle<TypeParam>;
    const TypeParam nan = std::numeric_limits<TypeParam>::quiet_NaN();
    const TypeParam infinity = std::numeric_limits<TypeParam>::infinity();
    for (const TypeParam bad : {nan, infinity, -infinity, std::numeric_limits<TypeParam>::max()}) {
        for (int corner = 0; corner < 3; ++corner) {
            for (const bool in_x : {true, false}) {
                T t{{-1, 1, 0}, {-1, -1, 1}};
                (in_x ? t.x : t.y)[corner] = bad;
                const TypeParam share = share_of(t);
                EXPECT_GE(share, 0);
                EXPECT_LE(share, 1);
            }
        }
    }
}

/// Sum over the squares of a grid that holds the triangle.
template <class Real>
double share_over_grid(const Triangle<Real>& t, int reach) {
    double sum = 0;
    for (int row = -reach; row <= reach; ++row) {
        for (int column = -reach; column <= reach; ++column) {
            Triangle<Real> moved = t;
            for (int k = 0; k < 3; ++k) {
                moved.x[k] -= static_cast<Real>(column);
                moved.y[k] -= static_cast<Real>(row);
            }
            sum += static_cast<double>(share_of(moved));
        }
    }
    return sum;
}

TYPED_TEST(Coverage, SharesOfOneBeamOverATilingSumToOne) {
    for (const double scale : {0.1, 1.0, 6.0}) {
        for (const double flatness : {1.0, 1e-2, 0.0}) {
            for (int i = 0; i < 100; ++i) {
                Triangle<TypeParam> t =
                    this->triangle_about(this->uniform(-1, 1), this->uniform(-1, 1), scale, flatness);
                // Multiples of 2^-18: moving to another square is exact also in float.
                for (int k = 0; k < 3; ++k) {
                    t.x[k] =
                        static_cast<TypeParam>(std::ldexp(std::round(std::ldexp(double(t.x[k]), 18)), -18));
                    t.y[k] =
                        static_cast<TypeParam>(std::ldexp(std::round(std::ldexp(double(t.y[k]), 18)), -18));
                }
                if (flatness > 0 && !t.clearly_wide()) continue;
                // Up to 17 squares along an edge, each off by its own rounding.
                const double tolerance = flatness > 0 ? 17 * static_cast<double>(this->tolerance(t))
                                                      : 17 * 4 * static_cast<double>(this->kEpsilon);
                if (flatness == 0 && t.area() > 0) continue;  // rounding made it no line
                ASSERT_NEAR(share_over_grid(t, 9), 1, tolerance) << scale << ' ' << flatness;
            }
        }
    }
}

TYPED_TEST(Coverage, AllSquaresOfATilingTakeAThinBeamForTheSame) {
    // About the bound between a triangle and a line, at 256 roundings: what one square counts by area and
    // another by length would not sum to 1.
    const double epsilon = static_cast<double>(this->kEpsilon);
    const int unit = std::numeric_limits<TypeParam>::digits - 6;  // moves by whole squares are exact
    for (int i = 0; i < 400; ++i) {
        const double length = static_cast<double>(this->uniform(2, 12));
        const double turn = static_cast<double>(this->uniform(0.2, 1.3));
        const double bound = 2 * 256 * epsilon * (length * std::max(std::cos(turn), std::sin(turn)) + 0.5);
        const double width = bound * static_cast<double>(this->uniform(0.3, 3));
        const glm::dvec2 along(std::cos(turn), std::sin(turn)), across(-along.y, along.x);
        const glm::dvec2 corners[3] = {
            -0.5 * length * along, 0.5 * length * along,
            static_cast<double>(this->uniform(-0.4, 0.4)) * length * along + width * across};
        Triangle<TypeParam> t;
        for (int k = 0; k < 3; ++k) {
            t.x[k] = static_cast<TypeParam>(std::ldexp(std::round(std::ldexp(corners[k].x, unit)), -unit));
            t.y[k] = static_cast<TypeParam>(std::ldexp(std::round(std::ldexp(corners[k].y, unit)), -unit));
        }
        // A square's share is right to some hundredth of its part of the beam, 1 / length.
        ASSERT_NEAR(share_over_grid(t, 7), 1, 0.02);
    }
}

TYPED_TEST(Coverage, BeamsThatShareEdgesLeaveNoSeam) {
    // A fan about a point of the square out to a ring of corners: its beams cover the square exactly once.
    for (int trial = 0; trial < 200; ++trial) {
        const double radius = trial % 2 ? 1.5 : 40;
        const int corners = 3 + trial % 17 + 2;
        const double x = static_cast<double>(this->uniform(-0.4, 0.4)),
                     y = static_cast<double>(this->uniform(-0.4, 0.4));
        const double turn = static_cast<double>(this->uniform(0, 1));
        double covered = 0;
        for (int i = 0; i < corners; ++i) {
            Triangle<TypeParam> t;
            t.x[0] = static_cast<TypeParam>(x);
            t.y[0] = static_cast<TypeParam>(y);
            for (int k = 1; k < 3; ++k) {
                const double angle = 6.283185307179586 * (((i + k - 1) % corners) + turn) / corners;
                t.x[k] = static_cast<TypeParam>(radius * std::cos(angle));
                t.y[k] = static_cast<TypeParam>(radius * std::sin(angle));
            }
            covered += static_cast<double>(share_of(t)) * static_cast<double>(t.area());
        }
        // The inner radius of a pentagon of 1.5 is 1.2. Edges are off by epsilon times their length.
        ASSERT_NEAR(covered, 1, 4 * corners * radius * static_cast<double>(this->kEpsilon));
    }
}

TYPED_TEST(Coverage, AnEdgeCountsTheSameFromBothSides) {
    for (int i = 0; i < 1000; ++i) {
        const auto t = this->triangle_about(0, 0, 2, 1);
        const Lanes<TypeParam> x0 = splat(t.x[0]), y0 = splat(t.y[0]), x1 = splat(t.x[1]), y1 = splat(t.y[1]);
        const Lanes<TypeParam> base = splat(to_square<TypeParam>(splat(t.y[2]))[0]);
        ASSERT_EQ(area_below_edge<TypeParam>(x0, y0, x1, y1, base)[0],
                  -area_below_edge<TypeParam>(x1, y1, x0, y0, base)[0]);
    }
}

TYPED_TEST(Coverage, TheBoundingTestNeverDropsAShare) {
    for (int i = 0; i < 5000; ++i) {
        const auto t = this->triangle_about(this->uniform(-2, 2), this->uniform(-2, 2), 1.2, i % 3 ? 1 : 0);
        if (share_of(t) > 0) {
            ASSERT_TRUE(any(may_meet_square(in_lanes<TypeParam>({t}))));
        }
    }
}

TYPED_TEST(Coverage, CuttingByLinesGivesTheSameShare) {
    const TypeParam lit[3] = {1, 1, 1};
    for (int i = 0; i < 5000; ++i) {
        const double scale = std::pow(10.0, static_cast<double>(this->uniform(-1, 1)));
        const auto t = this->triangle_about(this->uniform(-1, 1), this->uniform(-1, 1), scale, 1);
        if (!t.clearly_wide()) continue;
        const ClippedBeam<TypeParam> part = clip_beam(t.x, t.y, lit);
        // Barycentric coordinates of the cuts are off by the rounding of corners over the beam's width.
        const long double width = t.area() / t.size();
        ASSERT_LE(std::abs(part.share - t.exact_share()), 16 * this->kEpsilon * t.reach() / width);
        if (part.share == 0) continue;
        // The part's centre lies in the square, but for its rounding.
        TypeParam x = 0, y = 0;
        for (int k = 0; k < 3; ++k) {
            x += part.weights[k] * t.x[k];
            y += part.weights[k] * t.y[k];
        }
        const long double room = 0.5L + 16 * this->kEpsilon * t.reach() * t.size() / width;
        ASSERT_LE(std::abs(x), room);
        ASSERT_LE(std::abs(y), room);
    }
}

TYPED_TEST(Coverage, CuttingByTheSurfaceKeepsWhatIsInTheLight) {
    const TypeParam tolerance = 8 * this->kEpsilon;
    const TypeParam x[3] = {-0.25, 0.25, -0.25}, y[3] = {-0.25, -0.25, 0.25};
    // In the light beyond half the way from corner 0 to the others: all but a quarter.
    const TypeParam half[3] = {-1, 1, 1}, none[3] = {-1, -2, -3}, tip[3] = {1, -1, -3};
    EXPECT_NEAR(clip_beam(x, y, half).share, 0.75, tolerance);
    EXPECT_EQ(clip_beam(x, y, none).share, 0);
    EXPECT_NEAR(clip_beam(x, y, tip).share, 0.125, tolerance);
    // By the square and the surface at once: x >= -1/2 cuts off nothing, y >= 0 in the light.
    const TypeParam above[3] = {-0.5, -0.5, 0.5};
    EXPECT_NEAR(clip_beam(x, y, above).share, 0.25, tolerance);
}

TEST(Decay, IsWithinTwoUnitsOfTheLastPlace) {
    double worst = 0;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> logarithm(-20, 6.4f);  // up to 84
    for (int i = 0; i < 200000; ++i) {
        const float x = i % 4 ? std::exp2(logarithm(random)) : 86.9f * static_cast<float>(i) / 200000;
        const double exact = std::exp(-static_cast<double>(x));
        const float value = decay(splat(x))[i % 8];
        const float nearest = static_cast<float>(exact);
        const double unit = static_cast<double>(nearest) - static_cast<double>(std::nextafter(nearest, 0.0f));
        worst = std::max(worst, std::abs(static_cast<double>(value) - exact) / unit);
    }
    printf("worst error of decay: %.2f ulp\n", worst);
    EXPECT_LE(worst, 2);
    EXPECT_EQ(decay(splat(0.0f))[0], 1);
    EXPECT_LT(decay(splat(1e30f))[0], 2e-38f);
    EXPECT_GE(decay(splat(1e30f))[0], 0);
    for (const double x : {0.0, 0.3, 20.0, 700.0}) EXPECT_EQ(decay(splat(x))[3], std::exp(-x));
}

}  // namespace
}  // namespace dapple
