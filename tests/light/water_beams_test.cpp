#include "light/water_beams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/parallel.h"
#include "light/beam_checks.h"

namespace dapple {
namespace {

using namespace test;

template <class Real>
void expect_flat_water(double tolerance) {
    for (const double zenith : {0.0, 30.0, 60.0, 80.0, 89.0}) {
        SCOPED_TRACE(zenith);
        scene::FrameScene scene = water_scene({7, 3}, {1.3, -2.1});
        scene.origin = {2, -3, 5};
        scene.state.lights = {sun(zenith)};
        scene.state.lights[0].irradiance = {3, 2, 1};
        add_water(scene, {}, 40, 20);
        const double i = glm::radians(zenith), t = std::asin(std::sin(i) / kIndex),
                     r = reflectance(i, kIndex);
        const glm::dvec2 heading(-std::cos(glm::radians(20.0)), -std::sin(glm::radians(20.0)));
        for (const Event event : {Event::transmission, Event::reflection}) {
            const auto sheets = beams<Real>(scene, event);
            ASSERT_EQ(sheets.size(), 1u);
            const BeamSheet<Real>& sheet = sheets[0];
            const bool transmission = event == Event::transmission;
            const double out = transmission ? t : i;
            const glm::dvec3 expected(heading.x * std::sin(out), std::cos(out) * (transmission ? -1 : 1),
                                      heading.y * std::sin(out));
            EXPECT_EQ(sheet.rows, 21);
            EXPECT_EQ(sheet.columns, 41);
            EXPECT_EQ(sheet.color, glm::dvec3(3, 2, 1));
            EXPECT_EQ(sheet.in_water(), transmission);
            EXPECT_NEAR(glm::determinant(sheet.world_from_mesh), 1, 1e-14);
            EXPECT_NEAR(glm::length(sheet.world_from_mesh[2] - expected), 0, 1e-14);
            ASSERT_EQ(sheet.flux.size(), scene.water->mesh.triangles.size());
            for (std::size_t v = 0; v < sheet.rays.size(); ++v) {
                ASSERT_EQ(sheet.valid[v], 1);
                ASSERT_NEAR(glm::length(direction(sheet, v) - expected), 0, tolerance);
                // Ten metres from the origin: so much more round-off.
                ASSERT_NEAR(glm::length(foot(scene, sheet, v) - scene.water->mesh.positions[v]), 0,
                            10 * tolerance);
            }
            EXPECT_NEAR(flux(sheets) / (21 * std::cos(i) * (transmission ? 1 - r : r)), 1, tolerance);
            EXPECT_EQ(sheet.losses.wave_shadow, 0);
            EXPECT_EQ(sheet.losses.second_crossing, 0);
        }
    }
}

// Round-off of a few operations; at 89 degrees cos(i) = 0.017 by std::cos has 6e-15 of its own.
TEST(WaterBeams, FlatWaterFollowsSnellAndFresnelInDouble) {
    expect_flat_water<double>(2e-13);
}
TEST(WaterBeams, FlatWaterFollowsSnellAndFresnelInFloat) {
    expect_flat_water<float>(2e-7);
}

TEST(WaterBeams, TransmittedAndReflectedFluxSumToWhatMeetsAWavySea) {
    scene::FrameScene scene = water_scene({6, 6});
    scene.state.lights = {sun(40)};
    add_water(scene, gentle_sea(), 100, 100);
    const double sum =
        flux(beams<double>(scene, Event::transmission)) + flux(beams<double>(scene, Event::reflection));
    EXPECT_NEAR(sum / met_by_sun(scene), 1, 1e-12);  // 2e4 triangles, round-off of the sum
}

TEST(WaterBeams, SunsFarBelowADegreeMeetFlatWaterWithoutLoss) {
    scene::FrameScene scene = water_scene({4, 4});
    add_water(scene, {}, 20, 20);
    for (const double elevation : {1e-4, 0.01, 0.1}) {
        scene.state.lights = {sun(90 - elevation)};
        for (const Event event : {Event::transmission, Event::reflection}) {
            const auto sheets = beams<float>(scene, event);
            ASSERT_EQ(sheets.size(), 1u);
            expect_sound(sheets);
            EXPECT_EQ(flux_and_losses(sheets), flux(sheets));
            EXPECT_EQ(std::count(sheets[0].valid.begin(), sheets[0].valid.end(), 1), 441);
        }
    }
}

/// Solid angle of the rectangle [x0, x1] x [z0, z1] in the plane y = 0 from `from`.
double rectangle_solid_angle(glm::dvec2 lower, glm::dvec2 upper, glm::dvec3 from) {
    const double h = std::abs(from.y);
    const auto corner = [&](double x, double z) {
        x -= from.x;
        z -= from.z;
        return std::atan(x * z / (h * std::sqrt(x * x + z * z + h * h)));
    };
    return corner(upper.x, upper.y) - corner(lower.x, upper.y) - corner(upper.x, lower.y) +
           corner(lower.x, lower.y);
}

scene::FrameScene lamp_scene(glm::dvec2 size, int cells, glm::dvec3 position) {
    scene::FrameScene scene = water_scene(size);
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = position;
    scene.state.lights = {lamp};
    add_water(scene, {}, cells, cells);
    return scene;
}

TEST(WaterBeams, APointLightSendsTheSolidAngleOfTheWater) {
    for (const glm::dvec3 position : {glm::dvec3(0, 2, 0), {1.3, 0.7, -0.4}, {30, 4, 9}, {0.5, 300, 0}}) {
        SCOPED_TRACE(position.y);
        const scene::FrameScene scene = lamp_scene({6, 4}, 40, position);
        const auto through = beams<double>(scene, Event::transmission);
        const auto mirrored = beams<double>(scene, Event::reflection);
        const double sum = flux_and_losses(through) + flux_and_losses(mirrored);
        // The closed form is a difference of four angles near pi / 2 and loses 1e-16 / its value.
        const double expected = rectangle_solid_angle({-3, -2}, {3, 2}, position);
        EXPECT_NEAR(sum / expected, 1, 1e-12 + 1e-15 / expected);
        ASSERT_EQ(through.size(), 1u);
        EXPECT_EQ(through[0].world_from_mesh[2], glm::dvec3(0, -1, 0));
        for (std::size_t v = 0; v < through[0].rays.size(); ++v) {
            const glm::dvec3 way = glm::normalize(scene.water->mesh.positions[v] - position);
            const glm::dvec3 out = direction(through[0], v);
            // Snell: the horizontal part of the direction shrinks by the index.
            ASSERT_NEAR(out.x, way.x / kIndex, 1e-14);
            ASSERT_NEAR(out.z, way.z / kIndex, 1e-14);
        }
    }
}

TEST(WaterBeams, ASpotIsAPointLightInsideItsConeAndNothingOutside) {
    scene::FrameScene scene = lamp_scene({4, 4}, 64, {0, 2, 0});
    const auto point = beams<double>(scene, Event::transmission);
    scene.state.lights[0].type = scene::LightType::spot;
    scene.state.lights[0].cone_angle = 0.5;
    scene.state.lights[0].falloff_angle = 0.1;
    const auto spot = beams<double>(scene, Event::transmission);
    for (std::size_t t = 0; t < spot[0].flux.size(); ++t) {
        double least = HUGE_VAL, most = 0;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 p = scene.water->mesh.positions[scene.water->mesh.triangles[t][k]];
            least = std::min(least, std::atan(std::hypot(p.x, p.z) / 2));
            most = std::max(most, std::atan(std::hypot(p.x, p.z) / 2));
        }
        if (most < 0.4) {
            ASSERT_EQ(spot[0].flux[t], point[0].flux[t]);
        } else if (least > 0.5) {
            ASSERT_EQ(spot[0].flux[t], 0);
        } else {
            ASSERT_LT(spot[0].flux[t], point[0].flux[t]);
        }
    }
}

TEST(WaterBeams, LightFromALowLampIsMirroredIntoSheetsToAllSides) {
    const glm::dvec3 position(0.3, 0.1, -0.2);
    const scene::FrameScene scene = lamp_scene({8, 8}, 80, position);
    const auto sheets = beams<double>(scene, Event::reflection);
    ASSERT_EQ(sheets.size(), 5u);  // up, and one to each side of the lamp
    expect_sound(sheets);
    EXPECT_EQ(sheets[1].name, "lamp > water:R +x");
    for (std::size_t t = 0; t < sheets[0].flux.size(); ++t) {
        int carriers = 0;
        for (const auto& sheet : sheets) {
            if (!(sheet.flux[t] > 0)) continue;
            ++carriers;
            for (int k = 0; k < 3; ++k) {
                const std::size_t v = scene.water->mesh.triangles[t][k];
                ASSERT_EQ(sheet.valid[v], 1);
                const glm::dvec3 way = glm::normalize(scene.water->mesh.positions[v] - position);
                ASSERT_NEAR(glm::length(direction(sheet, v) - way * glm::dvec3(1, -1, 1)), 0, 1e-13);
                ASSERT_NEAR(glm::length(foot(scene, sheet, v) - scene.water->mesh.positions[v]), 0, 1e-13);
            }
        }
        ASSERT_LE(carriers, 1);
    }
    EXPECT_EQ(sheets[0].losses.outside_cone, 0);
    const double expected = rectangle_solid_angle({-4, -4}, {4, 4}, position);
    EXPECT_NEAR((flux(sheets) + flux(beams<double>(scene, Event::transmission))) / expected, 1, 1e-12);
}

TEST(WaterBeams, ATriangleWhoseRaysFlyApartIsCountedAsLost) {
    // A lamp 1 mm over cells of 2 m: the rays of the triangles around it leave almost level to all sides.
    const glm::dvec3 position(0.9, 0.001, 0.9);
    const scene::FrameScene scene = lamp_scene({4, 4}, 2, position);
    const auto sheets = beams<double>(scene, Event::reflection);
    EXPECT_GT(sheets[0].losses.outside_cone, 1);
    EXPECT_NEAR((flux_and_losses(sheets) + flux_and_losses(beams<double>(scene, Event::transmission))) /
                    rectangle_solid_angle({-2, -2}, {2, 2}, position),
                1, 1e-12);
}

TEST(WaterBeams, ALampUnderWaterIsReflectedTotallyBeyondTheCriticalAngle) {
    const glm::dvec3 position(0.1, -1, 0);
    scene::FrameScene scene = lamp_scene({8, 8}, 160, position);
    scene.state.water->absorption = glm::dvec3(0);
    const auto through = beams<double>(scene, Event::transmission);
    const auto mirrored = beams<double>(scene, Event::reflection);
    expect_sound(through);
    EXPECT_FALSE(through[0].in_water());
    EXPECT_TRUE(mirrored[0].in_water());
    EXPECT_EQ(through[0].world_from_mesh[2], glm::dvec3(0, 1, 0));
    const double critical = std::tan(std::asin(1 / kIndex));
    for (std::size_t v = 0; v < scene.water->mesh.positions.size(); ++v) {
        const glm::dvec3 way = scene.water->mesh.positions[v] - position;
        const bool leaves = std::hypot(way.x, way.z) < critical;
        bool carried = false;
        for (const auto& sheet : through) {
            if (!sheet.valid[v]) continue;
            carried = true;
            const glm::dvec3 out = direction(sheet, v), unit = glm::normalize(way);
            ASSERT_GT(out.y, 0);
            ASSERT_NEAR(out.x, unit.x * kIndex, 1e-12);
            ASSERT_NEAR(out.z, unit.z * kIndex, 1e-12);
        }
        ASSERT_EQ(carried, leaves);
        if (mirrored[0].valid[v]) {
            ASSERT_LT(direction(mirrored[0], v).y, 0);
        }
    }
    // Triangles across the critical circle, a cell of 5 cm wide, carry nothing and are counted.
    EXPECT_GT(through[0].losses.total_reflection, 0);
    EXPECT_LT(through[0].losses.total_reflection, 0.03 * flux(through));
    EXPECT_NEAR((flux_and_losses(through) + flux_and_losses(mirrored)) /
                    rectangle_solid_angle({-4, -4}, {4, 4}, position),
                1, 1e-12);
}

TEST(WaterBeams, WaterAbsorbsOnTheWayFromALampInItToTheSurface) {
    const glm::dvec3 position(0.1, -1, 0);
    scene::FrameScene scene = lamp_scene({8, 8}, 160, position);
    auto water = std::make_shared<scene::WaterMesh>(*scene.water);
    water->mesh.normals[80 * 161 + 80] = glm::dvec3(std::nan(""));
    scene.water = water;
    for (const bool spot : {false, true}) {
        if (spot) {
            scene.state.lights[0].type = scene::LightType::spot;
            scene.state.lights[0].direction = {0, 1, 0};
            scene.state.lights[0].cone_angle = 1;
            scene.state.lights[0].falloff_angle = 0.3;
        }
        double met = 0;  // in clear water
        for (const Event event : {Event::transmission, Event::reflection}) {
            scene.state.water->absorption = glm::dvec3(0);
            const auto clear = beams<double>(scene, event);
            met += flux_and_losses(clear);
            EXPECT_EQ(clear[0].losses.absorbed, 0);
            scene.state.water->absorption = {0.4, 0.1, 0.03};
            const auto dimmed = beams<double>(scene, event);
            ASSERT_EQ(dimmed.size(), clear.size());
            for (int channel = 0; channel < 3; ++channel) {
                const double absorption = scene.state.water->absorption[channel];
                for (std::size_t k = 0; k < clear.size(); ++k) {
                    EXPECT_EQ(dimmed[k].color, clear[k].color);
                    EXPECT_TRUE(dimmed[k].counts_paths);
                    for (std::size_t t = 0; t < clear[k].flux.size(); ++t) {
                        if (!(clear[k].flux[t] > 0)) continue;
                        glm::dvec3 middle(0);
                        for (int corner = 0; corner < 3; ++corner)
                            middle +=
                                scene.water->mesh.positions[scene.water->mesh.triangles[t][corner]] / 3.0;
                        // A mean over the corners, weighted by Fresnel and falloff: each is within 3.73 cm of
                        // the middle.
                        ASSERT_NEAR(dimmed[k].power(t)[channel] / clear[k].power(t)[channel],
                                    std::exp(-absorption * glm::length(middle - position)),
                                    0.0373 * absorption)
                            << t;
                    }
                }
            }
            // What goes missing is named.
            EXPECT_NEAR(flux_and_losses(dimmed) / flux_and_losses(clear), 1, 1e-12);
            EXPECT_GT(dimmed[0].losses.not_finite, 0);
            EXPECT_LT(dimmed[0].losses.not_finite, std::exp(-0.03) * clear[0].losses.not_finite);
        }
        EXPECT_GT(met, 0.5);
    }
    // Channels that agree share a sheet; lamps in the air meet the surface before they meet water.
    scene.state.water->absorption = glm::dvec3(0.3);
    const auto grey = beams<double>(scene, Event::transmission);
    EXPECT_EQ(grey[0].color, scene.state.lights[0].intensity);
    EXPECT_GT(grey[0].losses.absorbed, 0);
    scene.state.water->absorption = {0.4, 0.1, 0.03};
    scene.state.lights[0].position.y = 1;
    scene.state.lights[0].direction.y = -1;
    EXPECT_EQ(beams<double>(scene, Event::transmission)[0].losses.absorbed, 0);
}

/// A slab of fog between two heights, 1000 m wide.
scene::Medium fog(double low, double high, glm::dvec3 extinction) {
    scene::Medium medium;
    medium.type = scene::MediumType::box;
    medium.size = {1000, high - low, 1000};
    medium.transform.position.y = 0.5 * (low + high);
    medium.extinction = extinction;
    return medium;
}

TEST(WaterBeams, MediaBetweenTheLightAndTheWaterDimItChannelByChannel) {
    scene::FrameScene scene = water_scene({7, 3}, {1.3, -2.1});
    scene.origin = {2, -3, 5};
    scene.state.lights = {sun(30)};
    scene.state.lights[0].irradiance = {3, 2, 1};
    add_water(scene, gentle_sea(), 40, 20);
    const auto clear = beams<double>(scene, Event::transmission);
    const auto mirrored = beams<double>(scene, Event::reflection);
    ASSERT_EQ(clear.size(), 1U);
    const double thickness = 0.5 / std::cos(glm::radians(30.0));
    scene.state.media = {fog(1, 1.5, {0.3, 1, 2})};
    for (const bool everywhere : {false, true}) {
        // What is sent to the air only is not in the water, where it changes nothing before the surface.
        if (!everywhere) scene.state.media[0].side = scene::MediumSide::air;
        const auto dimmed = beams<double>(scene, Event::transmission);
        ASSERT_EQ(dimmed.size(), 1U);
        EXPECT_EQ(dimmed[0].color, clear[0].color);
        const glm::dvec3 shares = glm::exp(-thickness * scene.state.media[0].extinction);
        for (int channel = 0; channel < 3; ++channel) {
            const double share = shares[channel];
            for (std::size_t t = 0; t < dimmed[0].flux.size(); ++t)  // depths are kept in float
                ASSERT_NEAR(dimmed[0].power(t)[channel] / clear[0].power(t)[channel], share,
                            2e-7 * thickness * 2 * share);
        }
        EXPECT_NEAR(flux_and_losses(dimmed) / flux_and_losses(clear), 1, 1e-12);
        // Of the mean of the channels, weighted by the light's colour.
        EXPECT_NEAR(dimmed[0].losses.absorbed / flux(clear), 1 - glm::dot(shares, {3, 2, 1}) / 6, 1e-6);
    }
    // Facets that nobody knows are the same for all channels.
    const auto water = scene.water;
    auto broken = std::make_shared<scene::WaterMesh>(*water);
    broken->mesh.positions[10 * 41 + 10].y = std::nan("");
    scene.water = broken;
    EXPECT_EQ(beams<double>(scene, Event::transmission)[0].losses.unknown_facets, 6U);
    scene.water = water;
    // Grey fog parts nothing, fog beside the light's way neither, fog under water is none before the surface.
    scene.state.media = {fog(1, 1.5, glm::dvec3(2))};
    const auto grey = beams<double>(scene, Event::reflection);
    ASSERT_EQ(grey.size(), 1U);
    EXPECT_NEAR(flux(grey) / flux(mirrored), std::exp(-2 * thickness), 1e-6);
    scene.state.media = {fog(1, 1.5, {1, 2, 3})};
    scene.state.media[0].transform.position.x = 2000;
    EXPECT_EQ(beams<double>(scene, Event::transmission)[0].flux, clear[0].flux);
    EXPECT_EQ(beams<double>(scene, Event::transmission).size(), 1U);
    scene.state.media = {fog(-3, -1, {1, 2, 3})};
    EXPECT_EQ(beams<double>(scene, Event::transmission)[0].flux, clear[0].flux);
}

TEST(WaterBeams, LampsUnderWaterAreDimmedByExtinctionAndByWhatIsAboutThem) {
    const glm::dvec3 position(0.1, -1, 0.2);
    scene::FrameScene scene = lamp_scene({2, 2}, 40, position);
    scene.state.water->absorption = glm::dvec3(0);
    const auto clear = beams<double>(scene, Event::transmission);
    scene.state.water->absorption = {0.1, 0.2, 0.3};
    scene.state.water->scattering = {0.4, 0.1, 0};
    for (const bool cloudy : {false, true}) {
        if (cloudy) scene.state.media = {fog(-0.6, -0.4, {1, 3, 5})};
        const auto dimmed = beams<double>(scene, Event::transmission);
        ASSERT_EQ(dimmed.size(), clear.size());
        for (int channel = 0; channel < 3; ++channel) {
            const double extinction = scene.state.water->extinction()[channel] +
                                      (cloudy ? 0.2 * scene.state.media[0].extinction[channel] : 0);
            std::size_t lit = 0;
            for (std::size_t t = 0; t < clear[0].flux.size(); ++t) {
                if (!(clear[0].flux[t] > 0)) continue;
                ++lit;
                glm::dvec3 middle(0);
                for (int corner = 0; corner < 3; ++corner)
                    middle += scene.water->mesh.positions[scene.water->mesh.triangles[t][corner]] / 3.0;
                // A fifth of each way is in the cloud. Corners are within 3.73 cm of the middle.
                ASSERT_NEAR(dimmed[0].power(t)[channel] / clear[0].power(t)[channel],
                            std::exp(-extinction * glm::length(middle - position)), 0.0373 * extinction);
            }
            EXPECT_GT(lit, 100U);
        }
    }
}

TEST(WaterBeams, TheSunsDiscSpreadsAsFlatWaterBendsIt) {
    for (const double zenith : {0.0, 50.0, 85.0}) {
        SCOPED_TRACE(zenith);
        scene::FrameScene scene = water_scene({1, 1});
        scene.state.lights = {sun(zenith)};
        scene::Light& sun = scene.state.lights[0];
        sun.angular_diameter = 0.0093;
        add_water(scene, {}, 2, 2);
        const double radius = std::tan(0.5 * 0.0093);
        const double i = glm::radians(zenith), t = std::asin(std::sin(i) / kIndex);
        for (const Event event : {Event::transmission, Event::reflection}) {
            const BeamSheet<double> sheet = beams<double>(scene, event)[0];
            const bool transmission = event == Event::transmission;
            // Snell differentiated in the plane of incidence, and turned about the vertical across it.
            const double in_plane = transmission ? std::cos(i) / (kIndex * std::cos(t)) : 1;
            const double across = transmission ? 1 / kIndex : 1;
            EXPECT_NEAR(glm::length(sheet.disc_u) / radius, in_plane, 1e-13);
            EXPECT_NEAR(glm::length(sheet.disc_v) / radius, across, 1e-13);
            // Against the light moved by a little in that plane and across it.
            const glm::dvec3 direction_before = sun.direction;
            glm::dvec3 side = glm::cross(direction_before, glm::dvec3(0, 1, 0));
            side = zenith > 0 ? glm::normalize(side) : glm::dvec3(1, 0, 0);
            const glm::dvec3 up = glm::cross(side, direction_before);
            const double step = 1e-4;
            for (const bool plane : {true, false}) {
                const auto slope = [&](double by) {
                    sun.direction = glm::normalize(direction_before + by * (plane ? up : side));
                    const BeamSheet<double> moved = beams<double>(scene, event)[0];
                    const glm::dvec3 d = glm::transpose(sheet.world_from_mesh) * direction(moved, 0);
                    return glm::dvec2(d) / d.z;
                };
                const glm::dvec2 change = (slope(step) - slope(-step)) * (0.5 * radius / step);
                sun.direction = direction_before;
                // Central differences: step^2 times third derivatives, which grow towards the horizon.
                EXPECT_NEAR(glm::length(change - (plane ? sheet.disc_u : sheet.disc_v)), 0, 1e-6 * radius);
            }
        }
    }
}

TEST(WaterBeams, PartsOfTheDiscShareItEqually) {
    scene::FrameScene scene = water_scene({1, 1});
    scene.state.lights = {sun(40)};
    scene::Light& sun = scene.state.lights[0];
    sun.angular_diameter = 0.0093;
    sun.irradiance = {4, 2, 1};
    add_water(scene, {}, 2, 2);
    const auto whole = beams<double>(scene, Event::transmission, 1);
    const auto parts = beams<double>(scene, Event::transmission, 16);
    ASSERT_EQ(whole.size(), 1u);
    ASSERT_EQ(parts.size(), 16u);
    EXPECT_EQ(whole[0].light_direction, sun.direction);
    glm::dvec3 color(0), mean(0);
    double square = 0, area = 0;
    const auto ellipse = [](const BeamSheet<double>& sheet) {
        return std::abs(sheet.disc_u.x * sheet.disc_v.y - sheet.disc_u.y * sheet.disc_v.x);
    };
    for (const auto& part : parts) {
        color += part.color;
        mean += part.light_direction / 16.0;
        square += glm::dot(part.light_direction - sun.direction, part.light_direction - sun.direction) / 16;
        area += ellipse(part);
    }
    const double radius = 0.5 * 0.0093;
    EXPECT_NEAR(glm::length(color - sun.irradiance), 0, 1e-14);
    // A uniform disc has r^2 / 2 in the mean; r itself is small to first order.
    EXPECT_NEAR(square / (radius * radius / 2), 1, 1e-4);
    EXPECT_LT(glm::length(mean - sun.direction), 0.1 * radius);  // a spiral of 16 is so lopsided
    EXPECT_NEAR(area / ellipse(whole[0]), 1, 1e-4);
    // A directional sun has no parts.
    sun.angular_diameter = 0;
    const auto directional = beams<double>(scene, Event::transmission, 16);
    ASSERT_EQ(directional.size(), 1u);
    EXPECT_EQ(directional[0].disc_u, glm::dvec2(0));
    EXPECT_EQ(directional[0].color, sun.irradiance);
}

TEST(WaterBeams, DispersionBendsBlueMoreThanRed) {
    scene::FrameScene scene = water_scene({1, 1});
    scene.state.lights = {sun(60)};
    scene.state.lights[0].irradiance = {4, 2, 1};
    scene.state.water->dispersion = 0.0055;
    add_water(scene, {}, 2, 2);
    const auto sheets = beams<double>(scene, Event::transmission);
    ASSERT_EQ(sheets.size(), 3u);
    for (int k = 0; k < 3; ++k) {
        const auto& sheet = sheets[static_cast<std::size_t>(k)];
        glm::dvec3 color(0);
        color[k] = scene.state.lights[0].irradiance[k];
        EXPECT_EQ(sheet.color, color);
        const double n = kIndex + 0.0055 * (k - 1) / 2, i = glm::radians(60.0);
        const glm::dvec3 out = direction(sheet, 4);
        EXPECT_NEAR(std::hypot(out.x, out.z), std::sin(i) / n, 1e-14);
        const double carried = std::accumulate(sheet.flux.begin(), sheet.flux.end(), 0.0);
        EXPECT_NEAR(carried / (std::cos(i) * (1 - reflectance(i, n))), 1, 1e-13);
    }
    ASSERT_EQ(beams<double>(scene, Event::reflection).size(), 1u);
}

/// Names of the sheets that count paths.
std::vector<std::string> counting(const std::vector<BeamSheet<float>>& sheets) {
    std::vector<std::string> names;
    for (const auto& sheet : sheets)
        if (sheet.counts_paths) names.push_back(sheet.name);
    return names;
}

TEST(WaterBeams, ANamelessLightIsCalledByItsPlace) {
    scene::FrameScene scene = lamp_scene({2, 2}, 4, {0, 1, 0});
    scene.state.lights[0].name = "";
    EXPECT_EQ(beams<float>(scene, Event::transmission)[0].name, "lights[0] > water:T");
    EXPECT_EQ(light::chain_name(scene.state, {0, Event::reflection}), "lights[0] > water:R");
    scene.state.lights[0].name = "buoy";
    EXPECT_EQ(light::chain_name(scene.state, {0, Event::reflection}), "buoy > water:R");
}

TEST(WaterBeams, PathsAreCountedByOneBandOfOneDirection) {
    using Names = std::vector<std::string>;
    scene::FrameScene scene = lamp_scene({8, 8}, 80, {0.3, 0.1, -0.2});
    scene.state.lights[0].intensity = {1, 0, 0};
    EXPECT_EQ(counting(beams<float>(scene, Event::transmission)), Names{"lamp > water:T"});
    EXPECT_EQ(counting(beams<float>(scene, Event::reflection)).size(),
              5u);  // all axes: beams are on one each
    scene.state.water->dispersion = 0.0055;
    EXPECT_EQ(counting(beams<float>(scene, Event::transmission)), Names{"lamp > water:T green"});

    scene.state.lights = {sun(30)};
    EXPECT_EQ(counting(beams<float>(scene, Event::transmission)), Names{"sun > water:T green"});
    scene.state.lights[0].angular_diameter = 0.0093;
    EXPECT_EQ(counting(beams<float>(scene, Event::transmission, 4)), Names{"sun > water:T 1 green"});
    EXPECT_EQ(counting(beams<float>(scene, Event::reflection, 4)), Names{"sun > water:R 1"});
    scene.state.water->dispersion = 0;
    EXPECT_EQ(counting(beams<float>(scene, Event::transmission, 4)), Names{"sun > water:T 1"});
    // Of a sun on the horizon, the first part that is above it.
    scene.state.lights[0].direction = sun(90).direction;
    const auto risen = beams<float>(scene, Event::transmission, 4);
    ASSERT_GT(risen.size(), 0u);
    ASSERT_LT(risen.size(), 4u);
    EXPECT_EQ(counting(risen), Names{risen[0].name});
}

TEST(WaterBeams, VerticesThatAreNotFiniteTakeNoOthersWithThem) {
    scene::FrameScene scene = water_scene({4, 4});
    scene.state.lights = {sun(30)};
    add_water(scene, gentle_sea(), 20, 20);
    auto water = std::make_shared<scene::WaterMesh>(*scene.water);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const std::size_t no_place = 5 * 21 + 5, no_normal = 12 * 21 + 8, far_off = 15 * 21 + 15;
    water->mesh.positions[no_place].y = nan;
    water->mesh.normals[no_normal] = glm::dvec3(nan);
    water->mesh.positions[far_off].x = HUGE_VAL;
    water->mesh.triangles.emplace_back(3, 3, 3);  // degenerate
    double met = 0, without_normal = 0;
    std::vector<bool> whole;
    for (const glm::uvec3 t : water->mesh.triangles) {
        const auto& p = water->mesh.positions;
        const double one =
            -0.5 * glm::dot(glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]), scene.state.lights[0].direction);
        if (std::isfinite(one)) met += one;
        const bool blind = t.x == no_normal || t.y == no_normal || t.z == no_normal;
        if (blind) without_normal += one;
        whole.push_back(std::isfinite(one) && one > 0 && !blind);
    }
    scene.water = water;
    const auto through = beams<double>(scene, Event::transmission);
    const auto mirrored = beams<double>(scene, Event::reflection);
    expect_sound(through);
    for (std::size_t t = 0; t < whole.size(); ++t) ASSERT_EQ(through[0].flux[t] > 0, whole[t]) << t;
    EXPECT_EQ(through[0].valid[no_place], 0);
    EXPECT_EQ(through[0].losses.unknown_facets, 12u);  // six about each
    EXPECT_NEAR((through[0].losses.not_finite + mirrored[0].losses.not_finite) / without_normal, 1, 1e-12);
    EXPECT_NEAR((flux_and_losses(through) + flux_and_losses(mirrored)) / met, 1, 1e-12);
}

