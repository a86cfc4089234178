#include "render/volumetric_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "closed_form/cloud.h"
#include "light/gobo.h"
#include "light/spot_picture.h"
#include "optics/optics.h"

namespace dapple {
namespace {

constexpr double kPi = glm::pi<double>();

/// A scene and the segments of a row of pixels that are looked at in it.
struct LitSegments {
    scene::FrameScene scene;
    view::SegmentLayer layer;

    LitSegments() {
        scene.state.clip.samples = 1;
        layer.height = 1;
        layer.first.push_back(0);
    }
    void add(const glm::dvec3& origin, const glm::dvec3& direction, double length, bool in_water) {
        layer.origin.emplace_back(origin - scene.origin);
        layer.direction.emplace_back(glm::normalize(direction));
        layer.length.push_back(static_cast<float>(length));
        layer.in_water.push_back(in_water ? 1 : 0);
        layer.primary.push_back(1);
        layer.throughput.emplace_back(1.0f);
        for (auto* spread : {&layer.spread_u_origin, &layer.spread_u_direction, &layer.spread_v_origin,
                             &layer.spread_v_direction})
            spread->emplace_back(0.0f);
        layer.first.push_back(layer.first.back() + 1);
        ++layer.width;
    }
    void add_plane(const glm::dvec3& position, const glm::dvec3& size) {
        scene::Object plane;
        plane.shape = scene::Shape::plane;
        plane.size = size;
        plane.transform.position = position;
        scene.state.objects.push_back(plane);
        scene.object_meshes.emplace_back();
    }
    std::vector<glm::vec3> light() const {
        std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
        const rays::RayScene rays(scene);
        render::add_volumetric_direct_light(scene, media::Media(scene), rays, layer, radiance);
        return radiance;
    }
};

/// Water to all sides with a lamp in it.
LitSegments lamp_in_water(const glm::dvec3& position) {
    LitSegments lit;
    lit.scene.origin = {3, 0, -2};
    lit.scene.state.water.emplace();
    lit.scene.state.water->absorption = {0.4, 0.1, 0.02};
    lit.scene.state.water->scattering = {0.1, 0.2, 0.05};
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = position;
    lamp.intensity = {10, 20, 30};
    lit.scene.state.lights = {lamp};
    return lit;
}

double henyey_greenstein(double cosine, double g) {
    return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

/// Simpson's rule, halved until it stands.
double adaptive(const std::function<double(double)>& f, double a, double b, double whole, int depth = 0) {
    const auto simpson = [&](double low, double high) {
        return (high - low) / 6 * (f(low) + 4 * f(0.5 * (low + high)) + f(high));
    };
    const double middle = 0.5 * (a + b), left = simpson(a, middle), right = simpson(middle, b);
    if (depth >= 48 || (depth > 6 && std::abs(left + right - whole) < 1e-12 * (1 + std::abs(left + right))))
        return left + right;
    return adaptive(f, a, middle, left, depth + 1) + adaptive(f, middle, b, right, depth + 1);
}

/// Single scattering of a lamp in endless even water, by its definition.
double seen_of_lamp(const LitSegments& lit, std::size_t i, int channel, double g) {
    const scene::Water& water = *lit.scene.state.water;
    const scene::Light& lamp = lit.scene.state.lights[0];
    const glm::dvec3 origin = glm::dvec3(lit.layer.origin[i]) + lit.scene.origin;
    const glm::dvec3 direction = glm::normalize(glm::dvec3(lit.layer.direction[i]));
    const double length = static_cast<double>(lit.layer.length[i]);
    const double sigma = water.extinction()[channel];
    const auto at = [&](double s) {
        const glm::dvec3 way = origin + s * direction - lamp.position;
        const double r = glm::length(way);
        return water.scattering[channel] * henyey_greenstein(-dot(way / r, direction), g) *
               lamp.intensity[channel] * std::exp(-sigma * (s + r)) / (r * r);
    };
    const double foot = std::clamp(dot(lamp.position - origin, direction), 0.0, length);
    return adaptive(at, 0, foot, 0) + adaptive(at, foot, length, 0);
}

/// Quadrature steps of one node leave depth^2 / 24 = 4e-4 of what they hold, those of three far less; a
/// hundred of steps with either sign of curvature stay below it.
constexpr double kQuadrature = 4e-4;

TEST(VolumetricLight, OfALampInEvenWaterIsTheSingleScatterIntegral) {
    for (const double g : {0.0, 0.9, -0.4}) {
        LitSegments lit = lamp_in_water({4, -2, -2});
        lit.scene.state.water->phase.type = scene::PhaseType::henyey_greenstein;
        lit.scene.state.water->phase.anisotropy = g;
        lit.add({0, -2, -1}, {1, 0, 0}, 10, true);      // passes at 1 m
        lit.add({0, -2, -1.99}, {1, 0, 0}, 10, true);   // passes at 1 cm
        lit.add({0, -2, -1.99}, {1, 0, 0}, 800, true);  // the same, cut where it is black
        lit.add({0, -2, -2}, {-1, 0.2, 0}, 30, true);   // away from it
        lit.add({0, -2, -2}, {0.4, 0, 0.91}, 3, true);  // aside
        lit.add({4, -2.05, -2}, {0, -1, 0}, 6, true);   // from below the lamp, down
        lit.add({4, -30, -1.9}, {0, 1, 0}, 60, true);   // up past it
        const std::vector<glm::vec3> found = lit.light();
        for (std::size_t i = 0; i < found.size(); ++i) {
            for (int channel = 0; channel < 3; ++channel) {
                const double expected = seen_of_lamp(lit, i, channel, g);
                EXPECT_NEAR(found[i][channel], expected, kQuadrature * expected)
                    << "segment " << i << " channel " << channel << " g " << g;
            }
        }
    }
}

TEST(VolumetricLight, ALampLightsItsOwnSideOfTheWaterOnly) {
    LitSegments lit = lamp_in_water({0, -2, 0});
    lit.add({1, -1, 0}, {0, -1, 0}, 5, true);
    lit.add({1, 4, 0}, {0, 0, 1}, 5, false);
    EXPECT_GT(lit.light()[0].x, 0);
    EXPECT_EQ(lit.light()[1], glm::vec3(0)) << "nothing scatters in the air";
    lit.scene.state.lights[0].position.y = 2;
    EXPECT_EQ(lit.light()[0], glm::vec3(0)) << "through the surface its light is the method's";
    lit.scene.state.lights[0].type = scene::LightType::sun;
    EXPECT_EQ(lit.light()[0], glm::vec3(0));
}

TEST(VolumetricLight, ASpotLightsItsCone) {
    LitSegments lit = lamp_in_water({0, -2, 0});
    scene::Light& spot = lit.scene.state.lights[0];
    lit.add({-5, -3, 0}, {1, 0, 0}, 10, true);
    const glm::vec3 everywhere = lit.light()[0];
    spot.type = scene::LightType::spot;
    spot.direction = {0, -1, 0};
    spot.cone_angle = kPi / 4;
    spot.falloff_angle = 1e-9;
    const glm::vec3 found = lit.light()[0];
    // The part of the segment within a metre of the axis, by itself.
    LitSegments part = lamp_in_water({0, -2, 0});
    part.add({-1, -3, 0}, {1, 0, 0}, 2, true);
    const glm::dvec3 expected =
        glm::dvec3(part.light()[0]) * glm::exp(-4.0 * lit.scene.state.water->extinction());
    // The edge of the cone lies somewhere in a step of at most pi / 16 of the pi / 2 that are lit, at each
    // end.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.1 * expected[c]);
    EXPECT_LT(found.x, 0.9f * everywhere.x);
    spot.direction = {0, 1, 0};
    EXPECT_EQ(lit.light()[0], glm::vec3(0));
}

/// A lamp that the segment runs into: what one ray sees is endless, the mean over the pixel is not.
TEST(VolumetricLight, ALampInThePixelShinesAsItsMean) {
    constexpr double pixel = 0.02;  // m, at the lamp
    const auto through = [&](double x, double y) {
        LitSegments lit = lamp_in_water({0, -2, -5});
        lit.add({x, -2 + y, 0}, {0, 0, -1}, 10, true);
        return lit;
    };
    LitSegments lit = through(0, 0);
    lit.layer.spread_u_origin[0] = {pixel, 0, 0};
    lit.layer.spread_v_origin[0] = {0, -pixel, 0};
    const double found = static_cast<double>(lit.light()[0].y);
    double sum = 0;
    constexpr int n = 32;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            sum += static_cast<double>(
                through(pixel * ((i + 0.5) / n - 0.5), pixel * ((j + 0.5) / n - 0.5)).light()[0].y);
        }
    }
    // The disc of the pixel's area stands for its square: the mean of 1 / r over them differs by 0.7 %. The
    // points of the grid nearest to the lamp leave out 1 / n^2 of the area, where 1 / r is largest: 1 %.
    EXPECT_NEAR(found, sum / (n * n), 0.03 * found);
    EXPECT_TRUE(std::isfinite(through(0, 0).light()[0].y));
}

/// A plane of 4 m beside the lamp hides one half of the segment.
TEST(VolumetricLight, ShadowsHideTheirShare) {
    LitSegments lit = lamp_in_water({0, -2, 0});
    lit.scene.state.water->absorption = {0, 0, 0};
    lit.scene.state.water->scattering = {1e-6, 1e-6, 1e-6};
    lit.scene.state.water->phase.type = scene::PhaseType::isotropic;
    for (int i = 0; i < 256; ++i) lit.add({-3, -3, 0}, {1, 0, 0}, 6, true);
    const double whole = static_cast<double>(lit.light()[0].x);
    lit.add_plane({2.25, -2.5, 0}, {4, 1, 4});  // covers x > 0.25 at -2.5, so x > 0.5 on the segment
    lit.scene.state.clip.samples = 4;
    // Equi-angular: the lit share is that of the angle from -3 to 0.5.
    const double lit_share = (std::atan(0.5) + std::atan(3.0)) / (2 * std::atan(3.0));
    double sum = 0, largest = 0;
    std::vector<double> mean(256, 0);
    for (int sample = 0; sample < 4; ++sample) {
        lit.layer.sample = sample;
        const std::vector<glm::vec3> found = lit.light();
        for (std::size_t i = 0; i < 256; ++i) {
            const double share = static_cast<double>(found[i].x) / whole;
            // One of eight strata holds the edge of the shadow, and is lit or not.
            EXPECT_LE(std::abs(share - lit_share), 1.0 / render::kShadowPoints);
            mean[i] += share / 4;
            sum += share / 1024;
        }
    }
    // The samples of a pixel cut the strata into four.
    for (const double share : mean) largest = std::max(largest, std::abs(share - lit_share));
    EXPECT_LE(largest, 0.25 / render::kShadowPoints + 1e-3);
    // Neighbors fill each other's gaps: a golden ratio's worth of discrepancy, about (1 + log n) / n.
    EXPECT_NEAR(sum, lit_share, (1 + std::log(256.0)) / 256 / render::kShadowPoints);
}

TEST(VolumetricLight, PointsAreTheSameInAllFramesAndApartInPixels) {
    LitSegments lit = lamp_in_water({0, -2, 0});
    for (int i = 0; i < 64; ++i) lit.add({-3, -3, 0}, {1, 0, 0}, 6, true);
    lit.add_plane({2.25, -2.5, 0}, {4, 1, 4});
    const std::vector<glm::vec3> first = lit.light();
    lit.scene.state.frame = 77;
    EXPECT_EQ(lit.light(), first);
    lit.scene.state.clip.seed = 5;
    EXPECT_NE(lit.light(), first);
    EXPECT_NE(first[0], first[1]);
}

/// A box of smoke about the origin in the air, 2 m high.
LitSegments sun_on_box() {
    LitSegments lit;
    scene::Medium smoke;
    smoke.type = scene::MediumType::box;
    smoke.density = 2;
    smoke.extinction = {0.3, 0.5, 0.9};
    smoke.albedo = {0.9, 0.5, 0.2};
    smoke.size = {6, 2, 4};
    smoke.transform.position = {0, 3, 0};
    lit.scene.state.media = {smoke};
    lit.scene.medium_grids.resize(1);
    scene::Light sun;
    sun.type = scene::LightType::sun;
    sun.direction = {0, -1, 0};
    sun.irradiance = {3, 2, 1};
    lit.scene.state.lights = {sun};
    return lit;
}

TEST(VolumetricLight, OfTheSunInABoxFollowsItsClosedForms) {
    LitSegments lit = sun_on_box();
    lit.add({-5, 2.5, 0}, {1, 0, 0}, 20, false);    // across, 1.5 m under the top
    lit.add({0, 1, 0}, {0, 1, 0}, 20, false);       // from below, towards the sun
    lit.add({0, 5, 0}, {0, -1, 0}, 20, false);      // from above
    lit.add({0, 3.5, 0}, {0, -1, 0}, 0.75, false);  // from within to within
    lit.add({0, 5, 0}, {1, 0, 0}, 20, false);       // above it
    const std::vector<glm::vec3> found = lit.light();
    const scene::Medium& smoke = lit.scene.state.media[0];
    for (int c = 0; c < 3; ++c) {
        const double sigma = smoke.density * smoke.extinction[c];
        const double source = smoke.albedo[c] * sigma * lit.scene.state.lights[0].irradiance[c] / (4 * kPi);
        const auto expect = [&](std::size_t i, double integral) {
            EXPECT_NEAR(found[i][c], source * integral, kQuadrature * source * integral) << i << " " << c;
        };
        expect(0, std::exp(-1.5 * sigma) * (1 - std::exp(-6 * sigma)) / sigma);
        expect(1, 2 * std::exp(-2 * sigma));
        expect(2, (1 - std::exp(-4 * sigma)) / (2 * sigma));
        expect(3, std::exp(-0.5 * sigma) * (1 - std::exp(-1.5 * sigma)) / (2 * sigma));
        EXPECT_EQ(found[4][c], 0);
    }
}

/// Whatever the density: a wall, and nothing.
TEST(VolumetricLight, OfDenseAndThinFogIsItsLimit) {
    LitSegments lit = sun_on_box();
    lit.add({0, 5, 0}, {0, -1, 0}, 20, false);
    lit.add({0, 2.5, 0}, {1, 0, 0}, 20, false);
    scene::Medium& smoke = lit.scene.state.media[0];
    for (const double density : {1e-9, 100.0, 1e5, 1e9}) {
        smoke.density = density;
        smoke.extinction = {0, 1e-3, 1};
        const std::vector<glm::vec3> found = lit.light();
        EXPECT_EQ(found[0].x, 0);
        for (int c = 1; c < 3; ++c) {
            const double sigma = density * smoke.extinction[c];
            const double source =
                smoke.albedo[c] * sigma * lit.scene.state.lights[0].irradiance[c] / (4 * kPi);
            const double expected = source * -std::expm1(-4 * sigma) / (2 * sigma);
            EXPECT_NEAR(found[0][c], expected, 1e-3 * expected) << density << " " << c;
            EXPECT_TRUE(std::isfinite(found[1][c]));
        }
    }
}

TEST(VolumetricLight, OfASlantingSunInABoxIsFineQuadrature) {
    LitSegments lit = sun_on_box();
    const glm::dvec3 travel = glm::normalize(glm::dvec3(1, -0.7, 0.2));
    lit.scene.state.lights[0].direction = travel;
    lit.scene.state.media[0].phase.type = scene::PhaseType::henyey_greenstein;
    lit.scene.state.media[0].phase.anisotropy = 0.7;
    lit.add({-5, 2.2, 0.3}, {1, 0.1, 0.05}, 20, false);
    lit.add({2, 6, 4}, {-0.3, -0.6, -0.7}, 20, false);
    const std::vector<glm::vec3> found = lit.light();
    const scene::Medium& smoke = lit.scene.state.media[0];
    const glm::dvec3 low = smoke.transform.position - 0.5 * smoke.size;
    const glm::dvec3 high = smoke.transform.position + 0.5 * smoke.size;
    // Metres of a ray in the box, by slabs.
    const auto inside = [&](const glm::dvec3& from, const glm::dvec3& direction, double far) {
        double enter = 0, leave = far;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = (low[axis] - from[axis]) / direction[axis];
            const double b = (high[axis] - from[axis]) / direction[axis];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        return std::max(0.0, leave - enter);
    };
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec3 origin(lit.layer.origin[i]), direction(lit.layer.direction[i]);
        glm::dvec3 sum(0);
        constexpr int n = 200000;
        const glm::dvec3 sigma = smoke.density * smoke.extinction;
        for (int k = 0; k < n; ++k) {
            const double s = 20.0 * (k + 0.5) / n;
            const glm::dvec3 p = origin + s * direction;
            if (glm::any(glm::lessThan(p, low)) || glm::any(glm::greaterThan(p, high))) continue;
            sum += 20.0 / n * glm::exp(-sigma * (inside(origin, direction, s) + inside(p, -travel, 1e9)));
        }
        sum *= smoke.albedo * sigma * henyey_greenstein(-dot(travel, direction), 0.7) *
               lit.scene.state.lights[0].irradiance;
        // Where light comes to the box by another face its way has a kink within a step: 1e-3.
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[i][c], sum[c], 1.5e-3 * sum[c]) << i << " " << c;
    }
}

