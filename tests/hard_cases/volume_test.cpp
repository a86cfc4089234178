// Hard cases of light that media scatter, as they are rendered: every value is finite, and the light that is
// scattered is what the beams bring. DAPPLE_LONG: brute force to the figure, in place of a look at it.
#include <gtest/gtest.h>

#include <algorithm>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "hard_cases/hard_case.h"
#include "render/frame_renderer.h"
#include "source_dir.h"
#include "view/camera.h"

namespace dapple {
namespace {

constexpr double kIndex = 1.333;

struct Scattered {
    image::Image picture;
    FrameStats stats;
    double mean = 0;  ///< of volume_caustics, red, W/m^2/sr
    double at(int x, int y) const {
        return static_cast<double>(
            picture.find("volume_caustics.R")->values[static_cast<std::size_t>(y * picture.width + x)]);
    }
};

Scattered rendered(const scene::FrameState& state) {
    render::FrameRenderer renderer(test::validated_device());
    Scattered result;
    render::RenderedFrame frame = renderer.render(state, result.stats);
    EXPECT_EQ(frame.non_finite.count, 0u) << state.caustics.method << ": " << frame.non_finite.first;
    result.picture = std::move(frame.linear);
    const image::Channel* channel = result.picture.find("volume_caustics.R");
    if (!channel) throw std::runtime_error("no scattered light");
    for (const float value : channel->values) {
        EXPECT_TRUE(std::isfinite(value));
        EXPECT_GE(value, 0);
        result.mean += static_cast<double>(value) / static_cast<double>(channel->values.size());
    }
    return result;
}

/// With brute force in place of beams. Its error is that of a pixel; ways of light cross many, so that a
/// picture's mean is known somewhat better only.
constexpr double kBruteError = DAPPLE_LONG ? 0.02 : 0.1;
constexpr double kBruteTolerance = DAPPLE_LONG ? 0.01 : 0.1;
scene::FrameState by_reference(scene::FrameState state) {
    state.caustics.method = "reference";
    state.caustics.reference = {kBruteError, DAPPLE_LONG ? 20 : 1};
    state.clip.samples = 1;  // it takes the mean over the pixel by itself
    return state;
}

/// With adaptive beams. They serve what the camera sees directly.
scene::FrameState by_adaptive_beams(scene::FrameState state) {
    state.caustics.method = "adaptive_beams";
    state.caustics.adaptive_beams.grid = 16;
    state.caustics.adaptive_beams.levels = 2;
    return state;
}

/// Isotropic, so thin that it takes nothing away from the light that can be seen here.
constexpr double kThin = 1e-5;
void fill_thinly(scene::FrameState& state) {
    state.water->absorption = glm::dvec3(0);
    state.water->scattering = glm::dvec3(kThin);
    state.water->phase.type = scene::PhaseType::isotropic;
}

/// A camera that looks level along +z at the light between two depths, from before it; a wall behind. It
/// catches all light that comes down between x = `left` and `right`.
struct Slab {
    double top, bottom, left, right;  ///< m; depths positive
};
void look_at(scene::FrameState& state, const Slab& slab, int height) {
    state.camera = {};
    state.camera.projection = scene::Projection::orthographic;
    state.camera.position = {0.5 * (slab.left + slab.right), -0.5 * (slab.top + slab.bottom), -6};
    state.camera.target = state.camera.position + glm::dvec3(0, 0, 1);
    state.camera.up = {0, 1, 0};
    state.camera.view_height = slab.bottom - slab.top;
    state.clip.height = height;
    state.clip.width =
        static_cast<int>(std::lround(height * (slab.right - slab.left) / (slab.bottom - slab.top)));
    scene::Object wall = test::level_plane("wall", 0, 60);
    wall.transform.position = {0, 0, 6};
    wall.transform.rotation.x = -90 * scene::kDegree;
    state.objects = {wall};
}

/// What such a picture's mean must be: of each ray the flux times its way in the slab times what is scattered
/// a metre and steradian, over the picture's area.
double expected_mean(const scene::FrameState& state, const Slab& slab) {
    const scene::FrameScene scene = render::FrameSceneBuilder().build(state);
    const rays::RayScene rays(scene);
    FrameStats stats;
    double sum = 0;
    for (const auto& sheet :
         light::water_beams<double>(scene, rays, {0, light::Event::transmission}, 1, stats)) {
        for (std::size_t i = 0; i < sheet.flux.size(); ++i) {
            if (!(sheet.flux[i] > 0)) continue;
            for (int k = 0; k < 3; ++k) {
                const auto& ray = sheet.rays[scene.water->mesh.triangles[i][k]];
                const glm::dvec3 way = sheet.world_from_mesh * glm::dvec3(ray.slope_a, ray.slope_b, 1);
                sum += sheet.power(i).r / 3 * (slab.bottom - slab.top) * glm::length(way) / -way.y;
            }
        }
    }
    return sum * kThin / (4 * glm::pi<double>()) / ((slab.bottom - slab.top) * (slab.right - slab.left));
}

void expect_all_light(const char* what, const scene::FrameState& state, const Slab& slab, double tolerance,
                      double adaptive_tolerance) {
    const double expected = expected_mean(state, slab);
    const double found = rendered(state).mean;
    printf("%s: sliced beams %+.2e of the flux\n", what, found / expected - 1);
    EXPECT_NEAR(found, expected, tolerance * expected) << what;
    scene::FrameState small = by_reference(state);
    small.clip.width /= 4;
    small.clip.height /= 4;
    const double brute = rendered(small).mean;
    printf("%s: reference %+.2e\n", what, brute / expected - 1);
    EXPECT_NEAR(brute, expected, kBruteTolerance * expected) << what;
    // They look along the same rays as sliced beams.
    const double adaptive = rendered(by_adaptive_beams(state)).mean;
    printf("%s: adaptive beams %+.2e, %+.2e of sliced beams\n", what, adaptive / expected - 1,
           adaptive / found - 1);
    EXPECT_NEAR(adaptive, found, adaptive_tolerance * expected) << what;
}

TEST(VolumeFocus, ScattersAllFluxThroughAFocus) {
    scene::FrameState state = test::clear_sea(2, 0, 0);
    state.water->surface.type = scene::WaterSurfaceType::mesh_sequence;
    state.water->surface.mesh_sequence.pattern = DAPPLE_SOURCE_DIR "/sequences/hard_cases/lens.%04d.ply";
    fill_thinly(state);
    // The focus is 2 m deep.
    const Slab slab{1.5, 2.5, -0.1875, 0.1875};
    look_at(state, slab, DAPPLE_LONG ? 64 : 32);
    // S is as 1 over the distance from the focus: what a sum by points misses of it is in proportion to their
    // distance, which is twice as large in the short test.
    state.clip.samples = 16;
    expect_all_light("focus", state, slab, DAPPLE_LONG ? 0.01 : 0.03, 0.005);
    const Slab above{1.5, 1.9, -0.1875, 0.1875};
    look_at(state, above, 16);
    const double expected = expected_mean(state, above);
    EXPECT_NEAR(rendered(by_adaptive_beams(state)).mean, expected, 0.01 * expected) << "above the focus";
}

TEST(VolumeFocus, IsFiniteToAnEyeThatLooksIntoIt) {
    // Without a disc of the sun S grows as 1 over the distance from the focus: the ray in the middle of this
    // picture goes right through it.
    scene::FrameState state = test::clear_sea(2, 0, 0);
    state.water->surface.type = scene::WaterSurfaceType::mesh_sequence;
    state.water->surface.mesh_sequence.pattern = DAPPLE_SOURCE_DIR "/sequences/hard_cases/lens.%04d.ply";
    fill_thinly(state);
    look_at(state, {1.995, 2.005, -0.005, 0.005}, 3);
    state.clip.samples = 1;
    scene::FrameState brute = by_reference(state);
    brute.caustics.reference.standard_error = 1;
    for (const scene::FrameState& s : {state, brute, by_adaptive_beams(state)}) {
        const Scattered picture = rendered(s);
        printf("%s: %.3g in the focus, %.3g beside it\n", s.caustics.method.c_str(), picture.at(1, 1),
               picture.at(0, 1));
        EXPECT_GT(picture.at(0, 1), 0);
        EXPECT_GT(picture.at(1, 1), picture.at(0, 1));
    }
}

TEST(VolumeLowSun, OfHalfADegreeScattersWhatPasses) {
    for (const bool waves : {false, true}) {
        scene::FrameState state = test::clear_sea(4, 89.5, waves ? 240 : 40);
        if (waves)
            state.water->surface.waves.waves = {test::wave(1, 10, 0.006), test::wave(0.7, 60, 0.003, 1)};
        fill_thinly(state);
        const Slab slab{0.5, 1.5, -3, 6};
        look_at(state, slab, DAPPLE_LONG ? 32 : 8);
        // Waves of slopes past the sun's elevation shade each other: the mesh is fine, as brute force sees
        // the analytic waves.
        expect_all_light(waves ? "sun at 0.5 deg, waves" : "sun at 0.5 deg, flat", state, slab, 0.01, 0.01);
    }
}

/// Eye in flat water that scatters and absorbs.
scene::FrameState eye_in_flat_water(double depth, const glm::dvec3& towards, double extinction,
                                    double patch = 24) {
    scene::FrameState state = test::clear_sea(patch, 30, 24);
    state.clip.width = 16;
    state.clip.height = 9;
    state.camera = {};
    state.camera.position = {0, -depth, 0};
    state.camera.target = state.camera.position + towards;
    state.camera.field_of_view = 20 * scene::kDegree;
    if (std::abs(towards.y) > 0.99) state.camera.up = {0, 0, -1};
    state.water->absorption = glm::dvec3(0.2 * extinction);
    state.water->scattering = glm::dvec3(0.8 * extinction);
    state.water->phase.type = scene::PhaseType::isotropic;
    return state;
}

/// Closed form of a segment below flat water that begins at height y.
double flat_water_scatter(const scene::FrameState& state, double y, const glm::dvec3& way, double length) {
    const test::FlatFloor below = test::flat_floor(30, 1, kIndex);
    const double cos_t = 1 / below.way, extinction = state.water->extinction().r;
    const double a = extinction * (1 - way.y / cos_t);
    const double along = std::abs(a * length) < 1e-9 ? length : -std::expm1(-a * length) / a;
    return state.water->scattering.r / (4 * glm::pi<double>()) * below.irradiance / cos_t *
           std::exp(extinction * y / cos_t) * along;
}

/// Mean over the pixels' middles of the closed form, down to `floor`; upwards to the surface, and from there
/// what it mirrors.
double flat_water_mean(const scene::FrameState& state, double floor) {
    const view::Camera camera(state.camera, state.clip.width, state.clip.height);
    double sum = 0;
    for (int y = 0; y < state.clip.height; ++y) {
        for (int x = 0; x < state.clip.width; ++x) {
            glm::dvec3 origin, way;
            camera.ray({x + 0.5, y + 0.5}, origin, way);
            if (way.y < 0) {
                sum += flat_water_scatter(state, origin.y, way, (origin.y + floor) / -way.y);
                continue;
            }
            const double length = -origin.y / way.y;
            const double i = std::acos(way.y), t = std::asin(kIndex * std::sin(i));
            const double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
            sum += flat_water_scatter(state, origin.y, way, length) +
                   0.5 * (s * s + p * p) * std::exp(-state.water->extinction().r * length) *
                       flat_water_scatter(state, 0, {way.x, -way.y, way.z}, floor / way.y);
        }
    }
    return sum / (state.clip.width * state.clip.height);
}

void expect_flat_water(const std::string& what, const scene::FrameState& state, bool with_reference = true) {
    const double expected = flat_water_mean(state, 2);
    const double found = rendered(state).mean;
    printf("%s: sliced beams %+.2e\n", what.c_str(), found / expected - 1);
    EXPECT_NEAR(found, expected, 0.005 * expected) << what;
    if (with_reference) {
        const double brute = rendered(by_reference(state)).mean;
        printf("%s: reference %+.2e\n", what.c_str(), brute / expected - 1);
        EXPECT_NEAR(brute, expected, kBruteTolerance * expected) << what;
    }
    if (state.camera.target.y > state.camera.position.y) return;  // it sees the surface
    const double adaptive = rendered(by_adaptive_beams(state)).mean;
    printf("%s: adaptive beams %+.2e\n", what.c_str(), adaptive / expected - 1);
    EXPECT_NEAR(adaptive, expected, 0.005 * expected) << what;
}

TEST(VolumeAlongTheLight, HasTheClosedForm) {
    const double sine = 0.5 / kIndex, cosine = std::sqrt(1 - sine * sine);
    expect_flat_water("along the light", eye_in_flat_water(0.5, {sine, -cosine, 0}, 0.3));
    expect_flat_water("against the light", eye_in_flat_water(1.5, {-sine, cosine, 0}, 0.3));
}

TEST(VolumeDensity, OfZeroScattersNothing) {
    scene::FrameState state = eye_in_flat_water(0.5, {1, -0.6, 0}, 0);
    scene::Medium& box = state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.size = {1, 1, 1};
    box.transform.position = {1, -1, 0};
    box.density = 0;
    for (const scene::FrameState& s : {state, by_reference(state), by_adaptive_beams(state)}) {
        render::FrameRenderer renderer(test::validated_device());
        FrameStats stats;
        const render::RenderedFrame frame = renderer.render(s, stats);
        EXPECT_EQ(frame.non_finite.count, 0u);
        if (const image::Channel* channel = frame.linear.find("volume_caustics.R")) {
            EXPECT_EQ(*std::ranges::max_element(channel->values), 0);
        }
        EXPECT_GT(frame.linear.find("E.R")->values[0], 0) << "no medium dims the floor";
    }
}

TEST(VolumeDensity, OfTenThousandAMetreHasTheClosedForm) {
    // The free path is 0.1 mm: from there, and from where no light comes to. Brute force finds the millimetre
    // of water about the eye in a small piece of it only.
    expect_flat_water("1e4 /m, 0.1 mm deep", eye_in_flat_water(1e-4, {1, -0.6, 0}, 1e4, 0.02));
    const scene::FrameState deep = eye_in_flat_water(0.5, {1, -0.6, 0}, 1e4);
    EXPECT_EQ(rendered(deep).mean, 0);
    EXPECT_EQ(rendered(by_reference(deep)).mean, 0);
    EXPECT_EQ(rendered(by_adaptive_beams(deep)).mean, 0);
}

TEST(VolumeCamera, AtTheSurfaceSeesTheSameLight) {
    for (const double depth : {1e-2, 1e-4, 1e-7, 1e-12, 0.0})
        expect_flat_water(std::to_string(depth) + " m deep", eye_in_flat_water(depth, {1, -0.6, 0}, 0.3),
                          depth == 0 || depth == 1e-2);
    // From the air: through a surface however near.
    double first = 0;
    for (const double height : {1e-2, 1e-4}) {
        const double found = rendered(eye_in_flat_water(-height, {1, -0.9, 0}, 0.3)).mean;
        if (first == 0) first = found;
        printf("%g m above: %.6g\n", height, found);
        EXPECT_GT(found, 0);
        EXPECT_NEAR(found, first, 0.01 * first) << height;
    }
}

/// Waves that a medium reaches across: what it scatters in the water and in the air is what it scatters cut
/// to either side, and what brute force finds.
void expect_parts_of_both_sides(const char* what, scene::FrameState state) {
    double whole = 0, parts = 0;
    for (const scene::MediumSide side :
         {scene::MediumSide::everywhere, scene::MediumSide::water, scene::MediumSide::air}) {
        state.media[0].side = side;
        const double mean = rendered(state).mean;
        EXPECT_GT(mean, 0);
        (side == scene::MediumSide::everywhere ? whole : parts) += mean;
    }
    state.media[0].side = scene::MediumSide::everywhere;
    const Scattered brute = rendered(by_reference(state));
    printf("%s: whole %.6g, parts %+.2e, reference %+.2e\n", what, whole, parts / whole - 1,
           brute.mean / whole - 1);
    // The media are thin: what one side takes of the other's light is a thousandth.
    EXPECT_NEAR(parts, whole, 0.002 * whole) << what;
    EXPECT_NEAR(brute.mean, whole, kBruteTolerance * whole) << what;
}

void look_from_below(scene::FrameState& state) {
    state.camera.position = {-1.2, -0.5, 1.4};
    state.camera.target = {0, -0.35, 0};
    state.camera.field_of_view = 14 * scene::kDegree;
}

/// What adaptive beams find of the part below the water, seen from within it.
void expect_part_below(const char* what, scene::FrameState state) {
    look_from_below(state);
    const double expected = rendered(state).mean;
    const double found = rendered(by_adaptive_beams(state)).mean;
    printf("%s, from below: adaptive beams %+.2e of sliced beams\n", what, found / expected - 1);
    EXPECT_GT(expected, 0);
    EXPECT_NEAR(found, expected, 0.01 * expected) << what;
}

scene::FrameState straddled() {
    scene::FrameState state = test::clear_sea(6, 40, 120);
    state.water->surface.waves.waves = {test::wave(1.2, 10, 0.02), test::wave(0.8, 60, 0.008, 1)};
    state.clip.width = 32;
    state.clip.height = 18;
    state.clip.samples = 4;
    state.camera = {};
    state.camera.position = {-1.5, 0.9, 2.2};
    state.camera.target = {0, 0, 0};
    state.camera.field_of_view = 40 * scene::kDegree;
    return state;
}

TEST(VolumeStraddling, ABoxAcrossTheSurface) {
    scene::FrameState state = straddled();
    scene::Medium& box = state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.size = {0.8, 0.6, 0.7};
    box.transform.rotation = {0.1, 0.4, 0.2};
    box.extinction = glm::dvec3(1e-3);
    box.phase.type = scene::PhaseType::isotropic;
    expect_parts_of_both_sides("box", state);
    expect_part_below("box", state);
}

constexpr double kThinSmoke = 1e-3;  ///< /m

/// Smoke of this extinction, /m, where its density is 1, as it is at most.
void add_smoke(scene::FrameState& state, double extinction) {
    scene::Medium& grid = state.media.emplace_back();
    grid.type = scene::MediumType::grid;
    grid.file = DAPPLE_SOURCE_DIR "/sequences/assets/smoke/smoke.0012.vdb";
    grid.z_up = true;
    grid.transform.position = {-1, -0.5, 1};
    grid.extinction = glm::dvec3(extinction);
    grid.phase.type = scene::PhaseType::isotropic;
}

TEST(VolumeStraddling, AGridAcrossTheSurface) {
    scene::FrameState state = straddled();
    add_smoke(state, kThinSmoke);
    expect_parts_of_both_sides("grid", state);
    expect_part_below("grid", state);
}

#if DAPPLE_LONG
/// So dense that each side takes much of the light that the other one would scatter: on its way to the water,
/// on from there, and to the eye.
TEST(VolumeStraddling, ADenseGridAcrossTheSurface) {
    scene::FrameState state = straddled();
    add_smoke(state, kThinSmoke);
    constexpr double kDenseSmoke = 2;  // /m
    // Were nothing taken, dense smoke would scatter so much more than thin smoke.
    const double whole = kDenseSmoke / kThinSmoke * rendered(state).mean;
    state.media[0].extinction = glm::dvec3(kDenseSmoke);
    const double found = rendered(state).mean;
    const Scattered brute = rendered(by_reference(state));
    const double brute_error = brute.stats.counted("reference volume standard error of all light");
    printf(
        "dense grid: %.3f of its light is left; sliced beams %+.2e of the reference, whose error is %.1e\n",
        found / whole, found / brute.mean - 1, brute_error);
    EXPECT_LT(found, 0.8 * whole);
    // Beams 5 cm wide, over which the smoke is taken as linear, are off by less than 1 % even at 40 /m
    // (test_scatter). Here the eye looks through waves, where brute force goes by sub-pixel paths
    // (Reference::supports_volume): of thin smoke it finds 1.1 % more than beams in such pixels, 0.3 % more
    // in pixels half as wide.
    EXPECT_NEAR(found, brute.mean, (0.01 + brute_error) * brute.mean);

    look_from_below(state);
    const double below = rendered(state).mean, adaptive = rendered(by_adaptive_beams(state)).mean;
    const Scattered brute_below = rendered(by_reference(state));
    const double below_error = brute_below.stats.counted("reference volume standard error of all light");
    printf("the same, from below: sliced beams %+.2e, adaptive beams %+.2e, the reference's error %.1e\n",
           below / brute_below.mean - 1, adaptive / brute_below.mean - 1, below_error);
    EXPECT_NEAR(below, brute_below.mean, (0.005 + below_error) * brute_below.mean);
    EXPECT_NEAR(adaptive, brute_below.mean, (0.01 + below_error) * brute_below.mean);
}
#endif

}  // namespace
}  // namespace dapple