TEST(WaterBeams, AVertexThatFacesAwayFromTheLightIsGrazedByIt) {
    scene::FrameScene scene = water_scene({2, 2});
    scene.state.lights = {sun(80, 0)};
    add_water(scene, {}, 2, 2);
    auto water = std::make_shared<scene::WaterMesh>(*scene.water);
    const double tilt = glm::radians(30.0);
    water->mesh.normals[4] = {-std::sin(tilt), std::cos(tilt), 0};  // the middle, of all but two triangles
    scene.water = water;
    const glm::dvec3 light = scene.state.lights[0].direction;
    const auto through = beams<double>(scene, Event::transmission);
    const auto mirrored = beams<double>(scene, Event::reflection);
    // Refracted at the critical angle to the surface that it grazes, and mirrored not at all.
    ASSERT_EQ(through[0].valid[4], 1);
    EXPECT_NEAR(glm::dot(direction(through[0], 4), light), 1 / kIndex, 1e-14);
    EXPECT_NEAR(glm::length(direction(mirrored[0], 4) - light), 0, 1e-13);
    // It lets nothing through: each of its six triangles has two corners that do, each of the others three.
    const double met = 4 * std::cos(glm::radians(80.0));
    const double expected = met * (1 - reflectance(glm::radians(80.0), kIndex)) * (6 * 2 + 2 * 3) / 24;
    EXPECT_NEAR(flux(through) / expected, 1, 1e-13);
    EXPECT_NEAR((flux(through) + flux(mirrored)) / met, 1, 1e-13);
}