/// Light in a cloud, of the sun or of a lamp, to fine quadrature, in four segments. `width`: of its grid,
/// voxels.
double worst_in_cloud(int width, const std::optional<glm::dvec3>& lamp = std::nullopt) {
    LitSegments lit = sun_on_box();
    scene::Medium& cloud = lit.scene.state.media[0];
    cloud.type = scene::MediumType::grid;
    cloud.density = 1;
    cloud.extinction = {1, 2, 4};
    cloud.albedo = {0.9, 0.9, 0.9};
    cloud.transform.position = {0, 3, 0};
    lit.scene.medium_grids[0] = test::cloud(0.5, width);
    scene::Light& light = lit.scene.state.lights[0];
    light.direction = glm::normalize(glm::dvec3(1, -0.7, 0.2));
    if (lamp) {
        light.type = scene::LightType::point;
        light.position = *lamp;
        light.intensity = light.irradiance;
    }
    lit.add({-5, 2.9, 0.1}, {1, 0.02, 0.01}, 10, false);
    lit.add({2, 6, 4}, {-0.5, -0.75, -1}, 10, false);
    lit.add({-4, 5.8, -0.8}, {1, -0.7, 0.2}, 10, false);  // with the light
    lit.add({4, 0.2, 0.8}, {-1, 0.7, -0.2}, 10, false);   // against it
    const std::vector<glm::vec3> found = lit.light();
    const media::Media media(lit.scene);
    constexpr double far = std::numeric_limits<double>::infinity();
    double worst = 0;
    for (std::size_t i = 0; i < lit.layer.segments(); ++i) {
        const glm::dvec3 origin(lit.layer.origin[i]),
            direction = glm::normalize(glm::dvec3(lit.layer.direction[i]));
        glm::dvec3 sum(0), depth(0);
        constexpr int steps = 4000;
        const double step = 10.0 / steps;
        for (int k = 0; k < steps; ++k) {
            const glm::dvec3 p = origin + (k + 0.5) * step * direction;
            const glm::dvec3 sigma = media.density(1, p, false) * cloud.extinction;
            depth += 0.5 * step * sigma;
            const double r = lamp ? glm::length(*lamp - p) : far;
            const glm::dvec3 to_light = lamp ? (*lamp - p) / r : -light.direction;
            const glm::dvec3 way = media.optical_depth(p, to_light, r, false);
            sum += step * sigma * cloud.albedo * glm::exp(-depth - way) / (lamp ? r * r : 1);
            depth += 0.5 * step * sigma;
        }
        sum *= 0.25 / kPi * light.irradiance;
        for (int c = 0; c < 3; ++c)
            worst = std::max(worst, std::abs(static_cast<double>(found[i][c]) / sum[c] - 1));
    }
    return worst;
}

