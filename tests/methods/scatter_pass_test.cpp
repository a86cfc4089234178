// Scattered light by the device against its closed form and against the CPU's.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "closed_form/gentle_sea.h"
#include "closed_form/segment_row.h"
#include "gpu/validated_device.h"
#include "methods/sliced_beams/sliced_beams.h"
#include "methods/sliced_beams/volume_light.h"
#include "ocean/grid_size.h"

namespace dapple {
namespace {

using namespace methods::sliced_beams;
using light::Event;
using test::Ends;
using test::SheetSet;

/// S of segments by all sheets of a scene, and what each side did of it.
struct Scattered {
    std::vector<glm::vec3> values;
    ScatterCounts cpu, device;
    FrameStats stats;
};

Scattered scattered(const scene::FrameScene& scene, const SheetSet<float>& set, const std::vector<Ends>& ends,
                    ScatterPass* pass) {
    Scattered result;
    const view::SegmentLayer layer = test::row_of_segments(ends);
    const VolumeLight light(scene, set.sheets(), result.stats, pass);
    result.values.resize(layer.segments(), glm::vec3(0));
    light.add(layer, result.values, result.cpu);
    light.add_on_device(layer, result.values, result.device, result.stats);
    return result;
}

/// Largest difference over all channels, in parts of the larger of a value and the mean.
struct Difference {
    double largest = 0, mean = 0;
};
Difference difference(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
    glm::dvec3 mean(0);
    for (const glm::vec3& v : a) mean += glm::dvec3(v) / static_cast<double>(a.size());
    Difference result;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const double off = std::abs(static_cast<double>(a[i][c]) - static_cast<double>(b[i][c])) /
                               std::max(mean[c], static_cast<double>(a[i][c]));
            result.largest = std::max(result.largest, off);
            result.mean += off / (3 * static_cast<double>(a.size()));
        }
    }
    return result;
}

constexpr double kIndex = 1.333;

TEST(ScatterPass, HasTheClosedFormUnderFlatWater) {
    ScatterPass pass(test::validated_device());
    for (const double zenith : {0.0, 30.0, 70.0}) {
        for (const double murk : {1.0, 0.01}) {
            scene::FrameScene scene = test::scene_of_flat_water({24, 20}, 117, 90);
            scene.state.lights = {test::sun_from_zenith(zenith)};
            scene.state.water->absorption = murk * glm::dvec3(0.4, 0.1, 0.03);
            scene.state.water->scattering = murk * glm::dvec3(0.2, 0.3, 0.05);
            const SheetSet<float> set(scene, Event::transmission, 6);
            const double sin_t = std::sin(glm::radians(zenith)) / kIndex,
                         cos_t = std::sqrt(1 - sin_t * sin_t);
            std::vector<Ends> ends;
            for (const double depth : {0.2, 0.9, 2.5}) {
                const glm::dvec3 from(depth * sin_t / cos_t, -depth, 0.1);
                const auto add = [&](glm::dvec3 way) { ends.push_back({from, from + way}); };
                for (int i = 0; i < 8; ++i)  // level
                    add(2.3 * glm::dvec3(std::cos(0.8 * i), 0, std::sin(0.8 * i)));
                add({0, -3, 0});
                add({0, depth, 0});
                for (int i = 0; i < 12; ++i) {  // oblique
                    const glm::dvec3 d(std::cos(1.1 * i), 0.7 * std::sin(2.3 * i), std::sin(1.1 * i));
                    add((d.y > 0 ? std::min(4.0, 0.9 * depth / d.y) : 1.5) * d);
                }
                // Towards the light, where it is dimmed alike all along, and against it.
                add(0.99 * depth / cos_t * glm::dvec3(-sin_t, cos_t, 0));
                add(2.0 * glm::dvec3(sin_t, -cos_t, 0));
            }
            const Scattered result = scattered(scene, set, ends, &pass);
            EXPECT_EQ(result.cpu.beams, 0u);
            const test::FlatFloor surface = test::flat_floor(zenith, 1, kIndex);
            double largest = 0;
            for (std::size_t i = 0; i < ends.size(); ++i) {
                const double length = glm::length(ends[i].to - ends[i].from);
                const glm::dvec3 direction = (ends[i].to - ends[i].from) / length;
                for (int c = 0; c < 3; ++c) {
                    const double extinction = scene.state.water->extinction()[c];
                    const double a = extinction * (1 - direction.y / cos_t);
                    const double way = std::abs(a * length) > 1e-12 ? -std::expm1(-a * length) / a : length;
                    const double expected = scene.state.water->scattering[c] * 0.25 / glm::pi<double>() *
                                            scene.state.lights[0].irradiance[c] * surface.irradiance / cos_t *
                                            std::exp(extinction * ends[i].from.y / cos_t) * way;
                    largest =
                        std::max(largest, std::abs(static_cast<double>(result.values[i][c]) / expected - 1));
                }
            }
            printf("sun %2.0f deg from the zenith, murk %.2f: %.1e\n", zenith, murk, largest);
            // As of the CPU: places are rounded to 1e-6 m.
            EXPECT_LE(largest, 5e-6);
        }
    }
}

