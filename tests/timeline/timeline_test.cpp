#include "timeline/timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "source_dir.h"

namespace dapple::timeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

Timeline parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
    return Timeline::parse("dapple: 1\n" + text, "t.yaml", "/clips", overrides);
}

constexpr const char* kPool = R"(
clip: {name: pool, fps: 24000/1001, frames: 1001-1048, resolution: [96, 54], samples: 2, seed: 7}
camera: {position: [1 m, -50 cm, 2000 mm], target: [0, -1, 0], field_of_view: 60 deg}
water:
  surface:
    type: waves
    depth: 2 m
    waves:
      - {length: 1.5 m, heading: 90 deg, amplitude: 12.3 mm, phase: 3 rad}
      - {wave_vector: [0 rad/m, -4 rad/m], amplitude: 1 cm}
  extent: {type: open, center: [1 m, 2 m], size: [8 m, 4 m]}
  mesh_cells: 64
  refractive_index: 1.34
  absorption: [0.2 /m, 5 /km, 1/m]
lights:
  - {name: sun, type: sun, elevation: 30 deg, azimuth: 90 deg, irradiance: [3 W/m2, 2 W/m^2, 0.001 kW/m2]}
  - {name: spot, type: spot, position: [0 m, 4 m, 3 m], target: [0 m, 0 m, 0 m], intensity: 5 W/sr}
objects:
  - {name: floor, shape: plane, size: [8 m, 1 m, 4 m], position: [0 m, -2 m, 0 m], material: {color: 80 %}}
  - {name: rock, shape: mesh, file: props/rock.obj, rotation: [0 deg, 90 deg, 0 deg], scale: 2,
     material: {texture: ../rock.png, mirror: true}}
sky: {radiance: 0.1 W/m2/sr}
caustics: {method: photon_splatting, map_resolution: 256}
output:
  ocio_config: /studio/config.ocio
  display: sRGB
  view: Film
  exposure: {keys: [{frame: 1001, value: 0.1}, {frame: 1025, value: 0.7 stops}, {time: 1.5015 s, value: 0.3}]}
  cdl: {slope: [1.1, 1, 0.9], saturation: 0.8}
)";

TEST(Timeline, ReadsEveryPartInSi) {
    const Timeline timeline = parse(kPool);
    const scene::FrameState state = timeline.at(1001);
    EXPECT_EQ(state.frame, 1001);
    EXPECT_EQ(state.time, 0);
    EXPECT_EQ(state.clip.name, "pool");
    EXPECT_EQ(state.clip.fps.numerator, 24000);
    EXPECT_EQ(state.clip.fps.denominator, 1001);
    EXPECT_EQ(state.clip.first_frame, 1001);
    EXPECT_EQ(state.clip.last_frame, 1048);
    EXPECT_EQ(state.clip.width, 96);
    EXPECT_EQ(state.clip.height, 54);
    EXPECT_EQ(state.clip.samples, 2);
    EXPECT_EQ(state.clip.seed, 7U);
    EXPECT_EQ(state.camera.position, glm::dvec3(1, -0.5, 2));
    EXPECT_EQ(state.camera.field_of_view, 60 * std::numbers::pi / 180);
    ASSERT_TRUE(state.water.has_value());
    EXPECT_EQ(state.water->surface.waves.depth, 2);
    EXPECT_EQ(state.water->surface.waves.waves[0].amplitude,
              0.0123);  // as if written so: no rounding by the unit
    EXPECT_EQ(state.water->surface.waves.waves[0].phase, 3);
    EXPECT_EQ(state.water->extent.kind, scene::ExtentKind::open_water);
    EXPECT_EQ(state.water->extent.center, glm::dvec2(1, 2));
    EXPECT_EQ(state.water->extent.size, glm::dvec2(8, 4));
    EXPECT_EQ(state.water->mesh_cells, 64);
    EXPECT_EQ(state.water->absorption, glm::dvec3(0.2, 0.005, 1));
    EXPECT_LT(state.water->diffuse_attenuation.x, 0);  // not given: as absorption
    EXPECT_EQ(state.lights[0].irradiance, glm::dvec3(3, 2, 1));
    EXPECT_EQ(state.lights[1].intensity, glm::dvec3(5));
    EXPECT_EQ(state.objects[0].material.color, glm::dvec3(0.8));
    EXPECT_EQ(state.objects[1].shape, scene::Shape::mesh);
    EXPECT_EQ(state.objects[1].transform.scale, glm::dvec3(2));
    EXPECT_TRUE(state.objects[1].material.mirror);
    EXPECT_EQ(state.caustics.map.map_resolution, 256);
    EXPECT_EQ(state.output.view, "Film");
    EXPECT_EQ(state.output.cdl.slope, glm::dvec3(1.1, 1, 0.9));
}

