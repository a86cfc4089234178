#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "end_to_end/program.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing_tools::ScratchFolder;
using Json = nlohmann::json;

class Probe : public testing::Test {
protected:
    testing_tools::Outcome probe(std::vector<std::string> arguments, const std::string& timeline = "probe") {
        arguments.insert(arguments.begin(), {"probe", kFolder + "/" + timeline + ".yaml"});
        return run_dapple(scratch, arguments);
    }

    Json views(std::vector<std::string> arguments, const std::string& timeline = "probe") {
        arguments.emplace_back("--json");
        const auto outcome = probe(arguments, timeline);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        return Json::parse(outcome.output).at("views");
    }

    ScratchFolder scratch;
};

TEST_F(Probe, FlatWaterHasOnePathAndItsClosedForm) {
    const Json found = views({"32", "18"});
    ASSERT_THAT(found, SizeIs(1));
    EXPECT_EQ(found[0].at("sees"), "receiver");
    const Json receiver = found[0].at("receiver");
    EXPECT_EQ(receiver.at("object"), "floor");
    EXPECT_EQ(receiver.at("in_water"), true);
    EXPECT_EQ(receiver.at("behind_specular"), false);
    EXPECT_NEAR(receiver.at("position")[0].get<double>(), 0.05, 1e-6);  // the pixel's centre; float positions
    EXPECT_NEAR(receiver.at("position")[1].get<double>(), -2, 1e-6);
    EXPECT_NEAR(receiver.at("position")[2].get<double>(), 0.05, 1e-6);
    EXPECT_NEAR(receiver.at("distance").get<double>(), std::hypot(0.5, 0.05, 0.05), 1e-6);
    EXPECT_EQ(receiver.at("count"), 1);
    EXPECT_EQ(receiver.at("sign_sum"), 1);
    EXPECT_EQ(receiver.at("fold"), false);

    ASSERT_THAT(receiver.at("paths"), SizeIs(1));
    const Json path = receiver.at("paths")[0];
    EXPECT_EQ(path.at("chain"), "sun > water:T");
    EXPECT_TRUE(path.at("blocked_by").is_null());
    EXPECT_NEAR(path.at("jacobian").get<double>(), 1, 1e-6);
    EXPECT_EQ(path.at("sign"), 1);
    EXPECT_NEAR(path.at("way").get<double>(), 2, 1e-6);
    EXPECT_NEAR(path.at("water_point")[0].get<double>(), 0.05, 1e-6);
    EXPECT_NEAR(path.at("water_point")[1].get<double>(), 0, 1e-6);
    EXPECT_NEAR(path.at("direction")[1].get<double>(), -1, 1e-6);
    const double transmittance = 1 - std::pow(0.333 / 2.333, 2);
    const double absorption[] = {0.4, 0.1, 0.03};
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const double expected = 2 * transmittance * std::exp(-2 * absorption[channel]);
        // 1e-5: positions in float.
        EXPECT_NEAR(path.at("irradiance")[channel].get<double>(), expected, 1e-5);
        EXPECT_NEAR(receiver.at("irradiance")[channel].get<double>(), expected, 1e-5);
    }

    ASSERT_THAT(receiver.at("oracle"), SizeIs(1));
    EXPECT_EQ(receiver.at("oracle")[0], (Json{{"chain", "sun > water:T"},
                                              {"paths", 1},
                                              {"sign_sum", 1},
                                              {"behind_waves", 0},
                                              {"proven", true}}));
}

TEST_F(Probe, NamesWhatBlocksAPathAndWhere) {
    const auto blocked = [&](const char* x) {
        const Json receiver = views({x, "18"})[0].at("receiver");
        EXPECT_EQ(receiver.at("object"), "floor");
        EXPECT_EQ(receiver.at("irradiance"), Json({0.0, 0.0, 0.0}));
        EXPECT_EQ(receiver.at("count"), 1);
        const Json path = receiver.at("paths")[0];
        EXPECT_GT(path.at("irradiance")[2].get<double>(), 1);  // as if nothing blocked it
        return path.at("blocked_by").get<std::string>() + ": " +
               path.at("blocked_between").get<std::string>();
    };
    EXPECT_EQ(blocked("22"), "buoy: light and water");
    EXPECT_EQ(blocked("42"), "raft: water and receiver");
    const auto text = probe({"22", "18"});
    EXPECT_THAT(text.output, HasSubstr("blocked by buoy between light and water"));
    EXPECT_THAT(text.output, HasSubstr("sum: E (0, 0, 0) W/m^2"));
}

