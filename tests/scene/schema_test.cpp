#include "scene/schema.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "base/number_pattern.h"

namespace dapple::scene {
namespace {

void for_each_structure(const Structure& structure, const std::function<void(const Structure&)>& visit) {
    visit(structure);
    for (const Field& field : structure.fields)
        if (field.structure != nullptr) for_each_structure(*field.structure, visit);
}

std::string row(const Structure& structure, const Field& field) {
    return std::string(structure.name) + "." + std::string(field.key);
}

TEST(Schema, EveryRowCanBeUsed) {
    for_each_structure(frame_schema(), [](const Structure& structure) {
        for (const Field& field : structure.fields) {
            const bool integral = field.kind == FieldKind::integer || field.kind == FieldKind::boolean ||
                                  field.kind == FieldKind::choice;
            EXPECT_EQ(field.components != nullptr, field.kind == FieldKind::numbers) << row(structure, field);
            EXPECT_EQ(field.get != nullptr && field.set != nullptr, integral) << row(structure, field);
            EXPECT_EQ(field.choices.empty(), field.kind != FieldKind::choice) << row(structure, field);
            EXPECT_EQ(field.member != nullptr, !integral && field.kind != FieldKind::numbers)
                << row(structure, field);
            EXPECT_EQ(field.resize != nullptr && field.element != nullptr && field.size != nullptr,
                      field.kind == FieldKind::list)
                << row(structure, field);
            EXPECT_LE(field.range.low, field.range.high) << row(structure, field);
        }
    });
}

TEST(Schema, KeysAreUniqueForEachType) {
    for_each_structure(frame_schema(), [](const Structure& structure) {
        std::set<std::string> seen;
        for (const Field& field : structure.fields) {
            if (field.only_for.empty()) {
                EXPECT_TRUE(seen.insert(std::string(field.key)).second) << row(structure, field);
            }
            for (const std::string_view type : field.only_for) {
                EXPECT_TRUE(seen.insert(std::string(type) + "/" + std::string(field.key)).second)
                    << row(structure, field);
                const Field* chooser = structure.find(structure.type_key, {});
                ASSERT_NE(chooser, nullptr) << structure.name;
                EXPECT_NE(std::find(chooser->choices.begin(), chooser->choices.end(), type),
                          chooser->choices.end())
                    << row(structure, field);
                EXPECT_EQ(structure.find(field.key, type), &field);
            }
        }
    });
}

TEST(Schema, DefaultsAreInRange) {
    FrameState state;
    const std::function<void(const Structure&, void*)> check = [&](const Structure& structure, void* object) {
        for (const Field& field : structure.fields) {
            if (field.kind == FieldKind::structure) check(*field.structure, field.member(object));
            if (field.kind == FieldKind::list) {
                field.resize(object, 1);
                check(*field.structure, field.element(object, 0));
            }
            if (field.no_default) continue;
            if (field.get != nullptr && field.kind == FieldKind::integer) {
                EXPECT_TRUE(field.range.contains(static_cast<double>(field.get(object))))
                    << row(structure, field);
            }
            if (field.components == nullptr) continue;
            for (const double* number : field.components(object))
                if (number != nullptr) {
                    EXPECT_TRUE(field.range.contains(*number)) << row(structure, field);
                }
        }
    };
    check(frame_schema(), &state);
}

TEST(Schema, ChoicesFollowTheirEnumerations) {
    const Structure& lights = *frame_schema().find("lights", {})->structure;
    const Structure& objects = *frame_schema().find("objects", {})->structure;
    const Structure& water = *frame_schema().find("water", {})->structure;
    const Structure& surface = *water.find("surface", {})->structure;
    const auto index = [](const Structure& structure, const char* key, const char* name,
                          std::string_view type = {}) {
        const auto& choices = structure.find(key, type)->choices;
        return std::find(choices.begin(), choices.end(), name) - choices.begin();
    };
    EXPECT_EQ(index(lights, "type", "spot"), static_cast<int>(LightType::spot));
    EXPECT_EQ(index(lights, "type", "point"), static_cast<int>(LightType::point));
    EXPECT_EQ(index(objects, "shape", "box"), static_cast<int>(Shape::box));
    EXPECT_EQ(index(objects, "shape", "sphere"), static_cast<int>(Shape::sphere));
    EXPECT_EQ(index(objects, "shape", "mesh"), static_cast<int>(Shape::mesh));
    const Structure& media = *frame_schema().find("media", {})->structure;
    const Structure& phase = *media.find("phase", {})->structure;
    const Structure& caustics = *frame_schema().find("caustics", {})->structure;
    EXPECT_EQ(index(media, "type", "grid"), static_cast<int>(MediumType::grid));
    EXPECT_EQ(index(media, "side", "air"), static_cast<int>(MediumSide::air));
    EXPECT_EQ(index(media, "side", "water"), static_cast<int>(MediumSide::water));
    EXPECT_EQ(index(phase, "type", "henyey_greenstein"), static_cast<int>(PhaseType::henyey_greenstein));
    EXPECT_EQ(index(phase, "type", "fournier_forand"), static_cast<int>(PhaseType::fournier_forand));
    EXPECT_EQ(index(phase, "type", "table"), static_cast<int>(PhaseType::table));
    EXPECT_EQ(index(water, "jerlov", "I"), static_cast<int>(JerlovType::I));
    EXPECT_EQ(index(water, "jerlov", "9C"), static_cast<int>(JerlovType::C9));
    EXPECT_EQ(index(caustics, "volume_resolution", "half"), static_cast<int>(VolumeResolution::half));
    EXPECT_EQ(index(caustics, "buffer_scale", "half", "sliced_beams"), static_cast<int>(BufferScale::half));
    EXPECT_EQ(index(caustics, "buffer_scale", "quarter", "sliced_beams"),
              static_cast<int>(BufferScale::quarter));
    const Structure& denoise = *caustics.find("denoise", "sliced_beams")->structure;
    EXPECT_EQ(index(denoise, "filter", "fixed"), static_cast<int>(DenoiseFilter::fixed));
    EXPECT_EQ(index(denoise, "filter", "adaptive"), static_cast<int>(DenoiseFilter::adaptive));
    EXPECT_EQ(index(surface, "type", "spectrum"), static_cast<int>(WaterSurfaceType::spectrum));
    EXPECT_EQ(index(surface, "type", "mesh_sequence"), static_cast<int>(WaterSurfaceType::mesh_sequence));
}

TEST(Schema, ReferenceNamesEveryKey) {
    const std::string reference = key_reference();
    for_each_structure(frame_schema(), [&](const Structure& structure) {
        for (const Field& field : structure.fields)
            EXPECT_NE(reference.find(std::string(field.key) + ": "), std::string::npos)
                << row(structure, field);
    });
    EXPECT_NE(reference.find(
                  "angular_diameter: angle (deg, rad, mrad), >= 0 deg, < 90 deg, default 0.53 deg, keyed"),
              std::string::npos);
}

TEST(Schema, ReferenceTellsWhichMethodAKeyIsFor) {
    const std::string reference = key_reference();
    for (const char* line :
         {"  method: sliced_beams, photon_splatting, reference, adaptive_beams, caustic_mesh, default ",
          "  levels: whole number, >= 0, <= 12, default 3 [method: adaptive_beams]\n",
          "  sun_samples: whole number, >= 1, <= 1024, default 1 [method: sliced_beams]\n",
          "  path_counts: true or false, default true [method: sliced_beams]\n",
          "  standard_error: number (%), > 0, default 0.01 [method: reference]\n",
          "  most_rays: whole number, >= 1, <= 1000000, default 1000 [method: reference]\n",
          "  dispersion: number (%), >= 0, <= 0.2, default 0, keyed or constant\n",
          "  resolution: [width, height], >= 1, <= 16384, default [960, 540]\n"})
        EXPECT_NE(reference.find(line), std::string::npos) << line;
}

TEST(MeshSequence, ShowsTheFileThatBeganLast) {
    MeshSequence files;
    files.pattern = "/a/sea.%04d.ply";
    files.first_file = 10;
    files.last_file = 20;
    files.fps = 24;
    // Every frame of a clip at the files' own rate shows its own file, whatever frame / fps * fps rounds to.
    for (int frame = 0; frame <= 10; ++frame) EXPECT_EQ(file_number(files, frame / 24.0), 10 + frame);
    EXPECT_EQ(file_number(files, 0.9 / 24), 10);
    EXPECT_EQ(file_number(files, 1e6), 20);
    EXPECT_EQ(file_number(files, -1), 10);
    EXPECT_EQ(file_path(files, 10), "/a/sea.0010.ply");
    files.pattern = "/a/sea_##_x.obj";
    EXPECT_EQ(file_path(files, 7), "/a/sea_07_x.obj");
    EXPECT_EQ(file_path(files, 123), "/a/sea_123_x.obj");
    files.pattern = "%d.ply";
    EXPECT_EQ(file_path(files, 7), "7.ply");
}

TEST(Medium, ShowsTheFileThatBeganLast) {
    Medium smoke;
    smoke.file = "/take#2/smoke.%03d.vdb";
    smoke.first_file = 5;
    smoke.last_file = 7;
    EXPECT_EQ(file_number(smoke, 0), 5);
    EXPECT_EQ(file_number(smoke, 2), 7);
    EXPECT_EQ(file_number(smoke, 3), 7);   // holds
    EXPECT_EQ(file_number(smoke, -4), 5);  // before the clip
    smoke.step = 1.0 / 3;
    for (int frame = 0; frame < 9; ++frame) EXPECT_EQ(file_number(smoke, frame), 5 + frame / 3);
    smoke.step = 1;
    smoke.loop = true;
    EXPECT_EQ(file_number(smoke, 3), 5);
    EXPECT_EQ(file_number(smoke, 1000000), 6);  // 333333 * 3 + 1
    EXPECT_EQ(file_number(smoke, -1), 7);
    EXPECT_EQ(file_path(smoke, 5), "/take#2/smoke.005.vdb");
    smoke.file = "/take#2/smoke.vdb";
    EXPECT_EQ(file_path(smoke, 5), smoke.file);
}

TEST(Medium, JerlovTypesGetMoreTurbid) {
    using enum JerlovType;
    EXPECT_EQ(jerlov_coefficients(none).absorption, glm::dvec3(0));
    EXPECT_EQ(jerlov_coefficients(none).scattering, glm::dvec3(0));
    for (const auto& types : {std::vector{I, IA, IB, II, III}, std::vector{C1, C3, C5, C7, C9}}) {
        WaterCoefficients clearer;
        for (const JerlovType type : types) {
            const WaterCoefficients water = jerlov_coefficients(type);
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(water.absorption, clearer.absorption)));
            EXPECT_TRUE(glm::all(glm::greaterThan(water.scattering, clearer.scattering)));
            EXPECT_GT(water.scattering.b, water.scattering.r);  // small particles scatter blue most
            clearer = water;
        }
    }
}

TEST(MeshSequence, FindsThePlaceOfTheNumber) {
    EXPECT_EQ(find_number("sea.%04d.ply").begin, 4U);
    EXPECT_EQ(find_number("sea.%04d.ply").length, 4U);
    EXPECT_EQ(find_number("a####b").digits, 4U);
    for (const char* none :
         {"", "sea.ply", "%", "%04", "%x", "50%.ply", "%04d.%04d", "##.#", "%99999999999d"})
        EXPECT_EQ(find_number(none).length, 0U) << none;
}

}  // namespace
}  // namespace dapple::scene