TEST(Timeline, DefaultsAreThoseOfTheStructs) {
    const scene::FrameState state = parse("").at(1);
    EXPECT_FALSE(state.water.has_value());
    EXPECT_EQ(state.clip.width, scene::Clip().width);
    EXPECT_EQ(state.camera.field_of_view, scene::Camera().field_of_view);
}

TEST(Timeline, SunStandsWhereItsAnglesSay) {
    const auto direction = [](const std::string& angles) {
        return parse("lights: [{type: sun, " + angles + "}]").at(1).lights[0].direction;
    };
    const auto near = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b) < 1e-15; };
    EXPECT_TRUE(near(direction("elevation: 90 deg"), {0, -1, 0}));
    EXPECT_TRUE(near(direction("elevation: 30 deg"), {-std::cos(30 * kDegree), -0.5, 0}));
    EXPECT_TRUE(near(direction("elevation: 30 deg, azimuth: 90 deg"), {0, -0.5, -std::cos(30 * kDegree)}));
    EXPECT_TRUE(near(direction("direction: [3, -4, 0]"), {0.6, -0.8, 0}));
}

TEST(Timeline, SpotsAndWavesFollowFromVectors) {
    const scene::FrameState state = parse(kPool).at(1001);
    EXPECT_NEAR(glm::length(state.lights[1].direction - glm::dvec3(0, -0.8, -0.6)), 0, 1e-15);
    const scene::Wave& wave = state.water->surface.waves.waves[1];
    EXPECT_DOUBLE_EQ(wave.length, 2 * std::numbers::pi / 4);
    EXPECT_DOUBLE_EQ(wave.heading, -90 * kDegree);
}

TEST(Timeline, AreaLightsMayBeKeyed) {
    const Timeline timeline = parse(
        "lights: [{type: quad, target: [0 m, 0 m, 0 m], size: [2 m, 50 cm], samples: 9, roll: 90 deg,\n"
        "  position: {keys: [{frame: 1, value: [0 m, 2 m, 0 m]}, {frame: 3, value: [0 m, 0 m, 2 m]}]},\n"
        "  radiance: {keys: [{frame: 1, value: 4 W/m2/sr}, {frame: 3, value: [8, 6, 4]}]}},\n"
        "  {type: disc, direction: [0, -3, 0], radius: 20 cm}]");
    const scene::FrameState first = timeline.at(1), last = timeline.at(3);
    EXPECT_EQ(first.lights[0].type, scene::LightType::quad);
    EXPECT_EQ(first.lights[0].size, glm::dvec2(2, 0.5));
    EXPECT_EQ(first.lights[0].samples, 9);
    EXPECT_EQ(first.lights[0].roll, 90 * kDegree);
    EXPECT_EQ(first.lights[0].radiance, glm::dvec3(4));
    EXPECT_EQ(timeline.at(2).lights[0].radiance, glm::dvec3(6, 5, 4));
    EXPECT_EQ(first.lights[0].direction, glm::dvec3(0, -1, 0));
    EXPECT_EQ(last.lights[0].direction, glm::dvec3(0, 0, -1));
    EXPECT_EQ(first.lights[1].type, scene::LightType::disc);
    EXPECT_EQ(first.lights[1].radius, 0.2);
    EXPECT_EQ(first.lights[1].direction, glm::dvec3(0, -1, 0));
    EXPECT_EQ(first.lights[1].samples, 16);
}

