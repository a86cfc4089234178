// What rasterised beams send to pixels, from beams made by the test: closed forms, both volumes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "methods/adaptive_beams/low_pass.h"
#include "methods/draw_beams.h"
#include "methods/drawn_sheets.h"
#include "view/camera.h"
#include "view/camera_paths.h"

namespace dapple {
namespace {

using methods::adaptive_beams::BeamSet;
using methods::adaptive_beams::BeamSums;
using methods::adaptive_beams::Shading;
using methods::adaptive_beams::VolumeKind;

using test::draw;
using test::Drawn;
using test::flat_scene;
using test::kFloor;
using test::wavy_scene;

constexpr double kIndex = 1.333;

/// Whether a pixel's whole part of its receiver is lit.
template <class Lit>
bool all_lit(const view::ReceiverLayer& layer, std::size_t i, const Lit& lit) {
    for (const double u : {-0.5, 0.5})
        for (const double v : {-0.5, 0.5})
            if (!lit(glm::dvec3(layer.position[i]) + u * glm::dvec3(layer.footprint_u[i]) +
                     v * glm::dvec3(layer.footprint_v[i])))
                return false;
    return true;
}

class Flat : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(SunFromZenith, Flat, testing::Values(0.0, 30.0, 60.0, 80.0),
                         [](const auto& sun) { return std::to_string(static_cast<int>(sun.param)) + "deg"; });

TEST_P(Flat, ScatteredLightAndIrradianceHaveTheClosedForm) {
    scene::FrameScene scene = flat_scene(GetParam(), 40);
    const rays::RayScene rays(scene);
    const std::vector<BeamSet> sets = test::drawn_sheets(scene, rays, kFloor);
    const double cos_t = std::cos(std::asin(std::sin(glm::radians(GetParam())) / kIndex));
    const double shift = std::sqrt(1 - cos_t * cos_t) / cos_t;
    const test::FlatFloor surface = test::flat_floor(GetParam(), 1, kIndex);
    const glm::dvec3 extinction = scene.state.water->extinction();
    // Level, downwards, obliquely up and down, and along the sun's rays; where all is lit.
    const std::pair<glm::dvec3, glm::dvec3> views[] = {
        {{0, -1, 0}, {1, 0, 0.3}},      {{0.3, -0.5, 0.1}, {0, -1, 0}}, {{0, -0.8, 0.2}, {0.5, -0.5, -0.7}},
        {{0, -2, 0}, {-0.6, 0.4, 0.3}}, {{0, -2.5, 0}, {-shift, 1, 0}}, {{0, -0.4, 0}, {shift, -1, 0}}};
    double worst = 0, worst_e = 0;
    std::size_t tested_e = 0;
    for (const auto& [place, towards] : views) {
        for (const bool orthographic : {false, true}) {
            scene.state.camera.position = place + glm::dvec3(shift * -place.y, 0, 0);
            scene.state.camera.target = scene.state.camera.position + towards;
            scene.state.camera.up = std::abs(towards.y) > 0.99 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
            scene.state.camera.projection =
                orthographic ? scene::Projection::orthographic : scene::Projection::perspective;
            scene.state.camera.view_height = 0.5;
            const Drawn drawn = draw(scene, sets);
            std::size_t tested = 0;
            for (std::size_t i = 0; i < drawn.receivers.pixels(); ++i) {
                for (std::uint32_t k = drawn.segments.first[i]; k < drawn.segments.first[i + 1]; ++k) {
                    if (!drawn.segments.primary[k] || !drawn.segments.in_water[k]) continue;
                    const glm::dvec3 origin(drawn.segments.origin[k]), direction(drawn.segments.direction[k]);
                    const double length = drawn.segments.length[k];
                    const auto lit = [&](glm::dvec3 p) {
                        return std::abs(p.x + shift * p.y) < 11.9 && std::abs(p.z) < 9.9;
                    };
                    if (!lit(origin) || !lit(origin + length * direction)) continue;
                    ++tested;
                    for (int c = 0; c < 3; ++c) {
                        const double a = extinction[c] * (1 - direction.y / cos_t);
                        const double way =
                            std::abs(a * length) > 1e-12 ? -std::expm1(-a * length) / a : length;
                        const double expected = scene.state.water->scattering[c] * 0.25 / glm::pi<double>() *
                                                scene.state.lights[0].irradiance[c] * surface.irradiance /
                                                cos_t * std::exp(extinction[c] * origin.y / cos_t) * way;
                        const double value = drawn.sums.scattered[i][c];
                        const double error = std::abs(value / expected - 1);
                        if (error > 2e-3 && worst < error)
                            printf("  pixel %zu, orthographic %d, towards %g, %g: %g of %g\n", i,
                                   orthographic, towards.x, towards.y, value, expected);
                        worst = std::max(worst, error);
                        if ((drawn.receivers.flags[i] & (view::kReceiver | view::kBehindSpecular)) !=
                                view::kReceiver ||
                            !all_lit(drawn.receivers, i, lit))
                            continue;
                        ++tested_e;
                        const double e = scene.state.lights[0].irradiance[c] * surface.irradiance *
                                         std::exp(-extinction[c] * kFloor / cos_t);
                        worst_e = std::max(
                            worst_e, std::abs(static_cast<double>(drawn.sums.irradiance[i][c]) / e - 1));
                    }
                }
            }
            // Level parallel rays leave what is lit.
            if (orthographic && towards.y == 0) continue;
            EXPECT_GT(tested, 100u) << towards.x << " " << towards.y << " " << orthographic;
        }
    }
    printf("sun %2.0f deg from the zenith: S off by %.1e, E by %.1e\n", GetParam(), worst, worst_e);
    // Three nodes for e^-x over an optical depth of 1 at most; places are rounded to 1e-6 m, the device's
    // exp.
    EXPECT_LT(worst, 1e-4);
    EXPECT_GT(tested_e, 1000u);
    EXPECT_LT(worst_e, 2e-5);
}

TEST(HugeExtinction, HasTheClosedForm) {
    // Just below the surface, where light still is, on ways that it lights to their end; channels that are
    // dimmed alike, and by a thousand to one.
    scene::FrameScene scene = flat_scene(30, 40);
    scene.state.camera.field_of_view = 6 * scene::kDegree;
    const double cos_t = std::cos(std::asin(0.5 / kIndex));
    const test::FlatFloor surface = test::flat_floor(30, 1, kIndex);
    const rays::RayScene rays(scene);
    const std::vector<BeamSet> sets = test::drawn_sheets(scene, rays, kFloor);
    for (const glm::dvec3 extinction : {glm::dvec3(100), glm::dvec3(1000), glm::dvec3(1000, 30, 1)}) {
        scene.state.water->absorption = 0.5 * extinction;
        scene.state.water->scattering = 0.5 * extinction;
        const double deep = 1 / std::max({extinction.x, extinction.y, extinction.z});
        for (const glm::dvec3 towards : {glm::dvec3(0.9, -0.4, 0.3), glm::dvec3(-0.3, -0.5, -0.2)}) {
            scene.state.camera.position = {0, -deep, 0};
            scene.state.camera.target = scene.state.camera.position + towards;
            const Drawn drawn = draw(scene, sets);
            double worst = 0;
            std::size_t tested = 0;
            for (std::size_t i = 0; i < drawn.receivers.pixels(); ++i) {
                for (std::uint32_t k = drawn.segments.first[i]; k < drawn.segments.first[i + 1]; ++k) {
                    if (!drawn.segments.primary[k] || !drawn.segments.in_water[k]) continue;
                    const glm::dvec3 origin(drawn.segments.origin[k]), direction(drawn.segments.direction[k]);
                    const double length = drawn.segments.length[k];
                    ++tested;
                    for (int c = 0; c < 3; ++c) {
                        const double a = extinction[c] * (1 - direction.y / cos_t);
                        const double expected = scene.state.water->scattering[c] * 0.25 / glm::pi<double>() *
                                                scene.state.lights[0].irradiance[c] * surface.irradiance /
                                                cos_t * std::exp(extinction[c] * origin.y / cos_t) *
                                                -std::expm1(-a * length) / a;
                        const double value = drawn.sums.scattered[i][c];
                        worst = std::max(worst, std::abs(value / expected - 1));
                    }
                }
            }
            printf("extinction %g %g %g, towards %g %g: S off by %.1e\n", extinction.x, extinction.y,
                   extinction.z, towards.x, towards.y, worst);
            EXPECT_EQ(tested, drawn.receivers.pixels());
            // The aim; places are rounded to 1e-6 m, a thousandth of the shortest way that dims.
            EXPECT_LT(worst, 0.01);
        }
    }
}

TEST(Volumes, GiveEqualPicturesAndSixTrianglesHaveFewerFragments) {
    for (const double amplitude : {0.004, 0.02}) {
        const scene::FrameScene scene = wavy_scene(40, amplitude);
        const rays::RayScene rays(scene);
        const std::vector<BeamSet> sets = test::drawn_sheets(scene, rays, kFloor);
        const Drawn prism = draw(scene, sets, VolumeKind::prism);
        const Drawn six = draw(scene, sets, VolumeKind::six_triangles);
        double worst = 0, dark = 0;
        for (std::size_t i = 0; i < six.receivers.pixels(); ++i) {
            worst = std::max(worst, glm::length(glm::dvec3(six.sums.scattered[i] - prism.sums.scattered[i])) /
                                        glm::length(glm::dvec3(prism.sums.scattered[i])));
            worst =
                std::max(worst, glm::length(glm::dvec3(six.sums.irradiance[i] - prism.sums.irradiance[i])) /
                                    (1e-3 + glm::length(glm::dvec3(prism.sums.irradiance[i]))));
            dark += prism.sums.scattered[i].g > 0 ? 0 : 1;
        }
        const double fragments[] = {prism.stats.counted("beam fragments"),
                                    six.stats.counted("beam fragments")};
        printf(
            "waves of %g m: %.0f beams, %.3e fragments of prisms, %.3e of six triangles (%.0f prisms left), "
            "%.1e apart\n",
            amplitude, six.stats.counted("beams drawn"), fragments[0], fragments[1],
            six.stats.counted("beams in a prism"), worst);
        EXPECT_EQ(dark, 0);
        EXPECT_LT(fragments[1], fragments[0]);
        // Fragments outside the beam add nothing: pictures differ by nothing but what rounding leaves at
        // edges.
        EXPECT_LT(worst, 1e-4);
    }
}

TEST(Paper, HasTheSameSumsUnderFlatWater) {
    scene::FrameScene scene = flat_scene(30, 40);
    scene.state.camera.position = {0, -0.8, 0.2};
    scene.state.camera.target = {0.5, -1.3, -0.5};
    const rays::RayScene rays(scene);
    const std::vector<BeamSet> sets = test::drawn_sheets(scene, rays, kFloor);
    const Drawn exact = draw(scene, sets),
                paper = draw(scene, sets, VolumeKind::six_triangles, Shading::paper);
    glm::dvec3 s[2] = {}, e[2] = {};
    for (std::size_t i = 0; i < exact.receivers.pixels(); ++i) {
        s[0] += exact.sums.scattered[i];
        s[1] += paper.sums.scattered[i];
        e[0] += exact.sums.irradiance[i];
        e[1] += paper.sums.irradiance[i];
    }
    const glm::dvec3 s_error = glm::abs(s[1] / s[0] - 1.0), e_error = glm::abs(e[1] / e[0] - 1.0);
    printf("as in the paper: S off by %.1e, E by %.1e\n", std::max({s_error.x, s_error.y, s_error.z}),
           std::max({e_error.x, e_error.y, e_error.z}));
    // Parallel beams have exact scan planes; the one sample in the middle is off by (dimming of a beam)^2
    // / 24.
    EXPECT_LT(std::max({s_error.x, s_error.y, s_error.z}), 0.01);
    EXPECT_LT(std::max({e_error.x, e_error.y, e_error.z}), 0.002);
}

TEST(LowPass, BlursByItsDeviationAmongThePixelsThatHaveLight) {
    constexpr int kWidth = 41, kHeight = 35;
    std::vector<glm::vec3> picture(kWidth * kHeight, glm::vec3(2));
    std::vector<std::uint8_t> covered(picture.size(), 1);
    for (std::size_t i = 0; i < picture.size(); i += 3) covered[i] = 0;
    methods::adaptive_beams::low_pass(picture, covered, kWidth, 2.5);
    // What is even stays even, up to the picture's edges and beside what has no light.
    for (const glm::vec3& value : picture) EXPECT_NEAR(value.g, 2, 1e-5);
    // A point becomes a Gaussian: its variance along both axes, and all of its light.
    std::fill(picture.begin(), picture.end(), glm::vec3(0));
    std::fill(covered.begin(), covered.end(), std::uint8_t{1});
    picture[17 * kWidth + 20] = {0, 1, 0};
    methods::adaptive_beams::low_pass(picture, covered, kWidth, 2.5);
    double sum = 0, x2 = 0, y2 = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double value = picture[static_cast<std::size_t>(y * kWidth + x)].g;
            sum += value;
            x2 += value * (x - 20) * (x - 20);
            y2 += value * (y - 17) * (y - 17);
        }
    // Cut at four deviations: 6e-5 of the light and 1e-3 of the variance lie beyond.
    EXPECT_NEAR(sum, 1, 2e-4);
    EXPECT_NEAR(x2 / sum, 6.25, 0.02);
    EXPECT_NEAR(y2 / sum, 6.25, 0.02);
}

TEST(LowPass, IsOfThePapersSurfaceTermAlone) {
    scene::FrameScene scene = wavy_scene(40, 0.02);
    scene.state.camera.target = scene.state.camera.position + glm::dvec3(0.6, -1, 0.1);
    const rays::RayScene rays(scene);
    const std::vector<BeamSet> sets = test::drawn_sheets(scene, rays, kFloor);
    const auto drawn = [&](Shading shading, double deviation) {
        scene.state.caustics.adaptive_beams.paper_low_pass = deviation;
        return draw(scene, sets, VolumeKind::six_triangles, shading).sums;
    };
    const auto variance = [](const std::vector<glm::vec3>& values) {
        double sum = 0, squares = 0;
        for (const glm::vec3& value : values) {
            sum += static_cast<double>(value.g);
            squares += static_cast<double>(value.g) * static_cast<double>(value.g);
        }
        return squares / sum / sum * static_cast<double>(values.size()) - 1;
    };
    const BeamSums sharp = drawn(Shading::paper, 0), blurred = drawn(Shading::paper, 1.5);
    EXPECT_EQ(blurred.scattered, sharp.scattered);
    EXPECT_GT(variance(sharp.irradiance), 0.01);
    EXPECT_LT(variance(blurred.irradiance), 0.7 * variance(sharp.irradiance));
    EXPECT_EQ(drawn(Shading::exact, 1.5).irradiance, drawn(Shading::exact, 0).irradiance);
}

TEST(Focus, SendsItsFluxOn) {
    scene::FrameScene scene = flat_scene(0, 4);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene.state.clip.width = scene.state.clip.height = 128;
    scene.state.camera.projection = scene::Projection::orthographic;
    scene.state.camera.up = {0, 0, -1};
    for (const double depth : {0.5, 1.3, 3.0}) {
        scene.state.objects[0] = test::level_plane("floor", -depth, 100);
        scene.state.camera.position = {0, -depth + 0.05, 0};
        scene.state.camera.target = {0, -depth, 0};
        // The light is 0.4 m wide at the surface, |1 - depth| times that in x on the floor and |1 - depth /
        // 2| in z.
        scene.state.camera.view_height = 0.5 * std::max(std::abs(1 - depth), std::abs(1 - 0.5 * depth));
        const Drawn drawn = draw(scene, {test::lens_of_beams(0.5f)});
        EXPECT_GT(drawn.stats.counted("beams with turning areas"), 0);
        double flux = 0;
        for (const glm::vec3& e : drawn.sums.irradiance) flux += static_cast<double>(e.g);
        const double pixel = scene.state.camera.view_height / scene.state.clip.height;
        flux *= pixel * pixel;
        printf("floor at %.1f m: %.3f W of 32\n", depth, flux);
        // Pixels have means over their parts that are lit; the rest is rounding of areas, of triangles that
        // are wider than a pixel.
        EXPECT_NEAR(flux, 32, 1e-5 * 32);
    }
}

TEST(Focus, LightsAFloorNearItEvenly) {
    scene::FrameScene scene = flat_scene(0, 4);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene.state.camera.projection = scene::Projection::orthographic;
    scene.state.camera.up = {0, 0, -1};
    for (const double offset : {-0.02, -0.001, 0.001, 0.02}) {
        scene.state.objects[0] = test::level_plane("floor", -1 - offset, 100);
        scene.state.camera.position = {0, -0.9 - offset, 0};
        scene.state.camera.target = {0, -1 - offset, 0};
        // All pixels are lit.
        const double width = 0.4 * std::abs(offset);
        scene.state.camera.view_height = 0.7 * width;
        const Drawn drawn = draw(scene, {test::lens_of_beams(1, 0, 200)});
        double worst = 0;
        for (const glm::vec3& e : drawn.sums.irradiance)
            worst = std::max(worst, std::abs(static_cast<double>(e.g) * width * width / 32 - 1));
        printf("%g m from the focus: E off by %.1e\n", offset, worst);
        // The floor's depth is rounded to 6e-8 m, and E goes with the square of its distance from the focus.
        EXPECT_LT(worst, 2e-7 / std::abs(offset) + 1e-5);
    }
}

TEST(Focus, HasNoLightBeforeTheSurfaceThatItsBeamsLeave) {
    // They are 60 m wide at their ends.
    scene::FrameScene scene = flat_scene(0, 4);
    scene.state.camera.projection = scene::Projection::orthographic;
    scene.state.camera.position = {-1, -0.25, 0};
    scene.state.camera.target = {0, -0.25, 0};
    scene.state.camera.view_height = 0.4;
    const Drawn drawn = draw(scene, {test::lens_of_beams(1, 0.5f, 200)});
    for (const glm::vec3& s : drawn.sums.scattered) ASSERT_EQ(s.g, 0);
}

/// Integral of 1 / (4 pi) times the density of flux of test::lens_of_beams(1) along a ray: a pyramid whose
/// tip is 1 m deep, and its mirror image. In steps that grow with the distance from the tip.
double through_pyramids(glm::dvec3 origin, glm::dvec3 direction, double length) {
    origin.y += 1;
    const double nearest = -glm::dot(origin, direction), miss = glm::length(origin + nearest * direction);
    const double first = std::asinh(-nearest / miss), last = std::asinh((length - nearest) / miss);
    constexpr int kSteps = 4000;
    const double step = (last - first) / kSteps;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double s = first + (i + 0.5) * step;
        const glm::dvec3 p = origin + (nearest + miss * std::sinh(s)) * direction;
        const double half = 0.2 * std::abs(p.y);
        if (std::max(std::abs(p.x), std::abs(p.z)) < half)
            sum += miss * std::cosh(s) * step * 32 / (4 * half * half) * glm::length(p) / std::abs(p.y);
    }
    return sum / (4 * glm::pi<double>());
}

