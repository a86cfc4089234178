// The filters over E: what they keep, what they do not touch, how far they reach.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "denoise/filter.h"
#include "denoise/layers.h"
#include "denoise/line_filter.h"

namespace dapple {
namespace {

using denoise::LinePixel;
using scene::DenoiseFilter;

constexpr float kLight = 3;  ///< W/m^2, of the weakest light

scene::Denoise adaptive(int passes = 1) {
    scene::Denoise settings;
    settings.filter = DenoiseFilter::adaptive;
    settings.passes = passes;
    return settings;
}

scene::Denoise fixed(int passes = 1) {
    scene::Denoise settings = adaptive(passes);
    settings.filter = DenoiseFilter::fixed;
    return settings;
}

scene::Denoise as_printed(scene::Denoise settings) {
    settings.paper_faithful = true;
    return settings;
}

struct Filtered {
    std::vector<glm::vec3> irradiance;
    denoise::FilteredPower power;
};

Filtered filtered(const view::ReceiverLayer& layer, std::vector<glm::vec3> irradiance,
                  const scene::Denoise& settings) {
    const std::vector<std::uint8_t> covered(layer.pixels(), 1);
    const denoise::FilteredPower power =
        denoise::filter_irradiance(layer, covered, settings, kLight, irradiance);
    return {std::move(irradiance), power};
}

/// A plane seen obliquely: footprints grow from row to row.
view::ReceiverLayer oblique_layer(int width, int height) {
    view::ReceiverLayer layer = test::plane_layer(width, height, 0.02f);
    float z = 0;
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
        const float size = 0.02f * (1 + 0.03f * static_cast<float>(y));
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
            const std::size_t i = y * static_cast<std::size_t>(width) + x;
            layer.position[i] = {size * static_cast<float>(x), -2, z};
            layer.footprint_u[i] = {size, 0, 0};
            layer.footprint_v[i] = {0, 0, size * size / 0.02f};
        }
        z += size * size / 0.02f;
    }
    return layer;
}

/// Light is exchanged pair by pair, so power is kept but for floats: each of some 30 taps rounds to 6e-8 of
/// E, errors of either sign.
TEST(Denoise, KeepsThePowerOfSparseSplats) {
    for (const view::ReceiverLayer& layer : {test::plane_layer(96, 80, 0.01f), oblique_layer(96, 80)}) {
        for (const scene::Denoise& settings : {adaptive(1), adaptive(4), fixed(10)}) {
            for (const int every : {20, 200}) {
                const std::vector<glm::vec3> splats = test::sparse_splats(layer, every, 20);
                const Filtered found = filtered(layer, splats, settings);
                EXPECT_GT(found.power.before, 0);
                EXPECT_NEAR(found.power.after / found.power.before, 1, 1e-5);
                EXPECT_LT(std::max_element(found.irradiance.begin(), found.irradiance.end(),
                                           [](auto& a, auto& b) { return a.x < b.x; })
                              ->x,
                          10.0f);  // it does something
            }
        }
    }
}

/// The power that is told is the sum of E over footprints, W, the mean over channels.
TEST(Denoise, TellsPower) {
    const view::ReceiverLayer layer = test::plane_layer(8, 5, 0.5f);
    std::vector<glm::vec3> irradiance(40, glm::vec3(0));
    irradiance[13] = {3, 6, 9};
    const Filtered found = filtered(layer, irradiance, adaptive());
    EXPECT_DOUBLE_EQ(found.power.before, 6 * 0.25);
    double sum = 0;
    for (const glm::vec3& e : found.irradiance) sum += static_cast<double>(e.x + e.y + e.z) / 3 * 0.25;
    EXPECT_NEAR(found.power.after, sum, 1e-6);
}

/// Differences of equal numbers are 0.
TEST(Denoise, ConstantsStayToTheBit) {
    const view::ReceiverLayer layer = oblique_layer(50, 40);
    const std::vector<glm::vec3> constant(layer.pixels(), glm::vec3(0.1f, 1.7f, 0.03f));
    EXPECT_EQ(filtered(layer, constant, adaptive(3)).irradiance, constant);
    EXPECT_EQ(filtered(layer, constant, fixed(3)).irradiance, constant);
    // The paper's mean rounds: six times some ten additions of 6e-8 times 1.7.
    for (const glm::vec3& e : filtered(layer, constant, as_printed(adaptive(3))).irradiance)
        EXPECT_NEAR(e.y, 1.7f, 1e-5f);
}