TEST(Timeline, KeysAreExactAtTheirFrames) {
    const Timeline timeline = parse(kPool);
    const auto exposure = [&](std::int64_t frame) { return timeline.at(frame).output.exposure; };
    EXPECT_EQ(exposure(1001), 0.1);
    EXPECT_EQ(exposure(1025), 0.7);
    EXPECT_EQ(exposure(1037), 0.3);  // 36 frames of 1001/24000 s are 1.5015 s
    EXPECT_NEAR(exposure(1013), 0.4, 1e-15);
    EXPECT_EQ(exposure(900), 0.1);
    EXPECT_EQ(exposure(5000), 0.3);
}

TEST(Timeline, FramesAreExactAtEveryRate) {
    for (const char* rate : {"24", "25", "30000/1001", "24000/1001", "60000/1001", "7/3"}) {
        std::string keys;
        for (int frame = 1; frame <= 200; ++frame)
            keys += (frame > 1 ? ", " : "") + std::string("{frame: ") + std::to_string(frame) +
                    ", value: " + std::to_string(frame % 7) + "}";
        const Timeline timeline =
            parse("clip: {fps: " + std::string(rate) +
                  ", frames: 1-200}\noutput: {exposure: {interpolation: cubic, keys: [" + keys + "]}}");
        for (int frame = 1; frame <= 200; ++frame) EXPECT_EQ(timeline.at(frame).output.exposure, frame % 7);
    }
}

TEST(Timeline, KeyedPartsKeepTheRestOfTheirStruct) {
    const Timeline timeline = parse(
        "lights: [{type: sun, azimuth: 0 deg, elevation: {keys: [{frame: 1, value: 90 deg}, {frame: 3, "
        "value: 30 "
        "deg}]}}]\nclip: {frames: 1-3}");
    EXPECT_NEAR(timeline.at(1).lights[0].direction.y, -1, 1e-15);
    EXPECT_NEAR(timeline.at(2).lights[0].direction.y, -std::sin(60 * kDegree), 1e-15);
    EXPECT_NEAR(timeline.at(3).lights[0].direction.y, -0.5, 1e-15);
}

TEST(Timeline, AFrameDoesNotDependOnThoseBefore) {
    const Timeline timeline = parse(kPool);
    const double alone = parse(kPool).at(1030).output.exposure;
    for (const std::int64_t frame : {1048, 1001, 1030, 1002}) timeline.at(frame);
    EXPECT_EQ(timeline.at(1030).output.exposure, alone);
}

TEST(Timeline, PathsStartAtItsFolder) {
    const Timeline timeline = parse(kPool);
    EXPECT_EQ(timeline.at(1001).objects[1].file, "/clips/props/rock.obj");
    EXPECT_THAT(timeline.input_files(),
                ElementsAre("/clips/props/rock.obj", "/rock.png", "/studio/config.ocio"));
}

TEST(Timeline, TheTextureOfASpotIsAnInputFile) {
    constexpr const char* text =
        "lights: [{name: lamp, type: spot, target: [0 m, 0 m, 0 m], texture: leaves.png, roll: {keys: "
        "[{frame: 1, value: 0 deg}, "
        "{frame: 3, value: 90 deg}]}}]\nclip: {frames: 1-3}";
    const Timeline timeline = parse(text);
    EXPECT_THAT(timeline.input_files(), ElementsAre("/clips/leaves.png"));
    EXPECT_EQ(timeline.at(1).lights[0].texture, "/clips/leaves.png");
    EXPECT_NEAR(timeline.at(2).lights[0].roll, 45 * scene::kDegree, 1e-12);
    EXPECT_NE(timeline.fingerprint(), parse(text, {"lights.lamp.texture=other.png"}).fingerprint());
}

constexpr const char* kSequence =
    "clip: {fps: 24, frames: 1-8}\n"
    "water: {surface: {type: mesh_sequence, pattern: sea.%04d.ply, first_file: 3, last_file: 6, fps: 12}}";