constexpr double kThin = 1e-5;  // 1/m: takes away nothing that can be seen

/// S of beams of 200 m that meet in a point, in a scene that scatters kThin alike in all directions.
void expect_all_flux_about_a_focus(scene::FrameScene scene) {
    scene.state.objects = {test::level_plane("floor", -3, 400)};
    scene.state.clip.width = scene.state.clip.height = 8;
    scene.state.camera.projection = scene::Projection::orthographic;
    for (const glm::dvec3 towards : {glm::dvec3(1, 0, 0.1), glm::dvec3(0.7, -1, 0.3),
                                     glm::dvec3(0.08, -1, 0.04), glm::dvec3(0, -1, 0)}) {
        scene.state.camera.up = towards.y == 0 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
        for (const double size : {0.2, 0.02, 0.002}) {
            // No pixel looks right into the focus. Places are rounded to 1e-7 m: about it, in 1e-4 m, to a
            // thousandth.
            scene.state.camera.target = {0.0013 * size, -1 + 0.0031 * size, 0.0027 * size};
            scene.state.camera.position = scene.state.camera.target - 0.9 * glm::normalize(towards);
            scene.state.camera.view_height = size;
            const Drawn drawn = draw(scene, {test::lens_of_beams(1, 0, 200)});
            const view::Camera camera(scene.state.camera, scene.state.clip.width, scene.state.clip.height);
            double found = 0, expected = 0;
            for (std::size_t i = 0; i < drawn.receivers.pixels(); ++i) {
                glm::dvec3 origin, direction;
                camera.ray(glm::dvec2(i % 8, i / 8) + 0.5, origin, direction);
                const auto length = static_cast<double>(drawn.segments.length[i]);
                found += static_cast<double>(drawn.sums.scattered[i].g);
                expected += kThin * through_pyramids(origin, direction, std::min(length, 40.0));
            }
            printf("%g %g %g, %g m: %.4f of the flux\n", towards.x, towards.y, towards.z, size,
                   found / expected);
            EXPECT_NEAR(found, expected, 0.01 * expected);
        }
    }
}