/// A sea with foci over a pool; segments from the surface and from within it, also across the sun's axis.
scene::FrameScene rough_pool(double scale, int cells, int cells_across, double width) {
    scene::FrameScene scene = test::scene_of_water(
        {6, width}, cells, cells_across, [scale, waves = test::gentle_waves().waves](double x, double z) {
            glm::dvec3 h(0);
            for (const scene::Wave& wave : waves) {
                const glm::dvec2 k = 2 * glm::pi<double>() / wave.length *
                                     glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
                const double phase = k.x * x + k.y * z + wave.phase;
                h += scale * wave.amplitude *
                     glm::dvec3(std::cos(phase), -k.x * std::sin(phase), -k.y * std::sin(phase));
            }
            return h;
        });
    scene.state.lights = {test::sun_from_zenith(25)};
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    scene.state.water->absorption = {0.3, 0.1, 0.05};
    return scene;
}

scene::FrameScene rough_pool(double scale, int cells) {
    return rough_pool(scale, cells, cells, 6);
}

std::vector<Ends> random_ends(int count, double deepest) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<Ends> ends;
    for (int i = 0; i < count; ++i) {
        const auto point = [&](double depth) {
            return glm::dvec3(2 * uniform(random), -depth, 2 * uniform(random));
        };
        // From a little above the water's troughs, or from anywhere within.
        const double from = i % 2 == 0 ? 0.01 * uniform(random) : deepest * (0.5 + 0.5 * uniform(random));
        ends.push_back({point(from), point(deepest * (0.5 + 0.5 * uniform(random)))});
    }
    return ends;
}

void expect_equal(const Scattered& cpu, const Scattered& device, double largest, double mean) {
    const Difference off = difference(cpu.values, device.values);
    printf(
        "off by %.1e, mean %.1e; %zu intervals (CPU %zu), %zu peaks (%zu), %zu cut (%zu), %zu foci (%zu)\n",
        off.largest, off.mean, device.device.intervals, cpu.cpu.intervals, device.device.peaks, cpu.cpu.peaks,
        device.device.cut, cpu.cpu.cut, device.device.foci, cpu.cpu.foci);
    EXPECT_LE(off.largest, largest);
    EXPECT_LE(off.mean, mean);
}

TEST(ScatterPass, EqualsTheCpuUnderWavesOverAFloor) {
    scene::FrameScene scene = rough_pool(3, 120);
    scene.state.objects = {test::level_plane("floor", -2, 30)};
    ScatterPass pass(test::validated_device());
    const std::vector<Ends> ends = random_ends(500, 2);
    const SheetSet<float> set(scene, Event::transmission, 3);
    for (const scene::PhaseType type :
         {scene::PhaseType::isotropic, scene::PhaseType::two_lobe, scene::PhaseType::fournier_forand}) {
        scene.state.water->phase.type = type;
        scene.state.water->phase.anisotropy = 0.9;
        const Scattered cpu = scattered(scene, set, ends, nullptr);
        const Scattered device = scattered(scene, set, ends, &pass);
        EXPECT_EQ(device.cpu.beams, 0u);
        EXPECT_GT(device.device.cut, 100u);
        // Places are rounded to 1e-7 m, 1e-5 of a beam's width: light that one beam loses its neighbour gets,
        // so that of hundreds of intervals less is left. Two nodes on the CPU are right to 1e-5 where the
        // area changes most.
        expect_equal(cpu, device, 1e-5, 1e-6);
    }
}

/// S of the first channel.
std::vector<double> in_double(const scene::FrameScene& scene, const std::vector<Ends>& ends) {
    const SheetSet<double> set(scene, Event::transmission, 8);
    const ScatterSheet<double> sheet(*set.sheets().front());
    const media::Media media(scene);
    const PhaseTable<double> phase(media, 0);
    const EvenMedium<double> medium(scene.state.water->extinction(), scene.state.water->scattering, phase);
    std::vector<double> values;
    for (std::size_t first = 0; first < ends.size(); first += kLanes<double>) {
        SegmentGroup<double> group;
        for (std::size_t lane = 0; lane < kLanes<double>; ++lane) {
            const auto& [from, to] = ends[first + lane];
            const glm::dvec3 direction = glm::normalize(to - from);
            for (int k = 0; k < 3; ++k) {
                group.origin[k][lane] = from[k];
                group.direction[k][lane] = direction[k];
            }
            group.length[lane] = glm::length(to - from);
        }
        Lanes<double> radiance[3] = {};
        ScatterCounts counts;
        sheet.add(group, sheet.direction({0, 0}), medium, nullptr, radiance, counts);
        for (int lane = 0; lane < kLanes<double>; ++lane) values.push_back(radiance[0][lane]);
    }
    return values;
}

