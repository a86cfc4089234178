// The reference's own media: phase functions, boxes, grids, and light that is scattered in them or comes
// through them, against closed forms and numeric integrals.
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "base/error.h"
#include "base/parallel.h"
#include "grids/density_grid.h"
#include "image/temporary_folder.h"
#include "methods/reference/light_tracer.h"
#include "methods/reference/own_phase.h"
#include "methods/reference_volume_frame.h"

namespace dapple {
namespace {

using namespace test;
using reference::OwnPhase;

TEST(OwnPhase, IntegratesToOne) {
    scene::PhaseFunction isotropic, narrow, lobes, sea, coarse, table;
    narrow.type = scene::PhaseType::henyey_greenstein;
    narrow.anisotropy = 0.95;
    lobes.type = scene::PhaseType::two_lobe;
    sea.type = coarse.type = scene::PhaseType::fournier_forand;
    coarse.particle_index = 1.05;
    coarse.size_slope = 4.2;
    table.type = scene::PhaseType::table;
    table.samples = {{0.1, 5}, {0.7, 2}, {2, 0.3}, {2.8, 0.6}};
    for (const scene::PhaseFunction& phase : {isotropic, narrow, lobes, sea, coarse, table}) {
        const OwnPhase p(phase);
        // Evenly in the logarithm of the angle: p may have a pole straight on. Of Fournier and Forand's lies
        // delta^0.3 = 7e-4 below 1e-6 rad.
        double sum = 0, mean_cosine = 0;
        constexpr int steps = 200000;
        const double low = std::log(1e-6), high = std::log(glm::pi<double>());
        for (int i = 0; i < steps; ++i) {
            const double angle = std::exp(low + (high - low) * (i + 0.5) / steps);
            const double part =
                2 * glm::pi<double>() * std::sin(angle) * angle * (high - low) / steps * p(std::cos(angle));
            sum += part;
            mean_cosine += part * std::cos(angle);
        }
        EXPECT_NEAR(sum, 1, 1e-3) << static_cast<int>(phase.type);
        if (phase.type == scene::PhaseType::henyey_greenstein) {
            EXPECT_NEAR(mean_cosine, 0.95, 1e-4);
        }
        if (phase.type == scene::PhaseType::two_lobe) {
            EXPECT_NEAR(mean_cosine, 0.95 * 0.8 - 0.05 * 0.5, 1e-4);
        }
    }
    // Known to be 1 / (4 pi) (1 - g^2) / (1 - g)^3 straight on.
    EXPECT_NEAR(OwnPhase(narrow)(1), (1 - 0.95 * 0.95) / (4 * glm::pi<double>() * std::pow(0.05, 3)), 1e-9);
    // Smooth where delta passes through 1: s = 3 (n - 1)^2 / 4.
    const double s = 0.75 * 0.1 * 0.1;
    EXPECT_NEAR(OwnPhase(sea)(1 - 2 * s * 1.00009) / OwnPhase(sea)(1 - 2 * s * 1.00011), 1, 1e-4);
}

/// Density of a medium of the tests at a point of the world.
using Density = std::function<double(const glm::dvec3&)>;

Density in_box(const scene::Medium& box) {
    const glm::dmat4 local = glm::inverse(glm::scale(scene::world_from_object(box.transform), box.size));
    return [local, density = box.density](const glm::dvec3& x) {
        const glm::dvec3 at = glm::abs(glm::dvec3(local * glm::dvec4(x, 1)));
        return std::max({at.x, at.y, at.z}) <= 0.5 ? density : 0.0;
    };
}

/// A grid of 6 x 4 x 5 voxels, 10 cm wide, in a turned medium; and its density.
struct Cloud {
    scene::Medium medium;
    std::shared_ptr<const grids::DensityGrid> grid;
    std::vector<float> values;
    static constexpr glm::ivec3 size{6, 4, 5};