TEST(Timeline, SequencesListTheFilesOfTheirFrames) {
    const auto path = [](int n) { return "/clips/sea.000" + std::to_string(n) + ".ply"; };
    // Eight frames at 24 a second last four files at 12 a second.
    EXPECT_THAT(parse(kSequence).input_files(), ElementsAre(path(3), path(4), path(5), path(6)));
    EXPECT_THAT(parse(kSequence, {"clip.frames=1-4"}).input_files(), ElementsAre(path(3), path(4)));
    EXPECT_THAT(parse(kSequence, {"water.surface.last_file=4"}).input_files(), ElementsAre(path(3), path(4)));
    EXPECT_THAT(parse(kSequence, {"water.surface.fps=48"}).input_files(),
                ElementsAre(path(3), path(5), path(6)));
    EXPECT_THAT(parse(kSequence, {"clip.frames=1", "water.surface.pattern=s##.obj"}).input_files(),
                ElementsAre("/clips/s03.obj"));
}

TEST(Timeline, HeldSequencesListWhatStandsInForMissingFiles) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "dapple_held_sequence";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "sea.0003.ply") << "ply";
    std::ofstream(folder / "sea.0005.ply") << "ply";
    const Timeline timeline = Timeline::parse("dapple: 1\n" + std::string(kSequence), "t.yaml",
                                              folder.string(), {"water.surface.missing=hold"});
    EXPECT_THAT(timeline.input_files(),
                ElementsAre((folder / "sea.0003.ply").string(), (folder / "sea.0005.ply").string()));
    std::filesystem::remove_all(folder);
}

TEST(Timeline, LargePicturesAreLeftToTheMemoryBudget) {
    EXPECT_EQ(parse("clip: {resolution: [16384, 16384]}").clip().width, 16384);
}

TEST(Timeline, EachCausticMethodHasItsKeys) {
    const auto caustics = [](const std::string& keys) {
        return parse("caustics: {" + keys + "}").at(1).caustics;
    };
    const scene::Caustics beams = caustics("method: sliced_beams, sun_samples: 7");
    EXPECT_EQ(beams.method, "sliced_beams");
    EXPECT_EQ(beams.sliced_beams.sun_samples, 7);
    EXPECT_TRUE(beams.sliced_beams.path_counts);
    EXPECT_FALSE(caustics("path_counts: false").sliced_beams.path_counts);
    const scene::Caustics reference = caustics("method: reference, standard_error: 2 %, most_rays: 50");
    EXPECT_EQ(reference.method, "reference");
    EXPECT_EQ(reference.reference.standard_error, 0.02);
    EXPECT_EQ(reference.reference.most_rays, 50);
    EXPECT_EQ(caustics("method: photon_splatting").method, "photon_splatting");
    const scene::CausticMapParameters map =
        caustics(
            "method: photon_splatting, cascades: 2, cascade_scale: 2.5, inner_size: 30 m, "
            "cascade_center: target, cascade_maps: [{resolution: 512}, {resolution: 256}], "
            "paper_faithful: true")
            .map;
    EXPECT_EQ(map.cascades, 2);
    EXPECT_EQ(map.cascade_scale, 2.5);
    EXPECT_EQ(map.inner_size, 30);
    EXPECT_EQ(map.cascade_center, scene::CascadeCenter::target);
    ASSERT_EQ(map.cascade_maps.size(), 2U);
    EXPECT_EQ(map.cascade_maps[1].resolution, 256);
    EXPECT_TRUE(map.paper_faithful);
    EXPECT_EQ(caustics("method: photon_splatting, map_precision: 2 cm").map.map_precision, 0.02);
    const scene::Caustics mesh = caustics("method: caustic_mesh, map_resolution: 512, paper_faithful: true");
    EXPECT_EQ(mesh.method, "caustic_mesh");
    EXPECT_EQ(mesh.map.map_resolution, 512);
    EXPECT_TRUE(mesh.map.paper_faithful);
    const scene::PhotonSplattingParameters photons =
        caustics("method: photon_splatting, footprint: photon_difference, footprint_scale: 1.5")
            .photon_splatting;
    EXPECT_EQ(photons.footprint, scene::PhotonFootprint::photon_difference);
    EXPECT_EQ(photons.footprint_scale, 1.5);
    EXPECT_EQ(caustics("method: caustic_mesh, target_error: 2 %").target_error, 0.02);
    EXPECT_EQ(caustics("method: caustic_mesh").target_error, 0);
    EXPECT_EQ(caustics("").method, scene::Caustics().method);
    for (const char* wrong :
         {"method: magic",
          "method: sliced_beams, sun_samples: 0",
          "method: sliced_beams, sun_samples: 1.5",
          "method: sliced_beams, map_resolution: 8",
          "method: photon_splatting, sun_samples: 1",
          "method: photon_splatting, footprint: round",
          "method: sliced_beams, footprint: fixed",
          "method: photon_splatting, footprint_scale: 0",
          "method: photon_splatting, cascades: 0",
          "method: photon_splatting, cascades: 9",
          "method: photon_splatting, cascade_scale: 1",
          "method: photon_splatting, inner_size: -1 m",
          "method: photon_splatting, cascade_center: sun",
          "method: sliced_beams, cascades: 2",
          "method: photon_splatting, cascades: 3, cascade_maps: [{resolution: 512}, {resolution: 256}]",
          "method: photon_splatting, cascade_maps: [{}]",
          "method: photon_splatting, cascade_maps: [512]",
          "method: photon_splatting, map_precision: 1 cm, map_resolution: 512",
          "method: photon_splatting, map_precision: 1 cm, cascade_maps: [{resolution: 512}]",
          "method: photon_splatting, map_resolution: 512, cascade_maps: [{resolution: 512}]",
          "method: sliced_beams, target_error: 2 %",
          "method: reference, target_error: 2 %",
          "method: caustic_mesh, target_error: 0",
          "method: caustic_mesh, target_error: 60 %",
          "method: caustic_mesh, target_error: 2 cm",
          "method: caustic_mesh, target_error: 2 %, map_resolution: 512",
          "method: caustic_mesh, target_error: 2 %, map_precision: 1 cm",
          "method: caustic_mesh, target_error: 2 %, cascade_maps: [{resolution: 512}]",
          "method: caustic_mesh, target_error: 2 %, paper_faithful: true",
          "method: photon_splatting, target_error: 2 %, footprint: point",
          "method: reference, buffer_scale: half",
          "method: reference, denoise: {filter: fixed}",
          "method: reference, standard_error: 0",
          "method: reference, most_rays: 0",
          "method: reference, standard_error: {keys: [{frame: 1, value: 0.1}]}"}) {
        EXPECT_THROW(caustics(wrong), TimelineError) << wrong;
    }
}