TEST(ScatterPass, IsRightWhereBeamsAreFocused) {
    // A cone of light: h makes all rays of the lens meet in one point, up to the mesh.
    constexpr double kCurvature = 0.8, kFocus = 1.333 / 0.333 / kCurvature;
    scene::FrameScene scene = test::scene_of_water({1, 1}, 64, 64, [](double x, double z) {
        return glm::dvec3(-0.5 * kCurvature * (x * x + z * z), -kCurvature * x, -kCurvature * z);
    });
    scene.state.lights = {test::sun_from_zenith(0)};
    scene.state.water->scattering = {0.1, 0.1, 0.1};
    scene.state.water->absorption = {0.1, 0, 0.02};
    ScatterPass pass(test::validated_device());
    std::vector<Ends> ends;
    for (int i = 0; i < 200; ++i) {
        const double turn = 0.37 * i;
        const glm::dvec3 across(std::cos(turn), 0, std::sin(turn));
        const auto at = [&](double off, double depth) { return off * across - glm::dvec3(0, depth, 0); };
        if (i % 2 == 0)  // past the focus, 8 to 14 mm beside it
            ends.push_back({at(0.02, 0.1), at(0.02 - 0.02 * (0.42 + 0.42 * i / 200), 7)});
        else  // along the light, to 10 cm above the focus
            ends.push_back({at(1e-3 * i, 0.1), at(1e-3 * i * 0.1 / (kFocus - 0.1), kFocus - 0.1)});
    }
    const SheetSet<float> set(scene, Event::transmission, 8);
    const Scattered device = scattered(scene, set, ends, &pass);
    EXPECT_GT(device.device.peaks, 100u);
    // Against double. Beams are 0.1 mm wide there, and places rounded to 1e-7 m: each beam's light is right
    // to 1e-3.
    const std::vector<double> exact = in_double(scene, ends);
    double largest = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
        largest = std::max(largest, std::abs(static_cast<double>(device.values[i].x) / exact[i] - 1));
    printf("lens: off by %.1e, %zu intervals, %zu peaks, %zu foci\n", largest, device.device.intervals,
           device.device.peaks, device.device.foci);
    EXPECT_LE(largest, 3e-3);
    // Through the focus and on the axis, in hardly any length and in dense water.
    std::vector<Ends> hard;
    for (const double y : {-kFocus, -kFocus + 1e-6, -kFocus - 1e-3, -0.999 * kFocus, -1e-7, -1e-3})
        for (const double z : {0.0, 1e-9, 1e-5, 1e-3}) hard.push_back({{-1, y, z}, {1, y, z}});
    for (const double x : {0.0, 1e-7, 0.015625, 0.1}) {
        hard.push_back({{x, -0.02, 0}, {x, -7, 0}});
        hard.push_back({{x, -0.1, 0}, {0, -kFocus, 0}});
        hard.push_back({{x, -0.1, x}, {x, -0.1 - 1e-7, x}});
    }
    for (const double density : {0.1, 1e4}) {
        scene.state.water->scattering = glm::dvec3(density);
        const Scattered result = scattered(scene, set, hard, &pass);
        EXPECT_GT(result.device.intervals, 0u);
        for (const glm::vec3& value : result.values)
            for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(value[c]) && value[c] >= 0) << value[c];
    }
}