/// A step edge on a plane is softened: power stays, and values lie between the sides'.
TEST(Denoise, StepsAreSoftenedWithoutOvershoot) {
    const view::ReceiverLayer layer = oblique_layer(60, 40);
    std::vector<glm::vec3> step(layer.pixels());
    for (std::size_t i = 0; i < step.size(); ++i) step[i] = glm::vec3(i % 60 < 30 ? 0.01f : 4.0f);
    const Filtered found = filtered(layer, step, adaptive(2));
    EXPECT_NEAR(found.power.after / found.power.before, 1, 1e-5);
    for (const glm::vec3& e : found.irradiance) {
        EXPECT_GE(e.x, 0.01f * (1 - 1e-6f));
        EXPECT_LE(e.x, 4.0f * (1 + 1e-6f));
    }
    EXPECT_GT(found.irradiance[29].x, 0.1f);
    // Two passes reach 30 pixels: rows of the far ends are not met.
    EXPECT_EQ(found.irradiance[59].x, 4.0f);
}

/// Beyond an edge nothing arrives, however many passes.
TEST(Denoise, NothingCrossesEdges) {
    const auto crosses = [](const auto& change) {
        view::ReceiverLayer layer = test::plane_layer(40, 24, 0.01f);
        std::vector<glm::vec3> lit(layer.pixels(), glm::vec3(0));
        for (std::size_t i = 0; i < lit.size(); ++i) {
            if (i % 40 < 20) {
                lit[i] = glm::vec3(5 * test::random_number(i, 1));
            } else {
                change(layer, i);
            }
        }
        float most = 0;
        for (const scene::Denoise& settings : {adaptive(6), fixed(6)}) {
            const Filtered found = filtered(layer, lit, settings);
            EXPECT_NEAR(found.power.after / found.power.before, 1, 1e-5);
            for (std::size_t i = 0; i < lit.size(); ++i)
                if (i % 40 >= 20) most = std::max(most, found.irradiance[i].x);
        }
        return most;
    };
    EXPECT_GT(crosses([](view::ReceiverLayer&, std::size_t) {}), 0.01f);
    EXPECT_EQ(crosses([](view::ReceiverLayer& layer, std::size_t i) { layer.object[i] = 1; }), 0);
    EXPECT_EQ(crosses([](view::ReceiverLayer& layer, std::size_t i) { layer.flags[i] = view::kReceiver; }),
              0);
    EXPECT_EQ(crosses([](view::ReceiverLayer& layer, std::size_t i) { layer.position[i].y -= 0.05f; }), 0);
    EXPECT_EQ(crosses([](view::ReceiverLayer& layer, std::size_t i) {
                  layer.shading_normal[i] = {0, 0, 1};
              }),
              0);
}

TEST(Denoise, LeavesWhatIsNotCoveredAlone) {
    const view::ReceiverLayer layer = test::plane_layer(20, 10, 0.01f);
    std::vector<glm::vec3> irradiance(layer.pixels(), glm::vec3(1));
    std::vector<std::uint8_t> covered(layer.pixels(), 1);
    covered[55] = 0;
    irradiance[55] = glm::vec3(0);
    irradiance[56] = glm::vec3(std::nanf(""));
    const denoise::FilteredPower power =
        denoise::filter_irradiance(layer, covered, adaptive(3), kLight, irradiance);
    EXPECT_NEAR(power.before, 198 * 1e-4, 1e-8);
    for (std::size_t i = 0; i < irradiance.size(); ++i)
        if (i != 55 && i != 56) {
            EXPECT_EQ(irradiance[i], glm::vec3(1)) << i;
        }
    EXPECT_EQ(irradiance[55], glm::vec3(0));
    EXPECT_TRUE(std::isnan(irradiance[56].x));
}