TEST(Timeline, DispersionMayBeKeyed) {
    const Timeline timeline = parse(
        "clip: {fps: 1, frames: 1-3}\n"
        "water: {surface: {type: waves}, dispersion: {keys: [{frame: 1, value: 0}, {frame: 3, value: "
        "0.01}], interpolation: linear}}");
    EXPECT_EQ(timeline.at(1).water->dispersion, 0);
    EXPECT_NEAR(timeline.at(2).water->dispersion, 0.005, 1e-15);
    EXPECT_EQ(parse("water: {surface: {type: waves}}").at(1).water->dispersion, 0);
}

constexpr const char* kMedia = R"(
clip: {fps: 24, frames: 11-20}
water: {surface: {type: waves}, scattering: 0.1 /m, phase: {type: fournier_forand, size_slope: 3.5}}
media:
  - {name: fog, type: box, side: air, density: 50 %, extinction: 2 /m, albedo: [0.5, 0.6, 0.7], size: [1 m, 2 m, 3 m],
     position: [1 m, 0 m, 0 m], rotation: [0 deg, 90 deg, 0 deg], scale: 2,
     phase: {type: two_lobe, anisotropy: 0.9, back_anisotropy: -0.1, forward_share: 80 %}}
  - {name: smoke, type: grid, file: s.##.vdb, grid: soot, first_file: 3, last_file: 5, step: 0.5, loop: true,
     missing: hold, z_up: true, density: {keys: [{frame: 11, value: 0}, {frame: 13, value: 1}]},
     phase: {type: table, table: [{angle: 0 deg, value: 3}, {angle: 180 deg, value: 1}]}}
caustics: {volume_resolution: half, volume_sun_samples: 7}
)";

