// Light scattered by an even medium under flat water against its closed form.
#include <gtest/gtest.h>

#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "media/media.h"
#include "methods/sliced_beams/scatter_sheet.h"
#include "methods/sliced_beams/volume_light.h"
#include "scene/transform.h"

namespace dapple {
namespace {

using light::Event;
using methods::sliced_beams::kLanes;
using methods::sliced_beams::Lanes;
using methods::sliced_beams::PhaseTable;
using methods::sliced_beams::ScatterCounts;
using methods::sliced_beams::ScatterSheet;
using methods::sliced_beams::SegmentGroup;
using test::SheetSet;

constexpr double kIndex = 1.333;

struct Segment {
    glm::dvec3 origin, direction;
    double length;
};

template <class Real>
std::vector<glm::dvec3> scattered(const scene::FrameScene& scene, const SheetSet<Real>& sheets,
                                  const std::vector<Segment>& segments, ScatterCounts& counts) {
    const media::Media media(scene);
    const PhaseTable<Real> phase(media, 0);
    const methods::sliced_beams::EvenMedium<Real> medium(scene.state.water->extinction(),
                                                         scene.state.water->scattering, phase);
    std::vector<glm::dvec3> result(segments.size(), glm::dvec3(0));
    for (const auto& sheet : sheets.sheets()) {
        const ScatterSheet<Real> scatter(*sheet);
        for (std::size_t first = 0; first < segments.size(); first += kLanes<Real>) {
            SegmentGroup<Real> group{};
            group.length = methods::sliced_beams::splat(Real(-1));
            const std::size_t count = std::min<std::size_t>(kLanes<Real>, segments.size() - first);
            for (std::size_t i = 0; i < count; ++i) {
                const Segment& s = segments[first + i];
                for (int k = 0; k < 3; ++k) {
                    group.origin[k][i] = static_cast<Real>(s.origin[k]);
                    group.direction[k][i] = static_cast<Real>(s.direction[k]);
                }
                group.length[i] = static_cast<Real>(s.length);
            }
            Lanes<Real> radiance[3] = {};
            scatter.add(group, scatter.direction({0, 0}), medium, nullptr, radiance, counts);
            for (std::size_t i = 0; i < count; ++i)
                result[first + i] += glm::dvec3(radiance[0][i], radiance[1][i], radiance[2][i]);
        }
    }
    return result;
}

/// S with all media of the scene.
std::vector<glm::vec3> scattered_by_all(const scene::FrameScene& scene,
                                        const std::vector<Segment>& segments) {
    const SheetSet<float> set(scene, Event::transmission, 6);
    view::SegmentLayer layer;
    layer.width = static_cast<int>(segments.size());
    layer.height = 1;
    for (const Segment& s : segments) {
        layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
        layer.origin.emplace_back(s.origin);
        layer.direction.emplace_back(s.direction);
        layer.length.push_back(static_cast<float>(s.length));
        layer.in_water.push_back(1);
        layer.primary.push_back(1);
    }
    layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
    std::vector<glm::vec3> radiance(segments.size(), glm::vec3(0));
    FrameStats stats;
    ScatterCounts counts;
    methods::sliced_beams::VolumeLight(scene, set.sheets(), stats).add(layer, radiance, counts);
    return radiance;
}

class ScatterFlat : public testing::TestWithParam<double> {
protected:
    /// Under 24 m x 20 m of water; the segments stay where all of it is lit.
    static scene::FrameScene scene(double zenith) {
        scene::FrameScene scene = test::scene_of_flat_water({24, 20}, 117, 90);
        scene.state.lights = {test::sun_from_zenith(zenith)};
        scene.state.water->absorption = {0.4, 0.1, 0.03};
        scene.state.water->scattering = {0.2, 0.3, 0.05};
        return scene;
    }
    static glm::dvec3 expected(const scene::FrameScene& scene, double zenith, const Segment& s) {
        const double cos_t = std::cos(std::asin(std::sin(glm::radians(zenith)) / kIndex));
        const test::FlatFloor surface = test::flat_floor(zenith, 1, kIndex);
        glm::dvec3 result;
        for (int c = 0; c < 3; ++c) {
            const double extinction = scene.state.water->extinction()[c];
            const double a = extinction * (1 - s.direction.y / cos_t);
            const double way = std::abs(a * s.length) > 1e-12 ? -std::expm1(-a * s.length) / a : s.length;
            result[c] = scene.state.water->scattering[c] * 0.25 / glm::pi<double>() *
                        scene.state.lights[0].irradiance[c] * surface.irradiance / cos_t *
                        std::exp(extinction * s.origin.y / cos_t) * way;
        }
        return result;
    }
    static std::vector<Segment> segments(double zenith) {
        const double sin_t = std::sin(glm::radians(zenith)) / kIndex, cos_t = std::sqrt(1 - sin_t * sin_t);
        std::vector<Segment> all;
        const auto add = [&](glm::dvec3 origin, glm::dvec3 direction, double length) {
            all.push_back(
                {origin + glm::dvec3(-origin.y * sin_t / cos_t, 0, 0), glm::normalize(direction), length});
        };
        for (const double depth : {0.2, 0.9, 2.5}) {
            for (int i = 0; i < 8; ++i)  // level
                add({0.1 * i, -depth, 0.03 * i}, {std::cos(0.8 * i), 0, std::sin(0.8 * i)}, 2.3);
            for (int i = 0; i < 8; ++i) {  // down and up
                add({0.07 * i, -depth, 0.02 * i}, {0, -1, 0}, 3);
                add({0.07 * i, -depth, 0.02 * i}, {0, 1, 0}, depth);
            }
            for (int i = 0; i < 12; ++i) {  // oblique
                const glm::dvec3 d(std::cos(1.1 * i), 0.7 * std::sin(2.3 * i), std::sin(1.1 * i));
                add({0.1 * i, -depth, -0.1 * i}, d, d.y > 0 ? std::min(4.0, 0.9 * depth / d.y) : 1.5);
            }
            // Towards the light: a is 0 to rounding for a direction along its rays, against them twice it.
            add({0, -depth, 0}, {-sin_t, cos_t, 0}, 0.99 * depth / cos_t);
            add({0, -depth, 0}, {sin_t, -cos_t, 0}, 2);
        }
        return all;
    }
};
INSTANTIATE_TEST_SUITE_P(SunFromZenith, ScatterFlat, testing::Values(0.0, 30.0, 60.0, 80.0),
                         [](const auto& sun) { return std::to_string(static_cast<int>(sun.param)) + "deg"; });

TEST_P(ScatterFlat, LevelUprightAndObliqueSegmentsHaveTheClosedForm) {
    const std::vector<Segment> segments = this->segments(GetParam());
    // In clear water a cluster's light is dimmed as a whole, by moments; in murky water interval by interval.
    for (const double murk : {1.0, 0.1, 0.01}) {
        scene::FrameScene scene = this->scene(GetParam());
        scene.state.water->absorption *= murk;
        scene.state.water->scattering *= murk;
        const auto worst_of = [&](const auto& sheets) {
            ScatterCounts counts;
            const std::vector<glm::dvec3> values = scattered(scene, sheets, segments, counts);
            double worst = 0;
            for (std::size_t i = 0; i < segments.size(); ++i) {
                const glm::dvec3 e = expected(scene, GetParam(), segments[i]);
                for (int c = 0; c < 3; ++c) {
                    const double error = std::abs(values[i][c] / e[c] - 1);
                    if (error > 1e-3)
                        printf("  segment %zu channel %d: %g of %g\n", i, c, values[i][c], e[c]);
                    worst = std::max(worst, error);
                }
            }
            return worst;
        };
        const double in_double = worst_of(SheetSet<double>(scene, Event::transmission, 6));
        const double in_float = worst_of(SheetSet<float>(scene, Event::transmission, 6));
        printf("sun %2.0f deg from the zenith, murk %4.2f: S off by %.1e (double), %.1e (float) of %zu\n",
               GetParam(), murk, in_double, in_float, segments.size());
        // Double: three nodes for e^-x over an optical depth of 0.35 at most. Float: places are rounded to
        // 1e-6 m.
        EXPECT_LT(in_double, 1e-9);
        EXPECT_LT(in_float, 5e-6);
    }
}

TEST_P(ScatterFlat, ABoxOfMediumInClearWaterIsThickWater) {
    // The same medium as a box that ends at the surface's side and holds all segments, in water that only
    // absorbs.
    scene::FrameScene scene = this->scene(GetParam());
    scene::FrameScene parted = scene;
    parted.state.water->absorption = {0.1, 0.02, 0.01};
    parted.state.water->scattering = {0, 0, 0};
    scene::Medium& box = parted.state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.side = scene::MediumSide::water;
    box.size = {60, 40, 60};
    box.density = 2;
    box.extinction = (scene.state.water->extinction() - parted.state.water->extinction()) / 2.0;
    box.albedo = scene.state.water->scattering / (2.0 * box.extinction);
    const std::vector<Segment> segments = this->segments(GetParam());
    const std::vector<glm::vec3> radiance = scattered_by_all(parted, segments);
    double worst = 0;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const glm::dvec3 e = expected(scene, GetParam(), segments[i]);
        for (int c = 0; c < 3; ++c)
            worst = std::max(worst, std::abs(static_cast<double>(radiance[i][c]) / e[c] - 1));
    }
    printf("sun %2.0f deg from the zenith, box of medium: S off by %.1e\n", GetParam(), worst);
    // Pieces of 0.1 optical depths, the light's way taken to their middles: 0.1 * 0.1 / 12 where both dim one
    // way.
    EXPECT_LT(worst, 1e-3);
}

TEST_P(ScatterFlat, ATiltedBoxThatLightEntersByAMillimetreIsAHalfSpace) {
    // Rays of light a tenth of a metre apart meet the face hundreds of optical depths apart. Both ways into a
    // half space with a face of normal n dim by its depth z: the integral of e^-(z / l + z / v) dz / v, with
    // cosines l of the light and v of the segment to n.
    scene::FrameScene scene = this->scene(GetParam());
    scene.state.water->absorption = scene.state.water->scattering = {0, 0, 0};
    scene::Medium& box = scene.state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.side = scene::MediumSide::water;
    box.size = {4, 1, 4};
    box.transform.rotation = {glm::radians(7.0), glm::radians(20.0), glm::radians(11.0)};
    box.transform.position = {0.1, -1.2, -0.2};
    box.extinction = {3000, 1000, 500};
    box.albedo = {0.9, 0.5, 0.8};
    const glm::dmat4 world = scene::world_from_object(box.transform);
    const glm::dvec3 normal(world[1]), face = box.transform.position + 0.5 * normal;
    std::vector<Segment> segments;
    for (int i = 0; i < 40; ++i) {
        const glm::dvec3 in_face(0.3 * std::cos(1.9 * i), 0, 0.3 * std::sin(3.1 * i));
        const glm::dvec3 from_face(std::cos(2.3 * i), 0.6 + 0.05 * i, std::sin(2.3 * i));
        const glm::dvec3 back = glm::normalize(glm::dvec3(world * glm::dvec4(from_face, 0)));
        segments.push_back({face + glm::dvec3(world * glm::dvec4(in_face, 0)) + 0.2 * back, -back, 0.6});
    }
    const std::vector<glm::vec3> radiance = scattered_by_all(scene, segments);
    const double sin_t = std::sin(glm::radians(GetParam())) / kIndex, cos_t = std::sqrt(1 - sin_t * sin_t);
    const double light = std::abs(glm::dot(normal, glm::dvec3(sin_t, -cos_t, 0)));
    double worst = 0;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const double view = std::abs(glm::dot(normal, segments[i].direction));
        for (int c = 0; c < 3; ++c) {
            const double fluence = scene.state.lights[0].irradiance[c] *
                                   test::flat_floor(GetParam(), 1, kIndex).irradiance / cos_t;
            const double e = fluence * box.albedo[c] * 0.25 / glm::pi<double>() / (1 + view / light);
            worst = std::max(worst, std::abs(static_cast<double>(radiance[i][c]) / e - 1));
        }
    }
    printf("sun %2.0f deg from the zenith, tilted dense box: S off by %.1e\n", GetParam(), worst);
    // Pieces of 0.1 optical depths as in a level box; places are rounded to 3e-7 m, 1e-3 of an optical depth.
    EXPECT_LT(worst, 2.5e-3);
}