/// What a filter of this radius and distance scale (equation 23, in pixels) leaves at a distance of a pixel
/// of one, on an even plane.
float spread(int pixels, int radius, float scale) {
    const auto weight = [&](int d) { return 1 / (1 + 10 * static_cast<float>(d * d) / (scale * scale)); };
    float sum = 1;
    for (int d = 1; d <= radius; ++d) sum += 2 * weight(d);
    return std::abs(pixels) > radius ? 0 : weight(pixels) / sum;
}

/// A small bump on an even floor spreads by the kernel in both directions. Radii follow the floor's
/// luminance, by either of the paper's thresholds: 0.012 times the light is above a tenth of 0.114, and below
/// a tenth of 0.144.
TEST(Denoise, AdaptiveRadiusIsThatOfTheLuminance) {
    const view::ReceiverLayer layer = test::plane_layer(71, 71, 0.01f);
    const auto is = [&](float share, double threshold, int radius) {
        const float floor = share * kLight, bump = 0.01f * floor;
        std::vector<glm::vec3> irradiance(layer.pixels(), glm::vec3(floor));
        irradiance[35 * 71 + 35] += bump;
        scene::Denoise settings = adaptive();
        settings.threshold = threshold;
        const Filtered found = filtered(layer, irradiance, settings);
        const float scale = radius == 15 ? 15.0f : radius == 10 ? 2.0f : 1.0f;
        for (int dy = 0; dy <= 17; ++dy)
            for (int dx = 0; dx <= 17; ++dx) {
                const auto i = static_cast<std::size_t>((35 + dy) * 71 + 35 + dx);
                // Floats of a floor a hundred times the bump: 1e-5 of the bump.
                EXPECT_NEAR((found.irradiance[i].x - floor) / bump,
                            spread(dx, radius, scale) * spread(dy, radius, scale), 3e-5f)
                    << share << " " << threshold << " " << dx << "," << dy;
            }
    };
    is(0.005f, 0.114, 15);
    is(0.012f, 0.114, 10);
    is(0.012f, 0.144, 15);
    is(0.050f, 0.114, 10);
    is(0.060f, 0.114, 5);
    is(0.060f, 0.144, 10);
    is(2.000f, 0.114, 5);
}

/// A lit pixel in the dark: the radii of dark pixels hold in both directions, though the row about it is no
/// longer dark once the rows have been filtered.
TEST(Denoise, RadiiAreFoundOnceAPass) {
    const view::ReceiverLayer layer = test::plane_layer(41, 41, 0.01f);
    std::vector<glm::vec3> irradiance(layer.pixels(), glm::vec3(0));
    irradiance[20 * 41 + 20] = glm::vec3(5000);
    const Filtered found = filtered(layer, irradiance, adaptive());
    for (int dy = 0; dy <= 16; ++dy)
        for (int dx = 0; dx <= 16; ++dx)
            // Floats of what is left in the middle, 16, after some thirty taps.
            EXPECT_NEAR(found.irradiance[static_cast<std::size_t>((20 + dy) * 41 + 20 + dx)].x,
                        5000 * spread(dx, 15, 15) * spread(dy, 15, 15), 2e-3f)
                << dx << "," << dy;
}

/// The same of the fixed filter, whatever the luminance.
TEST(Denoise, FixedRadiusIsTheSettings) {
    const view::ReceiverLayer layer = test::plane_layer(31, 31, 0.01f);
    std::vector<glm::vec3> irradiance(layer.pixels(), glm::vec3(0));
    irradiance[15 * 31 + 15] = glm::vec3(64);
    scene::Denoise settings = fixed();
    settings.radius = 3;
    const Filtered found = filtered(layer, irradiance, settings);
    for (int dy = -4; dy <= 4; ++dy)
        for (int dx = -4; dx <= 4; ++dx)
            // Floats of 64 and some ten taps.
            EXPECT_NEAR(found.irradiance[static_cast<std::size_t>((15 + dy) * 31 + 15 + dx)].x,
                        64 * spread(dx, 3, 1) * spread(dy, 3, 1), 4e-5f);
}