TEST(ScatterPass, LeavesShadowsToTheCpu) {
    scene::FrameScene scene = rough_pool(1, 60);
    const auto add = [&](scene::Shape shape, glm::dvec3 position, glm::dvec3 size) {
        scene::Object& object = scene.state.objects.emplace_back();
        object.shape = shape;
        object.size = size;
        object.radius = 0.5 * size.x;
        object.transform.position = position;
    };
    add(scene::Shape::plane, {0, -2, 0}, {8, 1, 8});
    add(scene::Shape::box, {0.5, -0.8, 0.4}, {0.3, 2.6, 0.3});
    add(scene::Shape::sphere, {-0.8, -1, -0.3}, {0.7, 0, 0});
    scene.state.lights[0].angular_diameter = 0.53 * scene::kDegree;
    scene.state.caustics.sliced_beams.volume_sun_samples = 2;
    ScatterPass pass(test::validated_device());
    const std::vector<Ends> ends = random_ends(300, 2);
    const SheetSet<float> set(scene, Event::transmission, 3);
    const Scattered cpu = scattered(scene, set, ends, nullptr);
    const Scattered device = scattered(scene, set, ends, &pass);
    EXPECT_GT(device.cpu.shadow_tests, 1000u);
    EXPECT_EQ(device.cpu.shadow_tests, cpu.cpu.shadow_tests);
    EXPECT_GT(device.device.intervals, device.cpu.intervals);
    EXPECT_EQ(device.stats.counted("segments walked on the device"), 600);
    expect_equal(cpu, device, 1e-5, 1e-6);
}

TEST(ScatterPass, LeavesBoundedMediaToTheCpu) {
    scene::FrameScene scene = rough_pool(1, 20);
    scene::Medium& box = scene.state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.side = scene::MediumSide::water;
    box.size = {1, 1, 1};
    ScatterPass pass(test::validated_device());
    const SheetSet<float> set(scene, Event::transmission, 3);
    const Scattered device = scattered(scene, set, random_ends(8, 2), &pass);
    EXPECT_EQ(device.stats.counted("segments walked on the device"), 0);
    EXPECT_EQ(device.values, scattered(scene, set, random_ends(8, 2), nullptr).values);
}

TEST(ScatterPass, WalksLongWaysInParts) {
    // More beams on one segment than a dispatch goes through.
    const scene::FrameScene scene = rough_pool(1, 1000, 40, 0.5);
    ScatterPass pass(test::validated_device());
    const std::vector<Ends> ends = {{{-2.7, -0.5, -0.1}, {2.8, -0.4, 0.1}}, {{0, -0.1, 0}, {0.1, -0.2, 0}}};
    const SheetSet<float> set(scene, Event::transmission, 3);
    const Scattered device = scattered(scene, set, ends, &pass);
    EXPECT_GT(device.device.beams + device.device.intervals, 4096u);
    expect_equal(scattered(scene, set, ends, nullptr), device, 1e-5, 1e-6);
}

TEST(ScatterPass, GivesTheSameBitsWhateverGoesTogether) {
    const scene::FrameScene scene = rough_pool(3, 60);
    ScatterPass pass(test::validated_device());
    std::vector<Ends> ends = random_ends(200, 2);
    const SheetSet<float> set(scene, Event::transmission, 3);
    const Scattered first = scattered(scene, set, ends, &pass);
    EXPECT_EQ(scattered(scene, set, ends, &pass).values, first.values);
    std::reverse(ends.begin(), ends.end());
    std::vector<glm::vec3> reversed = scattered(scene, set, ends, &pass).values;
    std::reverse(reversed.begin(), reversed.end());
    EXPECT_EQ(reversed, first.values);
}

TEST(ScatterPass, IsChosenByTheTypeOfTheDevice) {
    scene::FrameScene scene = rough_pool(1, 20);
    scene.state.clip.samples = 1;
    const rays::RayScene rays(scene);
    const view::SegmentLayer layer = test::row_of_segments(random_ends(8, 2));
    gpu::Device& device = test::validated_device();
    const auto walked = [&](methods::CoverageBackend backend) {
        FrameStats stats;
        methods::FrameContext context{scene, rays, device, stats, {{0, Event::transmission}}};
        methods::SlicedBeams method(backend);
        method.begin(context);
        std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
        method.in_scatter(context, layer, radiance);
        EXPECT_GT(radiance[0].x, 0);
        return stats.counted("segments walked on the device") > 0;
    };
    EXPECT_TRUE(walked(methods::CoverageBackend::compute));
    EXPECT_FALSE(walked(methods::CoverageBackend::cpu));
    EXPECT_EQ(walked(methods::CoverageBackend::automatic), device.info().type != gpu::DeviceType::cpu);
    // So is the memory that its copy of the beams takes.
    const methods::SlicedBeams method;
    scene.state.water->mesh_cells = 100;
    const auto triangles = static_cast<double>(ocean::grid_size(*scene.state.water).triangles());
    EXPECT_EQ(method.bytes_on(gpu::DeviceType::cpu, scene.state), 0U);
    EXPECT_GT(static_cast<double>(method.bytes_on(gpu::DeviceType::discrete, scene.state)), 80 * triangles);
    scene.state.water->scattering = glm::dvec3(0);
    EXPECT_EQ(method.bytes_on(gpu::DeviceType::discrete, scene.state), 0U);
}

}  // namespace
}  // namespace dapple
