// Hard cases as they are rendered: nothing crashes, every value is finite, and E is what it should be.
#include <gtest/gtest.h>

#include <fstream>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "hard_cases/hard_case.h"
#include "image/temporary_folder.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr double kIndex = 1.333;

struct Rendered {
    render::RenderedFrame frame;
    FrameStats stats;
    const std::vector<float>& values(const std::string& name) const {
        const image::Channel* channel = frame.linear.find(name);
        if (!channel) throw std::runtime_error("no channel " + name);
        return channel->values;
    }
    double mean(const std::string& name) const {
        double sum = 0;
        for (const float value : values(name)) sum += static_cast<double>(value);
        return sum / static_cast<double>(values(name).size());
    }
};

Rendered rendered(const scene::FrameState& state) {
    render::FrameRenderer renderer(test::validated_device());
    Rendered result;
    result.frame = renderer.render(state, result.stats);
    EXPECT_EQ(result.frame.non_finite.count, 0u) << result.frame.non_finite.first;
    return result;
}

double relative_l1(const Rendered& a, const Rendered& b) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < a.values("E.R").size(); ++i) {
        difference +=
            std::abs(static_cast<double>(a.values("E.R")[i]) - static_cast<double>(b.values("E.R")[i]));
        sum += std::abs(static_cast<double>(b.values("E.R")[i]));
    }
    EXPECT_GT(sum, 0);
    return difference / sum;
}

scene::FrameState sea_state(int pixels) {
    scene::FrameState state = test::clear_sea(4, 30, 160);
    state.clip.width = state.clip.height = pixels;
    state.camera.view_height = 2;
    state.camera.position.x = state.camera.target.x = 2 * std::tan(std::asin(0.5 / kIndex));
    state.water->surface.waves.waves = {test::wave(1, 10, 0.012), test::wave(0.6, 60, 0.005, 1),
                                        test::wave(0.45, -50, 0.003, 2)};
    return state;
}

TEST(TinyWaves, OfAMicrometreAreStillSeen) {
    scene::FrameState state = test::clear_sea(4, 0, 40 * 4);
    state.clip.width = state.clip.height = 64;
    state.camera.view_height = 2;
    const double k = glm::two_pi<double>() / 0.25, amplitude = 1e-6;
    state.water->surface.waves.waves = {test::wave(0.25, 0, amplitude)};
    const Rendered frame = rendered(state);
    const double flat = test::flat_floor(0, 2, kIndex).irradiance;
    // E / E_flat - 1 = -depth (n - 1) / n h'' to first order: +- 3.2e-4 here.
    const double depth = 2, contrast = depth * (kIndex - 1) / kIndex * amplitude * k * k;
    double worst = 0, largest = 0;
    for (int x = 0; x < 64; ++x) {
        const double at = 2.0 / 64 * (x - 31.5);
        // Mean over the pixel of the cosine.
        const double half = k / 64, expected = contrast * std::cos(k * at) * std::sin(half) / half;
        const double found =
            static_cast<double>(frame.values("E.R")[static_cast<std::size_t>(32 * 64 + x)]) / flat - 1;
        worst = std::max(worst, std::abs(found - expected));
        largest = std::max(largest, std::abs(found));
    }
    printf("amplitude 1e-6 m: contrast %.2e, off by %.1e\n", largest, worst);
    EXPECT_GT(largest, 0.8 * contrast);
    // Corners of beams of 2.5 cm rounded by 1e-7 m, and the mesh's 10 cells a wave: 3 % of the contrast.
    EXPECT_LT(worst, 0.1 * contrast);
}

class FarAway : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Kilometres, FarAway, testing::Values(10.0, 100.0));

TEST_P(FarAway, IsAsAtTheOrigin) {
    const glm::dvec3 shift(1000 * GetParam(), 0, -1000 * GetParam());
    for (const bool lamp : {false, true}) {
        scene::FrameState near = sea_state(64);
        scene::Object column;
        column.shape = scene::Shape::box;
        column.size = {0.2, 3, 0.2};
        column.transform.position = {1, -1, 0.1};
        near.objects.push_back(column);
        if (lamp) {
            near.lights[0].type = scene::LightType::point;
            near.lights[0].position = {0.3, 1.5, -0.2};
            near.lights[0].intensity = glm::dvec3(5);
        }
        scene::FrameState far = near;
        far.camera.position += shift;
        far.camera.target += shift;
        far.water->extent.center += glm::dvec2(shift.x, shift.z);
        for (scene::Wave& w : far.water->surface.waves.waves) {
            // The same waves: the phase at the origin is what the way back to it takes.
            const double k = glm::two_pi<double>() / w.length;
            w.phase -= k * (std::cos(w.heading) * shift.x + std::sin(w.heading) * shift.z);
        }
        for (scene::Object& object : far.objects) object.transform.position += shift;
        far.lights[0].position += shift;
        const double l1 = relative_l1(rendered(far), rendered(near));
        printf("%s, %.0f km away: E off by %.1e (L1)\n", lamp ? "lamp" : "sun", GetParam(), l1);
        EXPECT_LT(l1, 1e-4);
    }
}

