// E and S of a spot that throws a picture of checkers through flat water and through waves: each method
// against the method `reference`, which looks the picture up by code of its own. The references are made
// here.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "accuracy/scenes.h"
#include "gpu/validated_device.h"
#include "light/gobo.h"
#include "methods/registry.h"

namespace dapple {
namespace {

/// A floor 1 m deep, of which 1.1 m are seen from above by parallel rays from under the water.
scene::FrameState pool(bool waves) {
    scene::FrameState state = test::waves_over_floor(48, {0, 0}, {2.5, 2.5}, 24);
    if (!waves)
        for (scene::Wave& wave : state.water->surface.waves.waves) wave.amplitude = 0;
    state.water->absorption = {0.3, 0.1, 0.05};
    state.lights = {test::spot({0.3, 1.5, 0.2}, {0, 0, 0}, 22)};
    state.lights[0].roll = 0.4;
    state.camera.projection = scene::Projection::orthographic;
    state.camera.position = {-0.1, -0.2, -0.05};
    state.camera.target = state.camera.position - glm::dvec3(0, 1, 0);
    state.camera.up = {0, 0, -1};
    state.camera.view_height = 1.1;
    state.caustics.map.map_resolution = 512;
    state.caustics.adaptive_beams.levels = 3;
    state.caustics.reference = {0.03, 3};
    state.objects.push_back(test::floor_plane({0, -1, 0}));
    return state;
}

/// The same waves from the side, through murky water, and so that no way meets the surface.
scene::FrameState murky_pool() {
    scene::FrameState state = pool(true);
    state.clip.height = 18;
    state.water->scattering = glm::dvec3(0.2);
    state.camera.projection = scene::Projection::perspective;
    state.camera.position = {-0.1, -0.3, 1.2};
    state.camera.target = {-0.05, -0.95, 0};
    state.camera.up = {0, 1, 0};
    state.camera.field_of_view = 40 * scene::kDegree;
    return state;
}

struct Means {
    std::vector<double> value, variance;  ///< a pixel, of one channel
};

std::vector<double> values_of(const std::vector<methods::DataLayer>& data, const std::string& name) {
    for (const methods::DataLayer& layer : data)
        if (layer.name == name) return {layer.values.begin(), layer.values.end()};
    return {};
}

Means take(scene::FrameState state, const std::shared_ptr<const image::Texture>& picture,
           const std::string& name, int finer, bool scattered, int channel) {
    state.clip.width *= finer;
    state.clip.height *= finer;
    scene::FrameScene scene;
    if (state.water) {
        scene = test::scene_of(state);
    } else {
        scene.state = state;
        scene.object_meshes.resize(state.objects.size());
    }
    scene.light_textures = {picture};
    const rays::RayScene rays(scene);
    FrameStats stats;
    const light::Chain chain{0, light::Event::transmission, state.water ? light::kWater : 1};
    methods::FrameContext context{scene, rays, test::validated_device(), stats, {chain}, {}};
    const std::unique_ptr<methods::CausticMethod> method = methods::make_method(name);
    method->begin(context);
    view::LayerCounts counts;
    view::SegmentLayer segments;
    const view::ReceiverLayer layer =
        view::trace_layer(scene, rays, {}, counts, scattered ? &segments : nullptr);
    std::vector<double> values(layer.pixels(), 0);
    Means means;
    const std::string variance = std::string(scattered ? "S" : "E") + ".variance." + "RGB"[channel];
    if (scattered) {
        std::vector<glm::vec3> radiance(segments.segments(), glm::vec3(0));
        method->in_scatter(context, segments, radiance);
        for (std::size_t pixel = 0; pixel < values.size(); ++pixel)
            for (std::size_t i = segments.first[pixel]; i < segments.first[pixel + 1]; ++i)
                values[pixel] += static_cast<double>(segments.throughput[i][channel] * radiance[i][channel]);
        means.variance = values_of(method->in_scatter_data(), variance);
    } else {
        methods::LayerResult result;
        result.irradiance.assign(values.size(), glm::vec3(0));
        result.covered.assign(values.size(), 0);
        method->irradiance(context, std::span(&layer, 1), std::span(&result, 1));
        for (std::size_t pixel = 0; pixel < values.size(); ++pixel)
            values[pixel] = static_cast<double>(result.irradiance[pixel][channel]);
        means.variance = values_of(result.data, variance);
    }
    const auto width = static_cast<std::size_t>(state.clip.width), k = static_cast<std::size_t>(finer);
    const auto binned = [&](const std::vector<double>& fine) {
        std::vector<double> coarse(fine.size() / (k * k), 0);
        for (std::size_t i = 0; i < fine.size(); ++i)
            coarse[i / width / k * (width / k) + i % width / k] += fine[i] / static_cast<double>(k * k);
        return coarse;
    };
    means.value = binned(values);
    // Neighbours share their light: their mean has no more variance than they.
    means.variance = binned(means.variance);
    return means;
}

struct Error {
    double l1, bias, noise;
};

Error error_of(const std::string& name, const Means& found, const Means& truth) {
    double sum = 0, error = 0, difference = 0, noise = 0;
    for (std::size_t i = 0; i < truth.value.size(); ++i) {
        sum += truth.value[i];
        error += std::abs(found.value[i] - truth.value[i]);
        difference += found.value[i] - truth.value[i];
        noise += std::sqrt(2 / std::numbers::pi * truth.variance[i]);
    }
    printf("  %s: L1 %.4f, bias %+.4f, the reference's noise %.4f\n", name.c_str(), error / sum,
           difference / sum, noise / sum);
    return {error / sum, difference / sum, noise / sum};
}

/// Checkers in red and green, of other sizes; a field on the floor is some 6 pixels wide.
std::shared_ptr<const image::Texture> colored_checkers() {
    const auto red = test::checkers(96, 6), green = test::checkers(96, 4);
    std::vector<float> rgb(red->rgb().begin(), red->rgb().end());
    for (std::size_t i = 1; i < rgb.size(); i += 3) rgb[i] = green->rgb()[i];
    return std::make_shared<const image::Texture>(96, 96, std::move(rgb));
}

TEST(Gobo, IrradianceOfEveryMethodIsTheReferences) {
    for (const bool waves : {false, true}) {
        printf("%s water\n", waves ? "wavy" : "flat");
        const scene::FrameState state = pool(waves);
        const int channel = waves ? 1 : 0;
        const auto picture = waves ? colored_checkers() : test::checkers(96, 6);
        const Means truth = take(state, picture, "reference", 1, false, channel);
        const Error sliced =
            error_of("sliced_beams", take(state, picture, "sliced_beams", 1, false, channel), truth);
        // Cells of the mesh are a texel wide: the edges of fields, over which the picture falls within one,
        // are laid down a cell wide. The rest is the reference's noise.
        EXPECT_LT(sliced.l1, sliced.noise + 0.02);
        EXPECT_LT(std::abs(sliced.bias), 0.004);
        const Error adaptive =
            error_of("adaptive_beams", take(state, picture, "adaptive_beams", 4, false, channel), truth);
        // E of 16 points a pixel; its beams are 0.75 texels wide.
        EXPECT_LT(adaptive.l1, adaptive.noise + 0.025);
        EXPECT_LT(std::abs(adaptive.bias), 0.004);
        const Error splatted =
            error_of("photon_splatting", take(state, picture, "photon_splatting", 2, false, channel), truth);
        // Its kernels are two photons wide, of which there are 2.6 a texel.
        EXPECT_LT(splatted.l1, splatted.noise + 0.01);
        EXPECT_LT(std::abs(splatted.bias), 0.004);
    }
}

TEST(Gobo, ScatteredLightOfEveryMethodIsTheReferences) {
    const scene::FrameState state = murky_pool();
    const auto picture = colored_checkers();
    const Means truth = take(state, picture, "reference", 1, true, 0);
    for (const char* method : {"sliced_beams", "adaptive_beams"}) {
        const Error error = error_of(method, take(state, picture, method, 2, true, 0), truth);
        // Four ways of a pixel are looked along, where the reference has its mean.
        EXPECT_LT(error.l1, error.noise + 0.02);
        EXPECT_LT(std::abs(error.bias), 0.01);
    }
}

/// A ball of glass in air 0.5 m above the floor, whose focus lies 2 m below the floor.
scene::FrameState ball_above_floor() {
    scene::FrameState state = pool(false);
    state.water.reset();
    scene::Object ball;
    ball.shape = scene::Shape::sphere;
    ball.radius = 0.4;
    ball.transform.position = {0, -0.5, 0};
    ball.material.glass = true;
    ball.material.refractive_index = 1.1;
    state.objects.push_back(ball);
    state.camera.position.y = -0.95;
    state.camera.target.y = -1;
    state.clip.width = state.clip.height = 16;
    state.caustics.reference = {0.1, 1};
    return state;
}

/// W/m^2, the first channel, a pixel: light of the bare spot that is mirrored once within the ball.
std::vector<double> mirrored_within_ball(const scene::FrameState& state) {
    constexpr int kRings = 1000, kSpokes = 1000;
    const scene::Light& spot = state.lights[0];
    const scene::Object& ball = state.objects[1];
    const glm::dvec3 centre = ball.transform.position, axis = glm::normalize(centre - spot.position);
    const glm::dvec3 u = glm::normalize(glm::cross(axis, {1, 0, 0})), v = glm::cross(axis, u);
    const double n = ball.material.refractive_index, width = state.clip.width;
    const double pixel = state.camera.view_height / width;
    const double sine = ball.radius / glm::distance(centre, spot.position);
    const double solid_angle = 2 * std::numbers::pi * (1 - std::sqrt(1 - sine * sine));
    std::vector<double> irradiance(static_cast<std::size_t>(width * width), 0);
    for (int i = 0; i < kRings * kSpokes; ++i) {
        const int ring = i / kSpokes, spoke = i % kSpokes;
        const double cosine = 1 - (ring + 0.5) / kRings * solid_angle / (2 * std::numbers::pi);
        const double turn = (spoke + 0.5) / kSpokes * 2 * std::numbers::pi;
        glm::dvec3 way =
            cosine * axis + std::sqrt(1 - cosine * cosine) * (std::cos(turn) * u + std::sin(turn) * v);
        const double middle = glm::dot(centre - spot.position, way);
        const double off = glm::distance(centre, spot.position + middle * way);
        glm::dvec3 place = spot.position + (middle - std::sqrt(ball.radius * ball.radius - off * off)) * way;
        const glm::dvec3 normal = (place - centre) / ball.radius;
        // Both angles are the same wherever a ray meets a ball from within.
        const double outside = -glm::dot(way, normal);
        const double inside = std::sqrt(1 - (1 - outside * outside) / (n * n));
        const double across = (outside - n * inside) / (outside + n * inside);
        const double along = (n * outside - inside) / (n * outside + inside);
        const double mirrored = 0.5 * (across * across + along * along);
        way = way / n + normal * (outside / n - inside);
        for (const bool leaves : {false, true}) {
            place += 2 * ball.radius * inside * way;
            const glm::dvec3 out = (place - centre) / ball.radius;
            way = leaves ? n * way + out * (outside - n * inside) : way - 2 * inside * out;
        }
        if (way.y >= 0) continue;
        const glm::dvec3 landed = place + (-1 - place.y) / way.y * way - state.camera.position;
        const double column = std::floor(landed.x / pixel + width / 2);
        const double row = std::floor(landed.z / pixel + width / 2);
        if (std::min(column, row) < 0 || std::max(column, row) >= width) continue;
        irradiance[static_cast<std::size_t>(row * width + column)] +=
            spot.intensity.x * solid_angle / (kRings * kSpokes) * (1 - mirrored) * mirrored * (1 - mirrored) /
            (pixel * pixel);
    }
    return irradiance;
}

TEST(Gobo, IrradianceBelowABallIsTheReferences) {
    const scene::FrameState state = ball_above_floor();
    Means truth = take(state, {}, "reference", 4, false, 0);
    const Error bare = error_of("adaptive_beams", take(state, {}, "adaptive_beams", 4, false, 0), truth);
    // The method leaves out, and counts, what glass mirrors within; of the light here that is 0.9 %.
    const std::vector<double> mirrored = mirrored_within_ball(state);
    for (std::size_t i = 0; i < mirrored.size(); ++i) truth.value[i] -= mirrored[i];
    const Error error = error_of("but for light mirrored within, a point a pixel",
                                 take(state, {}, "adaptive_beams", 1, false, 0), truth);
    // Beams are split until they lie right to a twentieth of a pixel, of which the edge of the light has two
    // a row.
    EXPECT_LT(error.l1, error.noise + 0.015);
    EXPECT_LT(std::abs(error.bias), 0.003);

    const std::shared_ptr<const image::Texture> picture = test::checkers(96, 6);
    const Means pictured = take(state, picture, "reference", 4, false, 0);
    const Error colored =
        error_of("through a picture", take(state, picture, "adaptive_beams", 4, false, 0), pictured);
    // The picture adds none.
    EXPECT_LT(colored.l1, bare.l1 + 0.005);
    EXPECT_NEAR(colored.bias, bare.bias, 0.005);
}

}  // namespace
}  // namespace dapple