TEST(VolumetricLight, OfTheSunInACloudIsFineQuadrature) {
    const double worst = worst_in_cloud(21);
    printf("cloud in the sun: off by %.1e\n", worst);
    // An optical depth of up to 3, linear between points half a voxel apart: bent by its density's ripples,
    // seven voxels long, it is off by up to (2 pi / 7)^2 / 32 of them, 0.01.
    EXPECT_LT(worst, 0.01);
}

TEST(VolumetricLight, OfALampInACloudIsFineQuadrature) {
    for (const auto& [where, lamp] :
         {std::pair("beside", glm::dvec3(-2, 4, 1)), std::pair("in", glm::dvec3(0.3, 3.2, -0.2))}) {
        const double worst = worst_in_cloud(21, lamp);
        printf("lamp %s a cloud: off by %.1e\n", where, worst);
        // Of places between which the optical depth (up to 3) is taken as linear a part may leave 0.01 / 6,
        // and few come near it; the rule along the segment is off by 0.006, whatever their number.
        EXPECT_LT(worst, 0.01);
    }
}

TEST(VolumetricLight, OfTheSunInAWideGridIsFineQuadrature) {
    const double worst = worst_in_cloud(20000);
    printf("cloud in the sun, of a wide grid: off by %.1e\n", worst);
    // The same as for lamps.
    EXPECT_LT(worst, 0.01);
}