TEST(Focus, ScattersItsFluxAlsoInLongBeams) {
    scene::FrameScene scene = flat_scene(0, 4);
    scene.state.water->absorption = glm::dvec3(0);
    scene.state.water->scattering = glm::dvec3(kThin);
    scene.state.water->phase.type = scene::PhaseType::isotropic;
    expect_all_flux_about_a_focus(scene);
}

TEST(Focus, ScattersItsFluxAlsoAmongBoundedMedia) {
    scene::FrameScene scene = flat_scene(0, 4);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene::Medium& box = scene.state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.size = glm::dvec3(100);
    box.extinction = glm::dvec3(kThin);
    box.albedo = glm::dvec3(1);
    box.phase.type = scene::PhaseType::isotropic;
    expect_all_flux_about_a_focus(scene);
}

TEST(Phase, IsTheSameFromATable) {
    scene::FrameScene scene = wavy_scene(20, 0.004);
    const rays::RayScene rays(scene);
    const std::vector<BeamSet> sets = test::drawn_sheets(scene, rays, kFloor);
    const Drawn lobes = draw(scene, sets);
    // The same function, every half degree.
    scene::PhaseFunction& phase = scene.state.water->phase;
    phase.type = scene::PhaseType::table;
    for (int i = 0; i <= 360; ++i) {
        const double angle = 0.5 * i * scene::kDegree, g = phase.anisotropy;
        phase.samples.push_back({angle, (1 - g * g) / std::pow(1 + g * g - 2 * g * std::cos(angle), 1.5)});
    }
    const Drawn table = draw(scene, sets);
    double worst = 0;
    for (std::size_t i = 0; i < lobes.receivers.pixels(); ++i) {
        ASSERT_GT(lobes.sums.scattered[i].g, 0);
        worst = std::max(worst, std::abs(static_cast<double>(table.sums.scattered[i].g) /
                                             static_cast<double>(lobes.sums.scattered[i].g) -
                                         1));
    }
    printf("phase function from a table: S off by %.1e\n", worst);
    // Linear between values: (half a degree)^2 / 8 p'' / p.
    EXPECT_LT(worst, 1e-3);
}