TEST_F(Probe, WavesHaveAsManyPathsAsTheOracleProves) {
    int folded = 0;
    for (const char* x : {"8", "26", "32", "44", "56"}) {
        const Json receiver =
            views({x, "30", "-f", "3", "--set", "water.surface.waves[0].amplitude=4 cm"}, "small")[0].at(
                "receiver");
        const Json oracle = receiver.at("oracle")[0];
        EXPECT_EQ(oracle.at("proven"), true) << x;
        EXPECT_EQ(receiver.at("count").get<std::size_t>(), receiver.at("paths").size());
        double red = 0;
        int signs = 0;
        for (const Json& path : receiver.at("paths")) {
            if (path.at("blocked_by").is_null()) red += path.at("irradiance")[0].get<double>();
            signs += path.at("sign").get<int>();
        }
        EXPECT_NEAR(receiver.at("irradiance")[0].get<double>(), red, 1e-12);
        EXPECT_EQ(receiver.at("sign_sum"), signs);
        EXPECT_EQ(signs, 1) << x;
        if (receiver.at("fold") == false) {
            EXPECT_EQ(receiver.at("count"), oracle.at("paths")) << x;
        }
        folded += receiver.at("count") > 1 ? 1 : 0;
    }
    EXPECT_GT(folded, 0) << "single paths test little";
}

TEST_F(Probe, TheOracleCountsWhatWavesHideApart) {
    // Waves of 35 degrees under a sun of 20: shadows on the water.
    const std::vector<std::string> rough = {"--set", "water.surface.waves=[{length: 1 m, amplitude: 11 cm}]",
                                            "--set", "water.mesh_cells=192",
                                            "--set", "lights.sun.elevation=20 deg"};
    int hidden = 0, compared = 0;
    for (const char* x : {"30", "31", "32", "33", "34", "35", "36"}) {
        std::vector<std::string> arguments = {x, "9"};
        arguments.insert(arguments.end(), rough.begin(), rough.end());
        const Json receiver = views(arguments)[0].at("receiver");
        const Json oracle = receiver.at("oracle")[0];
        hidden += oracle.at("behind_waves").get<int>();
        if (oracle.at("proven") == false || receiver.at("fold") == true) continue;
        EXPECT_EQ(oracle.at("paths"), receiver.at("count")) << x;
        EXPECT_EQ(oracle.at("sign_sum"), receiver.at("sign_sum")) << x;
        ++compared;
        if (oracle.at("behind_waves") > 0) {
            EXPECT_THAT(probe(arguments).output,
                        HasSubstr(", " + std::to_string(oracle.at("behind_waves").get<int>()) +
                                  " more behind waves, sum of signs "));
        }
    }
    EXPECT_GT(hidden, 0);
    EXPECT_GT(compared, 3);
}

TEST_F(Probe, ANamelessLightAndObjectHaveOneNameEverywhere) {
    const std::string plane = "objects=[{shape: plane, size: [10 m, 1 m, 10 m], position: [0 m, -2 m, 0 m]}]";
    const std::vector<std::string> nameless = {
        "32", "18", "--set", "lights=[{type: sun, elevation: 90 deg, irradiance: 2}]", "--set", plane};
    const Json receiver = views(nameless)[0].at("receiver");
    EXPECT_EQ(receiver.at("object"), "objects[0]");
    EXPECT_EQ(receiver.at("paths")[0].at("chain"), "lights[0] > water:T");
    EXPECT_EQ(receiver.at("oracle")[0].at("chain"), "lights[0] > water:T");
}

TEST_F(Probe, AreaLightsAreChainsByTheirPoints) {
    const std::string lights =
        "lights=[{type: sun, elevation: 90 deg, irradiance: 2}, {name: panel, type: quad, position: [0 m, 2 "
        "m, "
        "0 m], target: [0 m, 0 m, 0 m], size: [1 m, 1 m], radiance: 3, samples: 12}]";
    const Json receiver = views({"32", "18", "--set", lights})[0].at("receiver");
    ASSERT_THAT(receiver.at("paths"), SizeIs(13));
    ASSERT_THAT(receiver.at("oracle"), SizeIs(13));
    EXPECT_EQ(receiver.at("paths")[0].at("chain"), "lights[0] > water:T");
    for (std::size_t i = 1; i < 13; ++i) {
        const std::string chain = "panel, point " + std::to_string(i) + " of 12 > water:T";
        EXPECT_EQ(receiver.at("paths")[i].at("chain"), chain);
        EXPECT_EQ(receiver.at("oracle")[i].at("chain"), chain);
        EXPECT_EQ(receiver.at("oracle")[i].at("paths"), 1);
    }
    const std::string text = probe({"32", "18", "--set", lights}).output;
    EXPECT_THAT(text, HasSubstr("\npanel, point 2 of 12 > water:T: 1 path\n"));
    EXPECT_LT(text.find("\npanel, point 2 of"), text.find("\npanel, point 10 of"));
}