TEST(VolumetricLight, OfASpotIsSeenThroughItsPicture) {
    LitSegments lit = lamp_in_water({4, -2, -2});
    scene::Light& spot = lit.scene.state.lights[0];
    spot = test::spot({4, -2, -2}, {4, -3, -1});
    lit.scene.light_textures = {test::checkers(64, 8)};
    lit.add({0, -4, -0.5}, {1, 0.1, 0.2}, 8, true);         // across the cone
    lit.add({4.3, -8, 3}, {0, 1, -0.8}, 9, true);           // towards the lamp
    lit.add({3.6, -2.4, -1.7}, {0.1, -0.6, 0.7}, 5, true);  // away from it
    lit.add({0, -14, 10}, {1, 0.02, 0}, 20, true);          // many texels a metre
    const std::vector<glm::vec3> found = lit.light();
    const light::SpotPicture picture(lit.scene, 0);
    const scene::Water& water = *lit.scene.state.water;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const glm::dvec3 origin = glm::dvec3(lit.layer.origin[i]) + lit.scene.origin;
        const glm::dvec3 direction = glm::normalize(glm::dvec3(lit.layer.direction[i]));
        constexpr int steps = 20000;
        const double step = static_cast<double>(lit.layer.length[i]) / steps;
        double sum = 0, plain = 0;
        for (int k = 0; k < steps; ++k) {
            const double s = (k + 0.5) * step;
            const glm::dvec3 way = origin + s * direction - spot.position;
            const double r = glm::length(way);
            const double falloff =
                optics::f64::spot_light_falloff(dot(way, spot.direction) / r, std::cos(spot.cone_angle),
                                                std::cos(spot.cone_angle - spot.falloff_angle));
            const double light = step * water.scattering.g / (4 * kPi) * spot.intensity.g * falloff *
                                 std::exp(-water.extinction().g * (s + r)) / (r * r);
            plain += light;
            sum += light * picture.towards(way).g;
        }
        printf("segment %zu: %.4f of the light passes; error %.1e of it\n", i, sum / plain,
               found[i].g / sum - 1);
        // The picture is halved and doubled within stretches over which the rest is even to a few percent,
        // and the cone's edge within one is met by four points.
        EXPECT_NEAR(found[i].g, sum, 0.02 * sum) << i;
    }
}

}  // namespace
}  // namespace dapple