    explicit Cloud(const std::function<double(int, int, int)>& value) {
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) values.push_back(static_cast<float>(value(x, y, z)));
        glm::dmat4 file_from_index(0.1);
        file_from_index[3] = {-0.25, -0.15, -0.2, 1};
        grid = grids::DensityGrid::from_values({0, 0, 0}, size, values, file_from_index);
        medium.density = 3;
        medium.extinction = {0.6, 0.4, 0.2};
        medium.albedo = {0.9, 0.6, 0.3};
        medium.transform.rotation = {0.2, 0.5, -0.3};
    }
    Density density() const {
        const glm::dmat4 index =
            glm::inverse(scene::world_from_object(medium.transform) * grid->file_from_index());
        return [this, index](const glm::dvec3& x) {
            const glm::dvec3 at(index * glm::dvec4(x, 1));
            const glm::ivec3 cell(glm::floor(at));
            const glm::dvec3 t = at - glm::dvec3(cell);
            double sum = 0;
            for (int k = 0; k < 8; ++k) {
                const glm::ivec3 corner(k & 1, k >> 1 & 1, k >> 2), v = cell + corner;
                if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= size.x || v.y >= size.y || v.z >= size.z)
                    continue;
                const double weight = (corner.x != 0 ? t.x : 1 - t.x) * (corner.y != 0 ? t.y : 1 - t.y) *
                                      (corner.z != 0 ? t.z : 1 - t.z);
                sum += weight * static_cast<double>(
                                    values[static_cast<std::size_t>((v.z * size.y + v.y) * size.x + v.x)]);
            }
            return medium.density * sum;
        };
    }
};

/// A medium within 0.7 m of (0, 1, 0) over flat water, seen from 2 m away; the sun 40 degrees from the
/// zenith, its light reflected by the water.
scene::FrameState over_water(const scene::Medium& medium) {
    scene::FrameState state = water_with_eye({0, 0.6, 2}, {0, 0.2, -1}, 8, 6);
    state.objects.clear();
    state.camera.field_of_view = 10 * scene::kDegree;  // the medium fills the picture
    state.water->scattering = glm::dvec3(0);
    state.media = {medium};
    state.lights = {sun_from_zenith(40)};
    state.caustics.reference = {0.04, 40};
    return state;
}

double column(const Density& density, const glm::dvec3& origin, const glm::dvec3& direction, double length) {
    return integral(length, 60, [&](double s) { return density(origin + s * direction); });
}

/// What each pixel receives: along its ray, light that went down through the medium, was mirrored, went up,
/// was scattered, and came to the eye. All that lies in the medium is within 0.7 m of (0, 1, 0).
std::vector<double> reflected_scatter(const scene::FrameState& state, const Density& density, int channel) {
    const scene::Medium& medium = state.media[0];
    const glm::dvec3 down = state.lights[0].direction, up(down.x, -down.y, down.z);
    const double reflectance = refract(glm::radians(40.0), 1, state.water->refractive_index).reflectance;
    const double sigma = medium.extinction[channel];
    const glm::dvec3 middle(0, 1, 0);
    return over_pixels(state, [&](const glm::dvec3& eye, const glm::dvec3& way) {
        const double nearest = dot(middle - eye, way);
        const double first = nearest - 0.7;
        const glm::dvec3 start = eye + first * way;
        double near = 0;  // column between the start and the place
        constexpr int steps = 60;
        const double step = 1.4 / steps;
        double sum = 0;
        for (int i = 0; i < steps; ++i) {
            const glm::dvec3 x = start + (i + 0.5) * step * way;
            const double there = density(x);
            if (there > 0) {
                const glm::dvec3 foot = x - x.y / up.y * up;
                const double before = column(density, foot, -down, 3);
                const double after = column(density, foot, up, x.y / up.y);
                const double depth = before + after + near + 0.5 * there * step;
                sum += there * std::exp(-sigma * depth) * step;
            }
            near += there * step;
        }
        return state.lights[0].irradiance[channel] * reflectance * sigma * medium.albedo[channel] * sum *
               henyey_greenstein(0.4, -dot(up, way));
    });
}

scene::PhaseFunction forward() {
    scene::PhaseFunction phase;
    phase.type = scene::PhaseType::henyey_greenstein;
    phase.anisotropy = 0.4;
    return phase;
}

