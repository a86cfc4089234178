// Scattered light of lamps, of mirrored light in the air and of light that water parts by colour, as the
// method answers for segments, against closed forms below and above flat water; its bits on any number of
// threads.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "base/parallel.h"
#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "closed_form/gentle_sea.h"
#include "gpu/validated_device.h"
#include "methods/sliced_beams/sliced_beams.h"

namespace dapple {
namespace {

using light::Event;

constexpr double kIndex = 1.333;
constexpr double kPi = glm::pi<double>();

struct Segment {
    glm::dvec3 origin, direction;
    double length;
};

std::vector<glm::dvec3> scattered(const scene::FrameScene& scene, Event event,
                                  const std::vector<Segment>& segments, bool in_water) {
    const rays::RayScene rays(scene);
    FrameStats stats;
    methods::FrameContext context{scene, rays, test::validated_device(), stats, {{0, event}}, {}};
    methods::SlicedBeams method;
    method.begin(context);
    view::SegmentLayer layer;
    layer.width = static_cast<int>(segments.size());
    layer.height = 1;
    for (const Segment& s : segments) {
        layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
        layer.origin.emplace_back(s.origin);
        layer.direction.emplace_back(s.direction);
        layer.length.push_back(static_cast<float>(s.length));
        layer.in_water.push_back(in_water ? 1 : 0);
        layer.primary.push_back(1);
        layer.throughput.emplace_back(1.0f);
        for (auto* spread : {&layer.spread_u_origin, &layer.spread_u_direction, &layer.spread_v_origin,
                             &layer.spread_v_direction})
            spread->emplace_back(0.0f);
    }
    layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
    std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
    method.in_scatter(context, layer, radiance);
    return {radiance.begin(), radiance.end()};
}

/// Light at a point: its fluence rate in W/m^2 before extinction, its way, and what is left of it.
struct Arrival {
    glm::dvec3 fluence{0};
    glm::dvec3 way{0, -1, 0};  ///< unit, of travel
    glm::dvec3 left{1};        ///< a channel, by media
};
using Light = std::function<Arrival(const glm::dvec3&)>;

double reflectance(double i, double t) {
    if (i < 1e-6) return std::pow((kIndex - 1) / (kIndex + 1), 2);
    const double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
    return 0.5 * (s * s + p * p);
}

double henyey_greenstein(double g, double cosine) {
    return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

/// S of a segment by Simpson's rule over `light`.
glm::dvec3 expected(const Segment& s, const Light& light, const glm::dvec3& scattering,
                    const glm::dvec3& extinction, double anisotropy) {
    constexpr int steps = 100;
    glm::dvec3 sum(0);
    for (int k = 0; k <= steps; ++k) {
        const double along = s.length * k / steps;
        const Arrival at = light(s.origin + along * s.direction);
        const double weight = k == 0 || k == steps ? 1 : 2 + 2 * (k % 2);
        sum += weight / 3 * henyey_greenstein(anisotropy, -glm::dot(at.way, s.direction)) * at.fluence *
               at.left * glm::exp(-extinction * along);
    }
    return scattering * sum * (s.length / steps);
}

/// Light of a lamp above or below flat water that is refracted: its angle i to the vertical before the
/// surface, t after it, over `before` and `after` m of height, by bisection for the horizontal way r.
/// `index`: before over after.
struct Refracted {
    double i, t;
    double fluence;  ///< of a lamp of 1 W/sr, W/m^2
};
Refracted refracted(double r, double before, double after, double index) {
    const auto way = [&](double i) {
        return before * std::tan(i) + after * std::tan(std::asin(index * std::sin(i)));
    };
    double low = 0, high = std::asin(std::min(1.0, 1 / index)) - 1e-9;
    for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        (way(middle) < r ? low : high) = middle;
    }
    // On the axis all is linear in i.
    const double i = std::max(0.5 * (low + high), 1e-7), t = std::asin(index * std::sin(i));
    const double spread = before / std::pow(std::cos(i), 2) +
                          after / std::pow(std::cos(t), 2) * index * std::cos(i) / std::cos(t);
    // Light between i and i + di, 2 pi sin i di sr, crosses an area of 2 pi r dr cos t.
    return {i, t, (1 - reflectance(i, t)) * std::sin(i) / (way(i) * spread * std::cos(t))};
}

/// The horizontal unit vector from a lamp to a point.
glm::dvec3 outwards(const glm::dvec3& lamp, const glm::dvec3& point) {
    const glm::dvec3 to(point.x - lamp.x, 0, point.z - lamp.z);
    return glm::length(to) > 1e-12 ? glm::normalize(to) : glm::dvec3(1, 0, 0);
}

/// What the test's own formula says of the light at a point below flat water.
Light lamp_into_water(const scene::FrameScene& scene) {
    const scene::Light& lamp = scene.state.lights[0];
    const glm::dvec3 extinction = scene.state.water->extinction();
    return [lamp, extinction](const glm::dvec3& point) {
        const glm::dvec3 out = outwards(lamp.position, point);
        const double r = std::hypot(point.x - lamp.position.x, point.z - lamp.position.z);
        const Refracted light = refracted(r, lamp.position.y, -point.y, 1 / kIndex);
        double falloff = 1;
        if (lamp.type == scene::LightType::spot) {
            const glm::dvec3 sent = std::sin(light.i) * out - glm::dvec3(0, std::cos(light.i), 0);
            const double outer = std::cos(lamp.cone_angle),
                         inner = std::cos(lamp.cone_angle - lamp.falloff_angle);
            const double x = std::clamp((glm::dot(sent, lamp.direction) - outer) / (inner - outer), 0.0, 1.0);
            falloff = x * x * (3 - 2 * x);
        }
        return Arrival{falloff * light.fluence * lamp.intensity,
                       std::sin(light.t) * out - glm::dvec3(0, std::cos(light.t), 0),
                       glm::exp(extinction * point.y / std::cos(light.t))};
    };
}

scene::Light point_lamp(glm::dvec3 position) {
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = position;
    lamp.intensity = {3, 2, 1};
    return lamp;
}

/// Flat water of 8 m x 8 m and, out of the light's way, an object at all depths that segments come to.
scene::FrameScene flat_water(int cells) {
    scene::FrameScene scene = test::scene_of_flat_water({8, 8}, cells, cells);
    scene::Object pole;
    pole.shape = scene::Shape::box;
    pole.size = {0.1, 16, 0.1};
    pole.transform.position = {40, 0, 40};
    scene.state.objects.push_back(pole);
    scene.state.water->absorption = {0.3, 0.1, 0.03};
    scene.state.water->scattering = {0.2, 0.3, 0.05};
    scene.state.water->phase.type = scene::PhaseType::henyey_greenstein;
    scene.state.water->phase.anisotropy = 0.5;
    return scene;
}

/// Level, upright and oblique segments within `reach` m of the axis at heights of `side` times 0.3 to 2.2 m.
std::vector<Segment> segments_about_axis(double side, double reach) {
    std::vector<Segment> all;
    for (const double height : {0.3, 0.9, 1.6}) {
        for (int i = 0; i < 8; ++i) {
            const double turn = 1.4 * i;
            const glm::dvec3 from(0.5 * reach * std::cos(2.6 * i), side * height,
                                  0.5 * reach * std::sin(2.6 * i));
            const glm::dvec3 level(std::cos(turn), 0, std::sin(turn));
            all.push_back({from, level, 0.45 * reach});
            all.push_back({from, glm::normalize(level + glm::dvec3(0, 0.8 * side, 0)), 0.5 * reach});
            all.push_back({from, {0, side, 0}, 0.5});
        }
    }
    return all;
}

/// Mean difference from the closed form, over the mean of it; of the worst channel.
double error_of(const scene::FrameScene& scene, Event event, const std::vector<Segment>& segments,
                bool in_water, const Light& light, const glm::dvec3& scattering, const glm::dvec3& extinction,
                double anisotropy) {
    const std::vector<glm::dvec3> found = scattered(scene, event, segments, in_water);
    glm::dvec3 difference(0), sum(0);
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const glm::dvec3 exact = expected(segments[i], light, scattering, extinction, anisotropy);
        difference += glm::abs(found[i] - exact);
        sum += exact;
    }
    const glm::dvec3 error = difference / sum;
    return std::max({error.x, error.y, error.z});
}

/// Beams are as even as their triangles: the error is theirs, and falls with their size.
void expect_convergence(const char* what, const std::function<double(int cells)>& error, double tolerance) {
    const double coarse = error(60), fine = error(240);
    printf("%s: S off by %.1e with cells of 13 cm, %.1e with 3.3 cm\n", what, coarse, fine);
    EXPECT_LT(fine, tolerance) << what;
    EXPECT_LT(fine, 0.5 * coarse) << what;
}

TEST(ScatterLights, OfAPointLampAboveTheWaterHaveTheClosedForm) {
    const auto error = [](int cells) {
        scene::FrameScene scene = flat_water(cells);
        scene.state.lights = {point_lamp({0.03, 1.2, -0.02})};
        return error_of(scene, Event::transmission, segments_about_axis(-1, 1.5), true,
                        lamp_into_water(scene), scene.state.water->scattering,
                        scene.state.water->extinction(), 0.5);
    };
    expect_convergence("point lamp", error, 0.002);
}

TEST(ScatterLights, OfASpotHaveTheClosedFormAlsoInItsSoftEdge) {
    const auto error = [](int cells) {
        scene::FrameScene scene = flat_water(cells);
        scene.state.lights = {point_lamp({0.3, 1.4, -0.2})};
        scene::Light& spot = scene.state.lights[0];
        spot.type = scene::LightType::spot;
        spot.direction = glm::normalize(glm::dvec3(-0.3, -1, 0.2));
        spot.cone_angle = 35 * scene::kDegree;
        spot.falloff_angle = 15 * scene::kDegree;
        return error_of(scene, Event::transmission, segments_about_axis(-1, 1.5), true,
                        lamp_into_water(scene), scene.state.water->scattering,
                        scene.state.water->extinction(), 0.5);
    };
    // A triangle's light is even, and a soft edge of 40 cm only ten triangles wide.
    expect_convergence("spot", error, 0.005);
}

/// Fog above the water, lamps and all in it; channels are dimmed unevenly before the surface.
constexpr double kFogTop = 5;
scene::Medium& add_fog(scene::FrameScene& scene) {
    scene::Medium& fog = scene.state.media.emplace_back();
    fog.type = scene::MediumType::box;
    fog.side = scene::MediumSide::air;
    fog.size = {200, 2 * kFogTop, 200};
    fog.extinction = {0.3, 0.15, 0.05};
    fog.albedo = {0.9, 0.8, 0.7};
    fog.phase.type = scene::PhaseType::henyey_greenstein;
    fog.phase.anisotropy = 0.3;
    return fog;
}

TEST(ScatterLights, OfWhatTheWaterMirrorsIntoFogHaveTheClosedForm) {
    scene::FrameScene scene = flat_water(80);
    const scene::Medium& fog = add_fog(scene);
    const double zenith = glm::radians(40.0), cos_i = std::cos(zenith);
    scene.state.lights = {test::sun_from_zenith(40)};
    const scene::Light& sun = scene.state.lights[0];
    const Light light = [&](const glm::dvec3& point) {
        return Arrival{reflectance(zenith, std::asin(std::sin(zenith) / kIndex)) * sun.irradiance,
                       {sun.direction.x, -sun.direction.y, sun.direction.z},
                       glm::exp(-fog.extinction * (kFogTop + point.y) / cos_i)};
    };
    const double error = error_of(scene, Event::reflection, segments_about_axis(1, 1.5), false, light,
                                  fog.albedo * fog.extinction, fog.extinction, fog.phase.anisotropy);
    printf("sun mirrored into fog: S off by %.1e\n", error);
    // All beams are parallel, so that meshes do not matter; the light's way through bounded media is taken to
    // the middles of pieces of 0.1 optical depths.
    EXPECT_LT(error, 1e-3);
}

TEST(ScatterLights, OfAMirroredLampInFogHaveTheClosedForm) {
    const auto error = [](int cells) {
        scene::FrameScene scene = flat_water(cells);
        const scene::Medium fog = add_fog(scene);
        scene.state.lights = {point_lamp({0.03, 1.2, -0.02})};
        const scene::Light lamp = scene.state.lights[0];
        // As from the lamp's picture below the surface.
        const Light light = [&](const glm::dvec3& point) {
            const glm::dvec3 way = point - glm::dvec3(lamp.position.x, -lamp.position.y, lamp.position.z);
            const double i = std::acos(way.y / glm::length(way)), t = std::asin(std::sin(i) / kIndex);
            return Arrival{reflectance(i, t) / glm::dot(way, way) * lamp.intensity, glm::normalize(way),
                           glm::exp(-fog.extinction * glm::length(way))};
        };
        return error_of(scene, Event::reflection, segments_about_axis(1, 1.5), false, light,
                        fog.albedo * fog.extinction, fog.extinction, fog.phase.anisotropy);
    };
    expect_convergence("lamp mirrored into fog", error, 0.002);
}

TEST(ScatterLights, OfALampInTheWaterHaveTheClosedFormInFogAboveIt) {
    const auto error = [](int cells) {
        scene::FrameScene scene = flat_water(cells);
        const scene::Medium fog = add_fog(scene);
        scene.state.lights = {point_lamp({0.03, -1.2, -0.02})};
        const scene::Light lamp = scene.state.lights[0];
        const glm::dvec3 extinction = scene.state.water->extinction();
        const Light light = [&](const glm::dvec3& point) {
            const double r = std::hypot(point.x - lamp.position.x, point.z - lamp.position.z);
            const Refracted up = refracted(r, -lamp.position.y, point.y, kIndex);
            return Arrival{up.fluence * lamp.intensity,
                           std::sin(up.t) * outwards(lamp.position, point) + glm::dvec3(0, std::cos(up.t), 0),
                           glm::exp(extinction * lamp.position.y / std::cos(up.i) -
                                    fog.extinction * point.y / std::cos(up.t))};
        };
        return error_of(scene, Event::transmission, segments_about_axis(1, 1.5), false, light,
                        fog.albedo * fog.extinction, fog.extinction, fog.phase.anisotropy);
    };
    expect_convergence("lamp in the water, fog above", error, 0.003);
}

/// h of 24 gentle waves with its slopes, times 3: past the first foci 3 m down.
glm::dvec3 sea(double x, double z) {
    static const scene::Waves waves = test::gentle_waves();
    glm::dvec3 h(0);
    for (const scene::Wave& wave : waves.waves) {
        const glm::dvec2 k =
            2 * kPi / wave.length * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
        const double phase = k.x * x + k.y * z + wave.phase;
        h += 3 * wave.amplitude * glm::dvec3(std::cos(phase), -k.x * std::sin(phase), -k.y * std::sin(phase));
    }
    return h;
}

scene::FrameScene waves() {
    scene::FrameScene scene = test::scene_of_water({6, 6}, 120, 120, sea);
    scene.state.objects = flat_water(1).state.objects;
    scene.state.lights = {test::sun_from_zenith(25)};
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    scene.state.water->absorption = {0.3, 0.1, 0.05};
    return scene;
}

TEST(ScatterLights, OfOneColourAreThoseOfWaterOfItsOwnIndex) {
    scene::FrameScene scene = waves();
    scene.state.water->dispersion = 0.05;
    std::vector<Segment> segments;
    for (int i = 0; i < 64; ++i)
        segments.push_back({{0.02 * i - 0.6, -2.5, 0.01 * i}, glm::normalize(glm::dvec3(0.3, 0.1, 1)), 0.4});
    const std::vector<glm::dvec3> parted = scattered(scene, Event::transmission, segments, true);
    scene.state.water->dispersion = 0;
    double spread = 0, sum = 0, worst = 0;
    for (int c = 0; c < 3; ++c) {
        scene.state.water->refractive_index = kIndex + 0.05 * (c - 1) / 2;
        const std::vector<glm::dvec3> alone = scattered(scene, Event::transmission, segments, true);
        for (std::size_t i = 0; i < segments.size(); ++i) {
            worst = std::max(worst, std::abs(parted[i][c] / alone[i][c] - 1));
            spread += std::abs(alone[i][c] - alone[i][1] * scene.state.water->scattering[c] /
                                                 scene.state.water->scattering[1]);
            sum += alone[i][c];
        }
    }
    printf("dispersion: colours apart by %.2f of S, each off its own water's by %.1e\n", spread / sum, worst);
    EXPECT_LT(worst, 1e-5);  // the same beams, in float
    EXPECT_GT(spread / sum, 0.05);
}

TEST(ScatterLights, HaveTheSameBitsOnAnyNumberOfThreads) {
    scene::FrameScene scene = waves();
    scene.state.lights[0].angular_diameter = 0.53 * scene::kDegree;
    scene.state.caustics.sliced_beams.volume_sun_samples = 2;
    scene.state.objects.push_back(test::level_plane("floor", -3, 20));
    scene::Medium& cloud = scene.state.media.emplace_back();
    cloud.type = scene::MediumType::box;
    cloud.size = {2, 2.5, 2};
    cloud.extinction = {0.2, 0.4, 0.1};
    struct Side {
        Event event;
        double height;
    };
    for (const Side side : {Side{Event::transmission, -1}, Side{Event::reflection, 0.6}}) {
        std::vector<Segment> segments;
        for (int i = 0; i < 300; ++i)
            segments.push_back({{0.005 * i - 0.9, side.height, 0.5},
                                glm::normalize(glm::dvec3(0.4 * std::sin(1.0 * i), 0.2, -1)),
                                1.1});
        set_thread_count(1);
        const auto one = scattered(scene, side.event, segments, side.height < 0);
        double light = 0;
        for (const glm::dvec3& value : one) light += value.y;
        EXPECT_GT(light, 0);
        for (const int threads : {2, 4}) {
            set_thread_count(threads);
            const auto many = scattered(scene, side.event, segments, side.height < 0);
            EXPECT_EQ(std::memcmp(one.data(), many.data(), one.size() * sizeof one[0]), 0)
                << threads << " threads, " << (side.height < 0 ? "water" : "air");
        }
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace dapple