TEST(WaterBeams, AHundredKilometresFromTheOriginBeamsAreTheSame) {
    const auto sheet_at = [](double far) {
        scene::FrameScene scene = water_scene({4, 4});
        scene.state.lights = {sun(50)};
        add_water(scene, gentle_sea(), 40, 40);
        auto water = std::make_shared<scene::WaterMesh>(*scene.water);
        for (glm::dvec3& p : water->mesh.positions) p += glm::dvec3(far, 0, -far);
        scene.water = water;
        scene.state.water->extent.center = {far, -far};
        scene.origin = {far, 0, -far};
        return beams<float>(scene, Event::transmission)[0];
    };
    const BeamSheet<float> here = sheet_at(0), there = sheet_at(1e5);
    for (std::size_t v = 0; v < here.rays.size(); ++v) {
        ASSERT_EQ(there.rays[v].slope_a, here.rays[v].slope_a);
        // Doubles have digits of 1.5e-11 there; a float of 2 m may round the other way.
        ASSERT_NEAR(there.rays[v].a, here.rays[v].a, 3e-7);
        ASSERT_NEAR(there.rays[v].b, here.rays[v].b, 3e-7);
        ASSERT_NEAR(there.start[v], here.start[v], 3e-7);
    }
    // Digits of positions over cells of 0.1 m.
    for (std::size_t t = 0; t < here.flux.size(); ++t) ASSERT_NEAR(there.flux[t] / here.flux[t], 1, 1e-6);
}