TEST(Timeline, ReadsMedia) {
    const scene::FrameState state = parse(kMedia).at(12);
    EXPECT_EQ(state.water->scattering, glm::dvec3(0.1));
    EXPECT_EQ(state.water->phase.type, scene::PhaseType::fournier_forand);
    EXPECT_EQ(state.water->phase.size_slope, 3.5);
    EXPECT_EQ(state.water->phase.particle_index, 1.1);
    ASSERT_EQ(state.media.size(), 2U);
    const scene::Medium& fog = state.media[0];
    EXPECT_EQ(fog.type, scene::MediumType::box);
    EXPECT_EQ(fog.side, scene::MediumSide::air);
    EXPECT_EQ(fog.density, 0.5);
    EXPECT_EQ(fog.extinction, glm::dvec3(2));
    EXPECT_EQ(fog.albedo, glm::dvec3(0.5, 0.6, 0.7));
    EXPECT_EQ(fog.size, glm::dvec3(1, 2, 3));
    EXPECT_EQ(fog.transform.position, glm::dvec3(1, 0, 0));
    EXPECT_EQ(fog.transform.rotation, glm::dvec3(0, 90 * kDegree, 0));
    EXPECT_EQ(fog.transform.scale, glm::dvec3(2));
    EXPECT_EQ(fog.phase.type, scene::PhaseType::two_lobe);
    EXPECT_EQ(fog.phase.back_anisotropy, -0.1);
    EXPECT_EQ(fog.phase.forward_share, 0.8);
    const scene::Medium& smoke = state.media[1];
    EXPECT_EQ(smoke.grid, "soot");
    EXPECT_NEAR(smoke.density, 0.5, 1e-15);  // keyed
    EXPECT_TRUE(smoke.loop && smoke.z_up);
    EXPECT_EQ(smoke.missing, scene::MissingGrid::hold);
    ASSERT_EQ(smoke.phase.samples.size(), 2U);
    EXPECT_EQ(smoke.phase.samples[1].angle, std::numbers::pi);
    EXPECT_EQ(smoke.phase.samples[0].value, 3);
    EXPECT_EQ(state.caustics.volume_resolution, scene::VolumeResolution::half);
    EXPECT_EQ(state.caustics.sliced_beams.volume_sun_samples, 7);
}

TEST(Timeline, ReadsFiltersOfIrradiance) {
    const scene::Caustics plain = parse("caustics: {method: photon_splatting}").at(1).caustics;
    EXPECT_EQ(plain.denoise.filter, scene::DenoiseFilter::none);
    EXPECT_EQ(plain.buffer_scale, scene::BufferScale::full);
    const scene::Caustics fixed =
        parse("caustics: {buffer_scale: quarter, denoise: {filter: fixed, radius: 3, passes: 10}}")
            .at(1)
            .caustics;
    EXPECT_EQ(fixed.buffer_scale, scene::BufferScale::quarter);
    EXPECT_EQ(fixed.denoise.filter, scene::DenoiseFilter::fixed);
    EXPECT_EQ(fixed.denoise.radius, 3);
    EXPECT_EQ(fixed.denoise.passes, 10);
    EXPECT_FALSE(fixed.denoise.paper_faithful);
    const scene::Denoise adaptive =
        parse("caustics: {denoise: {filter: adaptive}}",
              {"caustics.denoise.threshold=14.4 %", "caustics.denoise.paper_faithful=true"})
            .at(1)
            .caustics.denoise;
    EXPECT_EQ(adaptive.filter, scene::DenoiseFilter::adaptive);
    EXPECT_EQ(adaptive.passes, 1);
    EXPECT_NEAR(adaptive.threshold, 0.144, 1e-15);
    EXPECT_TRUE(adaptive.paper_faithful);
}

/// Narrower peaks than all methods resolve are refused.
TEST(Timeline, MeanCosinesAreBounded) {
    const auto water = [](const std::string& value) {
        return parse("water: {surface: {type: waves}, phase: {type: henyey_greenstein, anisotropy: " + value +
                     "}}")
            .at(1)
            .water->phase.anisotropy;
    };
    EXPECT_EQ(water("0.99"), 0.99);
    EXPECT_EQ(water("-0.75"), -0.75);
    for (const std::string wrong : {"0.991", "-0.76", "1", "-1"})
        EXPECT_THROW(water(wrong), TimelineError) << wrong;
}