void expect_reflected(const scene::FrameState& state, const Density& density,
                      std::shared_ptr<const grids::DensityGrid> grid) {
    VolumeFrame frame(state);
    frame.chains = {{0, light::Event::reflection}};
    frame.scene.medium_grids = {std::move(grid)};
    const LayerResult result = frame.scatter();
    for (const int channel : {0, 2}) {
        const std::vector<double> expected = reflected_scatter(state, density, channel);
        ASSERT_GT(*std::min_element(expected.begin(), expected.end()), 0);
        expect_scatter(result, expected, 0.04, channel);
    }
}

TEST(ReferenceMedia, BoxInTheAirAndReflectedLight) {
    scene::Medium box = box_of_smoke({0, 1, 0}, {0.9, 0.6, 0.7});
    box.phase = forward();
    expect_reflected(over_water(box), in_box(box), nullptr);
}

TEST(ReferenceMedia, NothingScattersOnTheOtherSide) {
    scene::Medium box = box_of_smoke({0, 1, 0}, {0.9, 0.6, 0.7});
    box.side = scene::MediumSide::water;
    VolumeFrame frame(over_water(box));
    frame.chains = {{0, light::Event::reflection}};
    for (const glm::vec3& dark : frame.scatter().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(ReferenceMedia, GridOfEvenDensity) {
    Cloud cloud([](int, int, int) { return 1.0; });
    cloud.medium.transform.position = {0, 1, 0};
    cloud.medium.phase = forward();
    expect_reflected(over_water(cloud.medium), cloud.density(), cloud.grid);
}

TEST(ReferenceMedia, GridOfLinearDensity) {
    Cloud cloud([](int x, int, int) { return 0.2 + 0.4 * x; });
    cloud.medium.transform.position = {0, 1, 0};
    cloud.medium.phase = forward();
    expect_reflected(over_water(cloud.medium), cloud.density(), cloud.grid);
}

TEST(ReferenceMedia, RatioTrackingHasNoBias) {
    // A way through a cloud and a box: the mean of estimates against the integral; asked at places between
    // as well, and of a grid that is stood up.
    Cloud cloud([](int x, int y, int z) { return 0.1 * x + 0.3 * y * z; });
    cloud.medium.z_up = true;
    cloud.medium.transform.scale = {1, 1.5, 0.8};
    scene::FrameScene scene;
    const scene::Medium box = box_of_smoke({0.1, 0, 0}, {0.3, 0.3, 0.3});
    scene.state.media = {cloud.medium, box};
    scene.medium_grids = {cloud.grid, nullptr};
    scene.origin = {3, -2, 1};
    const glm::dmat4 upright(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
    const glm::dmat4 index = glm::inverse(scene::world_from_object(cloud.medium.transform) * upright *
                                          cloud.grid->file_from_index());
    Cloud plain = cloud;
    plain.medium.transform = {};
    const glm::dmat4 back = plain.grid->file_from_index() * index;
    const Density of_plain = plain.density(), of_box = in_box(box);
    const reference::OwnMedia media(scene);
    reference::MediaProbe probe(media);
    const glm::dvec3 origin(-0.9, -0.4, 0.3), way = normalize(glm::dvec3(0.9, 0.45, -0.25));
    glm::dvec3 sum(0), square(0), half(0);
    constexpr int count = 40000;
    for (std::uint64_t i = 0; i < count; ++i) {
        reference::RandomStream random{1, 2, i};
        probe.start(origin - scene.origin, way, false);
        half += probe.transmittance_to(0.95, random);
        const glm::dvec3 whole = probe.transmittance_to(2.5, random);
        sum += whole;
        square += whole * whole;
    }
    const auto exact = [&](double length, int channel) {
        return std::exp(-integral(length, 20000, [&](double s) {
            const glm::dvec3 x = origin + s * way;
            return cloud.medium.extinction[channel] * of_plain(glm::dvec3(back * glm::dvec4(x, 1))) +
                   box.extinction[channel] * of_box(x);
        }));
    };
    for (int channel = 0; channel < 3; ++channel) {
        const double mean = sum[channel] / count;
        const double error = std::sqrt((square[channel] / count - mean * mean) / count);
        printf("%.5f +- %.5f of %.5f\n", mean, error, exact(2.5, channel));
        EXPECT_NEAR(mean, exact(2.5, channel), 4 * error + 1e-4);  // of the integral's edges
        EXPECT_NEAR(half[channel] / count, exact(0.95, channel), 8 * error + 1e-4);
        EXPECT_LT(exact(2.5, channel), 0.9 * exact(0.95, channel));
    }
}

/// A ray that passes a dense voxel at a distance is hardly dimmed; one step of ratio tracking a mean free
/// path of the voxel would be millions. RandomStream::dimension counts the steps.
TEST(ReferenceMedia, DenseGridsTakeFewSteps) {
    Cloud cloud([](int x, int y, int z) { return x == 2 && y == 1 && z == 2 ? 1 : 0; });
    cloud.medium.transform = {};
    scene::FrameScene scene;
    scene.medium_grids = {cloud.grid};
    constexpr std::uint32_t most = 64;
    const glm::dvec3 along(1, 0, 0);
    for (const double density : {1e4, 1e6, 1e9}) {
        cloud.medium.density = density;
        scene.state.media = {cloud.medium};
        const reference::OwnMedia media(scene);
        reference::MediaProbe probe(media);
        // So far off that the optical depth is half the largest extinction: 10 cm of that density.
        const double share = std::sqrt(5 / density);
        const glm::dvec3 origin(-3, -0.05 + 0.1 * (1 - share), 0.1 * (1 - share));
        reference::RandomStream random{1, 2, 3};
        probe.start(origin, along, false);
        const glm::dvec3 half = probe.transmittance_to(2.95, random);
        const glm::dvec3 whole = probe.transmittance_to(10, random);
        for (int channel = 0; channel < 3; ++channel) {
            // A share of a voxel's edge in float, squared: 1e-3 for the farthest.
            const double depth = 0.5 * cloud.medium.extinction[channel];
            EXPECT_NEAR(whole[channel], std::exp(-depth), 3e-3) << density;
            EXPECT_NEAR(half[channel], std::exp(-0.5 * depth), 3e-3) << density;
        }
        EXPECT_LT(random.dimension, most);
        // Through its middle no light comes.
        probe.start({-3, -0.05, 0}, along, false);
        EXPECT_LT(probe.transmittance_to(10, random).z, 1e-80) << density;
    }
    // Nothing is asked for behind a wall.
    cloud.medium.density = 3;
    scene.state.media = {cloud.medium, box_of_smoke({0.3, 0, 0}, {0.1, 1, 1})};
    scene.state.media[1].density = 1e9;
    scene.medium_grids = {cloud.grid, nullptr};
    const reference::OwnMedia media(scene);
    reference::MediaProbe probe(media);
    reference::RandomStream random{1, 2, 3};
    EXPECT_EQ(probe.transmittance({3, -0.05, 0}, -along, 10, false, random), glm::dvec3(0));
    EXPECT_EQ(random.dimension, 0U);
}

TEST(ReferenceMedia, StatesThatItMayHaveMissedLight) {
    // Smoke so dense that only its skin is lit, even at its corners far less than a nanometre deep, in which
    // no event falls: S is 0, and nobody knows how large it is. Of dark smoke it is 0 indeed.
    Cloud cloud([](int, int, int) { return 1; });
    cloud.medium.transform.position = {0, -0.7, 0};
    cloud.medium.density = 1e30;
    scene::FrameState state = water_with_eye({0, -0.5, 2}, {0, -0.1, -1}, 4, 3);
    state.water->scattering = {0, 0, 0};
    state.media = {cloud.medium};
    state.caustics.reference = {0.05, 1};
    for (const bool lit : {true, false}) {
        if (!lit) state.objects.push_back(level_plane("plate", 0.5, 40));
        VolumeFrame frame(state);
        frame.scene.medium_grids = {cloud.grid};
        for (const glm::vec3& dark : frame.scatter().irradiance) EXPECT_LT(dark.y, 1e-30f);
        EXPECT_NEAR(frame.stats.counted("reference volume standard error"), lit ? 1 : 0, 0.1);
        // Rays are added as long as they may help.
        EXPECT_EQ(frame.stats.counted("reference volume passes"), lit ? 32 : 16);
    }
}

TEST(ReferenceMedia, LightsShareNoRandomNumbers) {
    scene::FrameState state = water_with_eye({0, -1, 0}, {0, 0, -1}, 8, 6);
    state.objects.clear();
    state.lights.assign(300, sun_from_zenith(0));
    Frame frame(state);
    frame.rays.emplace(frame.scene);
    const reference::WaterRays water(frame.scene);
    const reference::GlassBodies glass(frame.scene);
    const reference::OwnMedia media(frame.scene);
    std::set<std::uint64_t> seen;
    std::size_t rays = 0;
    for (const std::uint32_t index : {0u, 1u, 255u, 256u, 257u}) {
        const reference::Lamp lamp(frame.scene, *frame.rays, water, glass, media, index);
        reference::MediaProbe probe(media);
        for (const reference::Incoming& light : lamp.shine({0, 64}, 0, 64, probe)) {
            seen.insert(light.random);
            ++rays;
        }
    }
    EXPECT_EQ(rays, 5 * 64U);
    EXPECT_EQ(seen.size(), rays);
}

TEST(ReferenceMedia, MemoryHoldsTheEstimatesOfAllLayers) {
    scene::FrameState state = water_with_eye({0, -1, 0}, {0, 0, -1}, 8, 6);
    state.clip.samples = 64;
    scene::FrameState clear = state;
    clear.water->scattering = {0, 0, 0};
    const Reference method;
    constexpr std::size_t pixels = 1000000;
    // Mean and deviations of a pixel and of a segment in it, of both branches of all samples.
    constexpr std::size_t estimates = 64 * 2 * pixels * 2 * 2 * sizeof(glm::dvec3);
    EXPECT_GT(method.bytes(state, pixels), method.bytes(clear, pixels) + estimates);
}

TEST(ReferenceMedia, LightThroughMediaReachesTheFloor) {
    // E: through a cloud over the water, then scattering water and a box in it.
    Cloud cloud([](int x, int, int) { return 0.5 + 0.2 * x; });
    cloud.medium.transform.position = {0, 0.6, 0};
    cloud.medium.side = scene::MediumSide::air;
    scene::Medium box = box_of_smoke({0.1, -0.4, 0}, {0.4, 0.4, 0.4});
    scene::FrameState state = small_pool(3, 1, 1, 8);
    state.camera.position.y = -0.9;
    state.water->scattering = {0.2, 0.1, 0.4};
    state.media = {cloud.medium, box};
    state.lights = {sun_from_zenith(30)};
    state.caustics.reference = {0.01, 100};
    Frame frame(state);
    frame.scene.medium_grids = {cloud.grid, nullptr};
    const FlatFloor exact = flat_floor(30, 1, state.water->refractive_index);
    const double cos_t = 1 / exact.way;
    const glm::dvec3 air = state.lights[0].direction,
                     water(std::sin(glm::radians(30.0)) / state.water->refractive_index, -cos_t, 0);
    const Density smoke = cloud.density(), in_water = in_box(box);
    const LayerResult result = frame.render();
    for (const int channel : {0, 2}) {
        const auto floor = [&](double x, double z) {
            const glm::dvec3 end(x, -1, z), entry = end - exact.way * water;
            const double depth = exact.way * state.water->extinction()[channel] +
                                 box.extinction[channel] * column(in_water, end, -water, exact.way) +
                                 cloud.medium.extinction[channel] * column(smoke, entry, -air, 2);
            return state.lights[0].irradiance[channel] * exact.irradiance * std::exp(-depth);
        };
        const Agreement a = agreement(result, pixel_means(1, 8, floor), channel);
        EXPECT_LT(a.worst, kWorstT);
        // 60 steps through edges of the box: 2 % of a depth of 0.1 to 0.4.
        EXPECT_LT(std::abs(a.relative_mean), 0.005);
    }
}

TEST(ReferenceMedia, LightIsScatteredAbsorbedOrLands) {
    // Between waves and floor, in scattering water with a cloud in it: what is extinguished along the ways,
    // by the density at random places of them, and what lands are what entered.
    Cloud cloud([](int x, int y, int) { return 0.5 * x + 0.2 * y; });
    cloud.medium.transform.position = {0, -0.6, 0};
    scene::FrameState state = small_pool(1, 1.2, 1, 4);
    state.water->surface.waves.waves = {{0.4, 0, 0.012, 0.3}};
    state.water->scattering = {0.2, 0.1, 0.4};
    state.media = {cloud.medium};
    state.lights = {sun_from_zenith(30)};
    Frame frame(state);
    frame.scene.medium_grids = {cloud.grid};
    const rays::RayScene rays(frame.scene);
    const reference::ReceiverCharts charts(frame.scene);
    const reference::LightTracer tracer(frame.scene, rays, frame.chains, charts, {});
    const reference::LightPass pass{0, 1u << 18};
    const reference::Harvest harvest = tracer.trace(pass, 0, 0, tracer.strata(pass, 0), true);
    glm::dvec3 landed(0), lost(0), entered(0), scattered(0);
    for (const reference::Arrival& arrival : harvest.arrivals) landed += arrival.power;
    reference::MediaProbe probe(tracer.media());
    for (const reference::LightWay& way : harvest.ways) {
        entered += way.power;
        reference::RandomStream random{7, 8, way.random};
        ASSERT_TRUE(std::isfinite(way.length));
        const double at = way.length * random.next();
        const glm::dvec3 power = way.length * way.power *
                                 probe.transmittance(way.position, way.direction, at, way.in_water, random);
        lost += power * probe.extinction(way.position + at * way.direction, way.in_water);
        // Phase functions of water and cloud are isotropic here.
        scattered += 4 * glm::pi<double>() * power *
                     probe.scattering(way.position + at * way.direction, 0.3, way.in_water);
    }
    for (int channel = 0; channel < 3; ++channel) {
        printf("landed %.4f, lost %.4f (scattered %.4f) of %.4f\n", landed[channel], lost[channel],
               scattered[channel], entered[channel]);
        // One random place a way: over 16 passes the standard deviation was 1.2e-3.
        EXPECT_NEAR((landed[channel] + lost[channel]) / entered[channel], 1, 4e-3);
        EXPECT_GT(scattered[channel], 0.1 * lost[channel]);
        EXPECT_LT(scattered[channel], lost[channel]);
        EXPECT_GT(landed[channel], 0.1 * entered[channel]);
    }
}

TEST(ReferenceMedia, SameBitsOnAnyNumberOfThreads) {
    Cloud cloud([](int x, int, int) { return 0.5 * x; });
    cloud.medium.transform.position = {0, -0.5, 0};
    scene::FrameState state = water_with_eye({0.1, 0.6, 1}, {0, -0.8, -1}, 8, 6);
    state.water->surface.waves.waves = {{0.5, 0.3, 0.01, 0}};
    state.water->extent.size = {2, 2};
    state.media = {cloud.medium};
    state.caustics.reference = kOneRound;
    VolumeFrame frame(state);
    frame.scene.medium_grids = {cloud.grid};
    set_thread_count(1);
    const LayerResult one = frame.scatter();
    set_thread_count(2);
    EXPECT_EQ(frame.scatter().irradiance, one.irradiance);
    set_thread_count(0);
    EXPECT_GT(one.irradiance[20].y, 0);
}

TEST(ReferenceMedia, ResumesToTheSameBits) {
    scene::FrameState state = water_with_eye({0.1, -0.6, 1}, {0, -0.3, -1}, 8, 6);
    state.caustics.reference = {0.08, 4};
    const LayerResult whole = VolumeFrame(state).scatter();
    const TemporaryFolder folder;
    VolumeFrame broken(state);
    broken.checkpoint.file = folder / "progress";
    int calls = 0;
    broken.checkpoint.stop = [&] { return ++calls % 12 == 0; };
    std::optional<LayerResult> resumed;
    int interruptions = 0;
    while (!resumed && interruptions < 100) {
        try {
            resumed = broken.scatter();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::interrupted);
            ++interruptions;
        }
    }
    ASSERT_TRUE(resumed);
    EXPECT_GT(interruptions, 0);
    EXPECT_EQ(resumed->irradiance, whole.irradiance);
    EXPECT_EQ(resumed->data[1].values, whole.data[1].values);
    broken.stats = {};
    EXPECT_EQ(broken.scatter().irradiance, whole.irradiance);
    EXPECT_EQ(broken.stats.counted("reference volume rays"), 0);
}

}  // namespace
}  // namespace dapple