TEST(WaterBeams, ThreadsDoNotChangeABit) {
    scene::FrameScene scene = lamp_scene({8, 8}, 130, {0.3, 0.4, -0.2});
    add_water(scene, gentle_sea(0.01), 130, 130);
    set_thread_count(1);
    const auto one = beams<float>(scene, Event::reflection);
    set_thread_count(4);
    const auto four = beams<float>(scene, Event::reflection);
    set_thread_count(0);
    ASSERT_EQ(one.size(), four.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].flux, four[i].flux);
        EXPECT_EQ(one[i].valid, four[i].valid);
        EXPECT_EQ(one[i].losses.wave_shadow, four[i].losses.wave_shadow);
        EXPECT_EQ(one[i].losses.second_crossing, four[i].losses.second_crossing);
    }
    EXPECT_GT(one[0].losses.wave_shadow, 0);
    EXPECT_GT(one[0].losses.second_crossing, 0);
}

TEST(WaterBeams, ASetSunAndALampInTheRestPlaneSendNothing) {
    scene::FrameScene scene = lamp_scene({4, 4}, 4, {0, 0, 0});
    EXPECT_TRUE(beams<float>(scene, Event::transmission).empty());
    scene.state.lights = {sun(91)};
    EXPECT_TRUE(beams<float>(scene, Event::transmission).empty());
}

}  // namespace
}  // namespace dapple