TEST(Parts, OfASetGiveTheSamePicture) {
    scene::FrameScene scene = flat_scene(0, 4);
    scene.state.camera.position = {0.3, -1, 0.9};
    scene.state.camera.target = {0, -1.6, 0};
    const std::vector<BeamSet> sets{test::lens_of_beams(0.5f)};
    const Drawn whole = draw(scene, sets);
    EXPECT_EQ(whole.stats.counted("beams with turning areas"), 32);
    // Five beams, or those with 50 areas.
    const Drawn parts = draw(scene, sets, VolumeKind::six_triangles, Shading::exact, 1000);
    double sum = 0;
    for (std::size_t i = 0; i < whole.receivers.pixels(); ++i) {
        // Sums of the same in another order.
        EXPECT_NEAR(parts.sums.scattered[i].g, whole.sums.scattered[i].g, 1e-5);
        EXPECT_NEAR(parts.sums.irradiance[i].g, whole.sums.irradiance[i].g, 1e-4);
        sum += static_cast<double>(whole.sums.scattered[i].g);
    }
    EXPECT_GT(sum, 0);
    EXPECT_EQ(parts.stats.counted("beam fragments"), whole.stats.counted("beam fragments"));
}

TEST(HardCases, AreFinite) {
    // The camera looks through a focus, and along the axis.
    const std::vector<BeamSet> sets{test::lens_of_beams(1)};
    scene::FrameScene scene = flat_scene(0, 4);
    scene.state.clip.width = scene.state.clip.height = 33;  // the middle pixel looks through the focus
    for (const double scattering : {0.0, 0.3, 1e5}) {
        scene.state.water->scattering = glm::dvec3(scattering);
        for (const glm::dvec3 place : {glm::dvec3(-1, -1, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, -2.9, 0),
                                       glm::dvec3(0, -1, 0), glm::dvec3(0, -1e-7, 0.2)}) {
            scene.state.camera.position = place;
            scene.state.camera.target =
                place == glm::dvec3(0, -1, 0) ? glm::dvec3(0, -3, 0) : glm::dvec3(0, -1, 0);
            for (const Shading shading : {Shading::exact, Shading::paper}) {
                const Drawn drawn = draw(scene, sets, VolumeKind::six_triangles, shading);
                double sum = 0;
                for (std::size_t i = 0; i < drawn.receivers.pixels(); ++i) {
                    const glm::vec3 all = drawn.sums.scattered[i] + drawn.sums.irradiance[i];
                    ASSERT_TRUE(std::isfinite(all.x) && std::isfinite(all.y) && std::isfinite(all.z))
                        << scattering << " at " << place.x << ' ' << place.y << ' ' << place.z << " pixel "
                        << i;
                    ASSERT_GE(std::min({all.x, all.y, all.z}), 0);
                    sum += static_cast<double>(all.g);
                }
                if (scattering == 0.3 && place.y < -0.5) {
                    EXPECT_GT(sum, 0);
                }
            }
        }
    }
}

}  // namespace
}  // namespace dapple