/// A sea of 4 m and 40 x 40 cells in a file of floats, about a centre.
void write_float_sea(const std::string& path, double center) {
    std::ofstream file(path, std::ios::binary);
    file << "ply\nformat binary_little_endian 1.0\nelement vertex 1681\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1600\nproperty list uchar int vertex_indices\nend_header\n";
    for (int j = 0; j <= 40; ++j)
        for (int i = 0; i <= 40; ++i) {
            const float p[3] = {static_cast<float>(center + 0.1 * i - 2),
                                static_cast<float>(0.01 * std::sin(0.7 * i + 0.3 * j)),
                                static_cast<float>(0.1 * j - 2)};
            file.write(reinterpret_cast<const char*>(p), sizeof p);
        }
    for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i) {
            const int a = j * 41 + i, corners[4] = {a, a + 41, a + 42, a + 1};
            file.put(4);
            file.write(reinterpret_cast<const char*>(corners), sizeof corners);
        }
}

TEST(FarAway, FloatsOfAFileThatCannotHoldItAreSaid) {
    const test::TemporaryFolder folder;
    for (const double center : {0.0, 1e4, 1e5}) {
        scene::FrameState state = sea_state(16);
        write_float_sea(folder / "sea.0001.ply", center);
        state.water->surface.type = scene::WaterSurfaceType::mesh_sequence;
        state.water->surface.mesh_sequence.pattern = folder / "sea.%04d.ply";
        state.water->extent.center.x = center;
        state.camera.position.x += center;
        state.camera.target.x += center;
        const Rendered frame = rendered(state);
        const std::string& said = frame.frame.plan.at(0).reason;
        EXPECT_EQ(said.find("floats") != std::string::npos, center > 0) << center << ": " << said;
        if (center > 0) printf("%g m: %s\n", center, said.c_str());
    }
}

TEST(Camera, AtAndAcrossTheSurfaceSeesTheSameFloor) {
    const double expected = test::flat_floor(30, 2, kIndex).irradiance;
    for (const double height : {-0.1, -1e-4, -1e-7, -1e-12, 0.0, 1e-12, 1e-7, 1e-4, 0.1}) {
        scene::FrameState state = test::clear_sea(20, 30, 2);
        state.clip.width = 32;
        state.clip.height = 18;
        state.camera.projection = scene::Projection::perspective;
        state.camera.position = {0, height, 0};
        state.camera.target = {2, height - 1.5, 0.3};
        state.camera.up = {0, 1, 0};
        state.water->surface.waves.waves.clear();
        const Rendered flat = rendered(state);
        std::size_t seen = 0;
        for (std::size_t i = 0; i < flat.values("E.R").size(); ++i) {
            if (!(flat.values("covered")[i] > 0) || flat.values("P.X")[i] > 8) continue;
            ++seen;
            // Corners of beams of 10 m are rounded by 1e-6 of their size.
            EXPECT_NEAR(flat.values("E.R")[i], expected, 1e-4 * expected) << height;
        }
        EXPECT_GT(seen, 400u) << height;
        // And with waves, in whose crests and troughs it then is.
        state.water->mesh_cells = 200;
        state.water->surface.waves.waves = {test::wave(2, 0, 0.05, height * 50), test::wave(0.7, 70, 0.01)};
        const Rendered wavy = rendered(state);
        EXPECT_GT(wavy.mean("A"), 0.9) << height;
        EXPECT_GT(wavy.mean("E.R"), 0) << height;
    }
}

TEST(Camera, UnderWaterSeesTotalReflection) {
    scene::FrameState state = sea_state(0);
    state.clip.width = 48;
    state.clip.height = 27;
    state.camera.projection = scene::Projection::perspective;
    state.camera.position = {-1, -1, 0};
    state.camera.target = {1, -0.4, 0};  // beyond the critical angle: the floor in the water's mirror
    state.camera.up = {0, 1, 0};
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0.5, -1, 0.2};
    state.lights.push_back(lamp);
    const Rendered frame = rendered(state);
    EXPECT_GT(frame.mean("A"), 0.9);  // the rest passes the floor's end
    EXPECT_GT(frame.mean("caustics.R"), 0);
}

TEST(Sun, BelowTheHorizonLeavesItDark) {
    scene::FrameState state = sea_state(32);
    state.lights = {test::white_sun(95)};
    const Rendered frame = rendered(state);
    EXPECT_EQ(frame.mean("E.R"), 0);
    EXPECT_EQ(frame.mean("R"), 0);
}

TEST(Pictures, OfOnePixelHoldTheMean) {
    const Rendered many = rendered(sea_state(64)), one = rendered(sea_state(1));
    // Both are the light on the same square; by clipping 4096 times or once.
    EXPECT_NEAR(one.mean("E.R"), many.mean("E.R"), 1e-5 * many.mean("E.R"));
}