TEST_P(ScatterFlat, ABoxOfMediumDimsAFloorAsThickWaterDoes) {
    // The box ends 1 m below the surface; water that scatters dims as much as water that absorbs.
    scene::FrameScene scene = this->scene(GetParam());
    scene::Medium& box = scene.state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.side = scene::MediumSide::water;
    box.size = {60, 2, 60};
    box.extinction = {0.7, 0.2, 0.4};
    const SheetSet<double> sheets(scene, Event::transmission, 4);
    const test::FlatFloor floor = test::flat_floor(GetParam(), 2.5, kIndex);
    const double way_in_box = floor.way / 2.5;
    const double sin_t = std::sin(glm::radians(GetParam())) / kIndex;
    const glm::dvec3 expected =
        scene.state.lights[0].irradiance * floor.irradiance *
        glm::exp(-scene.state.water->extinction() * floor.way - box.extinction * way_in_box);
    std::vector<SheetSet<double>::Receiver> receivers;
    for (int i = 0; i < 40; ++i)
        receivers.push_back(test::receiver<double>({sin_t * floor.way + 0.037 * i - 0.7, -2.5, 0.02 * i},
                                                   {0, 1, 0}, {i < 20 ? 0.01 : 0.7, 0.3}));
    double worst = 0;
    for (const glm::dvec3& value : sheets.irradiance(receivers))
        for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(value[c] / expected[c] - 1));
    printf("sun %2.0f deg from the zenith, box of medium: E off by %.1e\n", GetParam(), worst);
    // Columns are kept in float.
    EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace dapple