TEST(Timeline, JerlovTypesGiveWhatIsNotGiven) {
    const auto water = [](const std::string& keys) {
        return *parse("water: {surface: {type: waves}" + keys + "}").at(1).water;
    };
    const scene::WaterCoefficients coast = scene::jerlov_coefficients(scene::JerlovType::C3);
    const scene::Water preset = water(", jerlov: 3C");
    EXPECT_EQ(preset.absorption, coast.absorption);
    EXPECT_EQ(preset.scattering, coast.scattering);
    EXPECT_EQ(water(", jerlov: 3C, scattering: 0").scattering, glm::dvec3(0));
    EXPECT_EQ(water(", jerlov: 3C, scattering: 0").absorption, coast.absorption);
    EXPECT_EQ(water(", jerlov: 3C, absorption: 0.2").absorption, glm::dvec3(0.2));
    EXPECT_EQ(water(", jerlov: none").absorption, scene::Water().absorption);
    EXPECT_EQ(water("").scattering, glm::dvec3(0));
}

TEST(Timeline, GridSequencesListTheFilesOfTheirFrames) {
    const auto path = [](int n) { return "/clips/s.0" + std::to_string(n) + ".vdb"; };
    const std::string named = "media.smoke.missing=error";
    EXPECT_THAT(parse(kMedia, {named}).input_files(), ElementsAre(path(3), path(4), path(5)));
    EXPECT_THAT(parse(kMedia, {named, "clip.frames=11-14"}).input_files(), ElementsAre(path(3), path(4)));
    EXPECT_THAT(parse(kMedia, {"media.smoke.missing=empty"}).input_files(), ElementsAre());  // none is there
    EXPECT_THAT(parse(kMedia, {"media=[{type: grid, file: a.vdb}]"}).input_files(),
                ElementsAre("/clips/a.vdb"));
}

/// What a check whether files are there would say of the one alone is not the whole.
TEST(Timeline, SequencesWithNothingToHoldSaySo) {
    for (const auto& [text, hold] : {std::pair(kMedia, "media.smoke.missing=hold"),
                                     std::pair(kSequence, "water.surface.missing=hold")}) {
        try {
            parse(text, {hold}).input_files();
            ADD_FAILURE();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::input_unreadable);
            EXPECT_THAT(error.what(), HasSubstr("no such file, and none before it to hold"));
        }
    }
}

TEST(Fingerprint, SeesEveryChangeOfMedia) {
    std::set<std::string> seen{parse(kMedia).fingerprint()};
    for (const char* change : {"water.scattering=0.2",
                               "water.jerlov=II",
                               "water.phase.size_slope=3.6",
                               "water.phase={type: isotropic}",
                               "media=[]",
                               "media.fog.side=water",
                               "media.fog.density=1",
                               "media.fog.extinction=1",
                               "media.fog.albedo=1",
                               "media.fog.size=[1, 1, 1]",
                               "media.fog.position=[1, 1, 1]",
                               "media.fog.phase.forward_share=0.7",
                               "media.smoke.file=t.##.vdb",
                               "media.smoke.grid=density",
                               "media.smoke.first_file=4",
                               "media.smoke.last_file=6",
                               "media.smoke.step=1",
                               "media.smoke.loop=false",
                               "media.smoke.missing=empty",
                               "media.smoke.z_up=false",
                               "media.smoke.density=1",
                               "media.smoke.phase.table[0].angle=1 deg",
                               "media.smoke.phase.table[1].value=2",
                               "caustics.volume_resolution=full",
                               "caustics.volume_sun_samples=4"})
        EXPECT_TRUE(seen.insert(parse(kMedia, {change}).fingerprint()).second) << change;
}

TEST(Fingerprint, DoesNotSeeHowThingsAreWritten) {
    const std::string a =
        parse(
            "clip: {fps: 24, frames: 1-8}\nwater: {surface: {type: waves}, absorption: 0.5}\n"
            "objects: [{shape: box, size: [1 m, 20 cm, 3 mm]}]\n"
            "output: {exposure: {keys: [{frame: 1, value: 0}, {frame: 25, value: 1}]}}")
            .fingerprint();
    const std::string b =
        parse(
            "# the same\noutput:\n  exposure:\n    keys: [{time: 0 s, value: 0.0 EV}, {time: "
            "1000 ms, value: 1, interpolation: step}]\nobjects:\n  - size: [1, 0.2, 0.003]\n"
            "    shape: box\nwater: {absorption: [0.5 /m, 500 /km, 0.5], surface: {type: waves}}\n"
            "clip: {frames: 1-400, fps: 48/2, samples: 4}")
            .fingerprint();
    EXPECT_EQ(a, b);
}