TEST(Pictures, VeryWideAndVeryHighHoldTheMean) {
    scene::FrameState wide = sea_state(1);
    wide.clip.width = 8192;
    wide.camera.view_height = 2.0 / 8192;
    const Rendered row = rendered(wide);
    // The same line as a picture of 64 parts.
    scene::FrameState coarse = wide;
    coarse.clip.width = 64;
    coarse.camera.view_height = 2.0 / 64;
    EXPECT_EQ(row.values("E.R").size(), 8192u);
    // A line of 0.2 mm against one of 3 cm: waves of 0.45 m change a little across it.
    EXPECT_NEAR(row.mean("E.R"), rendered(coarse).mean("E.R"), 0.02 * row.mean("E.R"));
    scene::FrameState high = sea_state(1);
    high.clip.height = 8192;
    high.camera.view_height = 2;
    EXPECT_GT(rendered(high).mean("E.R"), 0);
}

class LargeSea : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(SunFromZenith, LargeSea, testing::Values(0.0, 40.0));

TEST_P(LargeSea, SeenToFiveDegreesBelowTheHorizonIsBounded) {
    scene::FrameState state = test::clear_sea(1000, GetParam(), 0);
    state.clip.width = 8;
    state.clip.height = 4;
    state.camera.projection = scene::Projection::perspective;
    state.camera.field_of_view = glm::radians(7.0);
    state.camera.position = {-450, 60, 0};
    // From 5 to 12 degrees below the horizon: 280 to 690 m away, where pixels are up to 20 m wide and 200 m
    // long, beams 1 m.
    state.camera.target =
        state.camera.position + glm::dvec3(std::cos(glm::radians(8.5)), -std::sin(glm::radians(8.5)), 0);
    state.camera.up = {0, 1, 0};
    state.objects[0].transform.position.y = -20;
    state.objects[0].size = {4000, 1, 4000};
    state.water->surface.waves.waves = {test::wave(30, 0, 0.3), test::wave(12, 40, 0.08, 1),
                                        test::wave(7, -30, 0.03, 2)};
    const double level = test::flat_floor(GetParam(), 20, kIndex).irradiance;
    std::vector<float> open_sea;
    for (const bool pile : {false, true}) {
        if (pile) {  // beams are opened where an object may stand in their way
            scene::Object box;
            box.shape = scene::Shape::box;
            box.size = {2, 50, 2};
            box.transform.position = {0, -5, 10};
            state.objects.push_back(box);
        }
        const double start = cpu_seconds();
        const Rendered frame = rendered(state);
        const double spent = cpu_seconds() - start, paths = frame.stats.counted("camera paths");
        printf(
            "large sea%s: %.0f triangles, %.1f s of CPU; a path: clusters %.0f, whole nodes %.0f, "
            "shadow rays %.0f\n",
            pile ? " with a pile" : "", frame.stats.counted("water triangles"), spent,
            frame.stats.counted("beam clusters found") / paths,
            frame.stats.counted("nodes added whole") / paths,
            frame.stats.counted("caustic shadow rays") / paths);
        for (const PassTime& pass : frame.stats.passes())
            if (pass.cpu_s > 0.05) printf("  %s %.2f s\n", pass.name.c_str(), pass.cpu_s);
        EXPECT_LT(spent, 20) << "seconds, not minutes, also on a busy machine";
        const std::vector<float>& found = frame.values("E.R");
        if (!pile) {
            open_sea = found;
            // A pixel holds many waves, whose light comes to that of flat water: all but what lies across its
            // border, and Fresnel's curvature over slopes of 0.06.
            double mean = 0;
            for (const float value : found) {
                EXPECT_NEAR(value, level, 0.15 * level);
                mean += static_cast<double>(value) / level / static_cast<double>(found.size());
            }
            printf("  E over that of flat water: %.4f in the mean\n", mean);
            EXPECT_NEAR(mean, 1, 0.01);
        } else {
            // The pile only takes away, and from few pixels; where it takes nothing, single beams come to
            // what all together did: corners of beams of 1 m are rounded by 3e-5 m, 700 m from the origin.
            std::size_t same = 0, darker = 0;
            for (std::size_t i = 0; i < found.size(); ++i) {
                EXPECT_LT(found[i], open_sea[i] * (1 + 5e-4f));
                same += found[i] > open_sea[i] * (1 - 5e-4f) ? 1 : 0;
                darker += found[i] < open_sea[i] * (1 - 2e-3f) ? 1 : 0;
            }
            printf("  %zu pixels the same, %zu darker\n", same, darker);
            EXPECT_GT(same, found.size() / 2);
            if (GetParam() > 0) {
                EXPECT_GT(darker, 0u);
            }  // overhead it shadows its own foot only
        }
    }
}

}  // namespace
}  // namespace dapple