TEST_F(Probe, TheOracleKnowsWhereALampSendsNoLight) {
    for (const char* lamp : {"type: quad, size: [1 m, 1 m], radiance: 3, samples: 1, target: [0 m, 3 m, 0 m]",
                             "type: spot, cone_angle: 20 deg, target: [3 m, 0 m, 0 m]"}) {
        const Json receiver =
            views({"32", "18", "--set",
                   "lights=[{name: lamp, position: [0 m, 2 m, 0 m], " + std::string(lamp) + "}]"})[0]
                .at("receiver");
        EXPECT_EQ(receiver.at("count"), 0) << lamp;
        EXPECT_EQ(receiver.at("oracle")[0].at("paths"), 0) << lamp;
        EXPECT_EQ(receiver.at("oracle")[0].at("proven"), true) << lamp;
    }
}

TEST_F(Probe, NotesAFrameOutsideTheClipOnStderr) {
    const char* note = "frame 9 lies outside the clip, where its curves hold";
    EXPECT_THAT(probe({"32", "18", "-f", "9"}).output, HasSubstr(note));
    EXPECT_THAT(probe({"32", "18", "-f", "4"}).output, Not(HasSubstr("outside")));
    const std::string json =
        std::string("\"") + DAPPLE_PROGRAM + "\" probe \"" + kFolder + "/probe.yaml\" 32 18 -f 9 --json";
    const auto shell = [&](const std::string& command) {
        return testing_tools::run_program({"sh", "-c", command}, scratch / "output.txt").output;
    };
    EXPECT_THAT(shell(json + " 2>&1 >/dev/null"), HasSubstr(note));
    EXPECT_EQ(Json::parse(shell(json + " 2>/dev/null")).at("frame"), 9);
}

TEST_F(Probe, PrintsForPeople) {
    const auto outcome = probe({"32.5", "18.25", "-f", "2"});
    EXPECT_EQ(outcome.code, 0);
    for (const char* expected :
         {"frame 2, picture point (32.5, 18.25)", "receiver: floor at (0.05, -2, 0.025) m",
          "in the water, seen directly", "sun > water:T: 1 path\n", "lit\n", "1 path, sum of signs +1",
          "oracle: sun > water:T: 1 path, sum of signs +1, proven"}) {
        EXPECT_THAT(outcome.output, HasSubstr(expected));
    }
}

TEST_F(Probe, IsAVerb) {
    EXPECT_THAT(run_dapple(scratch, {"--help"}).output, HasSubstr("probe"));
    EXPECT_THAT(run_dapple(scratch, {"probe", "--help"}).output, HasSubstr("the oracle"));
}

TEST_F(Probe, SaysWhatAPixelWithoutReceiverSees) {
    const auto sky = probe(
        {"32", "18", "--set", "camera.position=[0 m, 5 m, 0 m]", "--set", "camera.target=[0 m, 6 m, 0 m]"});
    EXPECT_EQ(sky.code, 0);
    EXPECT_THAT(sky.output, HasSubstr("no receiver: it sees the sky"));
    const auto dark = probe({"32", "18", "--set", "camera.target=[1 m, -1.5 m, 0 m]"});
    EXPECT_EQ(dark.code, 0);
    EXPECT_THAT(dark.output, HasSubstr("no receiver: it sees nothing"));
    EXPECT_EQ(views({"32", "18", "--set", "camera.target=[1 m, -1.5 m, 0 m]"})[0].at("sees"), "nothing");
}

TEST_F(Probe, FollowsBothPathsOfASplit) {
    // From above the water: the floor through it, and the sky by it.
    const Json found = views(
        {"32", "18", "--set", "camera.position=[0 m, 2 m, 0 m]", "--set", "camera.target=[1 m, 0 m, 0 m]"});
    ASSERT_THAT(found, SizeIs(2));
    EXPECT_EQ(found[0].at("receiver").at("object"), "floor");
    EXPECT_EQ(found[0].at("receiver").at("behind_specular"), true);
    EXPECT_EQ(found[0].at("receiver").at("count"), 1);
    EXPECT_EQ(found[1].at("sees"), "sky");
}

TEST_F(Probe, RefusesPlacesOutsideThePicture) {
    for (const char* x : {"64", "-1", "-0.5", "64.0", "nan", "1e1", "", "3,5", "99999999999"}) {
        const auto outcome = probe({"--", x, "18"});
        EXPECT_EQ(outcome.code, 2) << x;
        EXPECT_THAT(outcome.output, HasSubstr("ERROR [2] X '")) << x;
        EXPECT_THAT(outcome.output, HasSubstr("take a pixel, 0 to 63")) << x;
    }
    EXPECT_THAT(probe({"63", "36"}).output,
                HasSubstr("Y '36' is no place in the picture: take a pixel, 0 to 35"));
    EXPECT_EQ(probe({"63", "35"}).code, 0);
    EXPECT_EQ(probe({"3"}).code, 2);
}

}  // namespace
}  // namespace dapple::end_to_end