TEST(Fingerprint, IsTheSameInAnotherFolder) {
    const std::string text = "dapple: 1\nobjects: [{shape: mesh, file: a.ply}]\n";
    EXPECT_EQ(Timeline::parse(text, "t", "/a").fingerprint(), Timeline::parse(text, "t", "/b").fingerprint());
}

TEST(Fingerprint, SeesEveryChange) {
    std::set<std::string> seen{parse(kPool).fingerprint()};
    for (const char* change : {"clip.name=other",
                               "clip.fps=24",
                               "clip.frames=1000-1048",
                               "clip.resolution=[97, 54]",
                               "clip.samples=3",
                               "clip.seed=8",
                               "camera.position=[1 m, -50 cm, 2001 mm]",
                               "camera.projection=orthographic",
                               "camera.up=[1, 1, 0]",
                               "water.surface.depth=3 m",
                               "water.surface.waves[0].amplitude=12.30000001 mm",
                               "water.surface.waves[0].heading=91 deg",
                               "water.surface.waves[1].wave_vector=[0, -4.1]",
                               "water.surface.waves=[]",
                               "water.surface={type: spectrum}",
                               "water.extent.type=pool",
                               "water.extent.size=[8, 5]",
                               "water.mesh_cells=65",
                               "water.refractive_index=1.33",
                               "water.dispersion=0.0055",
                               "water.diffuse_attenuation=0.1",
                               "lights.sun.elevation=31 deg",
                               "lights.sun.azimuth=91 deg",
                               "lights.sun.angular_diameter=0",
                               "lights.spot.target=[0, 0, 1]",
                               "lights.spot.cone_angle=20 deg",
                               "lights=[]",
                               "objects.floor.shape=box",
                               "objects.rock.file=props/stone.obj",
                               "objects.rock.material.mirror=false",
                               "objects.rock.rotation=[0, 1, 0]",
                               "sky.radiance=0.2",
                               "caustics.map_resolution=257",
                               "caustics.cascades=2",
                               "caustics.cascade_scale=3",
                               "caustics.inner_size=1 m",
                               "caustics.cascade_center=extent",
                               "caustics={method: photon_splatting, cascade_maps: [{resolution: 256}]}",
                               "caustics.paper_faithful=true",
                               "caustics={method: sliced_beams}",
                               "caustics={method: sliced_beams, sun_samples: 2}",
                               "caustics={method: reference}",
                               "caustics={method: reference, standard_error: 0.5 %}",
                               "caustics={method: reference, most_rays: 10}",
                               "caustics={buffer_scale: half}",
                               "caustics={buffer_scale: quarter}",
                               "caustics={denoise: {filter: fixed}}",
                               "caustics={denoise: {filter: fixed, radius: 6}}",
                               "caustics={denoise: {filter: fixed, passes: 10}}",
                               "caustics={denoise: {filter: adaptive}}",
                               "caustics={denoise: {filter: adaptive, threshold: 0.144}}",
                               "caustics={denoise: {filter: adaptive, paper_faithful: true}}",
                               "output.ocio_config=other.ocio",
                               "output.view=Raw",
                               "output.look=warm",
                               "output.exposure=0.1",
                               "output.exposure.interpolation=step",
                               "output.exposure.keys[1].value=0.8",
                               "output.exposure.keys[1].frame=1026",
                               "output.cdl.offset=0.01"}) {
        std::vector<std::string> changes{change};
        if (changes[0] == "camera.projection=orthographic")  // which has no field of view
            changes = {"camera={projection: orthographic}"};
        EXPECT_TRUE(seen.insert(parse(kPool, changes).fingerprint()).second) << change;
    }
}

TEST(Timeline, DemosAreValid) {
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(DAPPLE_SOURCE_DIR) / "sequences")) {
        if (entry.path().extension() != ".yaml") continue;
        EXPECT_NO_THROW(Timeline::load(entry.path().string())) << entry.path();
    }
}

}  // namespace
}  // namespace dapple::timeline