/// Algorithm 4 along a row by hand: pixels 1 cm apart, a lit one of 10 W/m^2 (radius 5, steps of 1, delta 1),
/// dark ones (radius 15, steps of 5, delta 15), the camera's depths equal.
TEST(Denoise, PaperGathersAsPrinted) {
    const denoise::Reach dark_reach(denoise::kAdaptiveKernels[0]), lit_reach(denoise::kAdaptiveKernels[2]);
    std::array<LinePixel, 61> line;
    for (std::size_t i = 0; i < line.size(); ++i) {
        line[i].guide.surface = 1;
        line[i].guide.position = {0.01f * static_cast<float>(i), -2, 0};
        line[i].depth = 3;
        line[i].irradiance = glm::vec3(i == 30 ? 10.0f : 0.0f);
        line[i].reach = i == 30 ? &lit_reach : &dark_reach;
    }
    line[15].depth = 3.04f;  // 4 cm: weights between it and others are a fifth
    denoise::LineScratch scratch;
    denoise::gather(line, scratch);
    const auto weight = [](double cm, double delta) { return 1 / (1 + 10 * cm * cm / (delta * delta)); };
    double own = 1, dark = 1;
    for (int d = 1; d <= 5; ++d) own += 2 * weight(d, 1);
    for (const int d : {5, 10, 15}) dark += 2 * weight(d, 15);
    EXPECT_NEAR(line[30].irradiance.x, 10 / own, 1e-5);
    for (const std::size_t d : {5u, 15u}) {
        const double expected = 10 * weight(static_cast<double>(d), 15);
        EXPECT_NEAR(line[30 + d].irradiance.x, expected / dark, 1e-5);
    }
    EXPECT_EQ(line[34].irradiance.x, 0);  // its steps pass the lit pixel by
    EXPECT_EQ(line[46].irradiance.x, 0);  // beyond its radius
    // Pixel 15 sees all its neighbours, the lit one too, at a fifth.
    EXPECT_NEAR(line[15].irradiance.x, 10 * weight(15, 15) / 5 / (1 + (dark - 1) / 5), 1e-4);
}

/// A dark pixel gathers from afar what a lit one does not give away: on pixels of the paper's own scale,
/// 2 cm, 40 to 60 % of the power is made, the more the sparser splats are. The default keeps it (above).
TEST(Denoise, PaperGainsPowerOnSparseSplats) {
    const view::ReceiverLayer layer = test::plane_layer(128, 96, 0.02f);
    const auto change = [&](int every) {
        const std::vector<glm::vec3> splats = test::sparse_splats(layer, every, 20);
        const Filtered found = filtered(layer, splats, as_printed(adaptive()));
        return found.power.after / found.power.before - 1;
    };
    EXPECT_GT(change(10), 0.3);
    EXPECT_GT(change(100), change(10));
    EXPECT_LT(change(100), 0.7);
    // With one radius for all, gatherer and giver agree but at the picture's border.
    const Filtered even = filtered(layer, test::sparse_splats(layer, 100, 20), as_printed(fixed()));
    EXPECT_NEAR(even.power.after / even.power.before, 1, 0.01);
}

TEST(Denoise, HasTheSameBitsOnAnyNumberOfThreads) {
    const view::ReceiverLayer layer = oblique_layer(130, 70);
    const std::vector<glm::vec3> splats = test::sparse_splats(layer, 30, 20);
    for (const scene::Denoise& settings : {adaptive(2), as_printed(fixed(2))}) {
        set_thread_count(1);
        const Filtered one = filtered(layer, splats, settings);
        set_thread_count(3);
        const Filtered three = filtered(layer, splats, settings);
        set_thread_count(0);
        EXPECT_EQ(one.irradiance, three.irradiance);
        EXPECT_EQ(one.power.after, three.power.after);
    }
}

TEST(Denoise, NoneChangesNothing) {
    const view::ReceiverLayer layer = test::plane_layer(20, 20, 0.01f);
    const std::vector<glm::vec3> splats = test::sparse_splats(layer, 5, 20);
    const Filtered found = filtered(layer, splats, scene::Denoise{});
    EXPECT_EQ(found.irradiance, splats);
    EXPECT_EQ(found.power.before, found.power.after);
}

}  // namespace
}  // namespace dapple
