#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "timeline/timeline.h"

namespace dapple::timeline {
namespace {

constexpr const char* kText = R"(dapple: 1
clip: {fps: 24, frames: 1-48}
water:
  surface:
    type: waves
    waves:
      - {length: 1 m, amplitude: 1 cm}
      - {length: 2 m, amplitude: 2 cm}
lights:
  - {name: sun, type: sun, elevation: 50 deg}
  - {name: lamp, type: point, position: [0 m, 2 m, 0 m]}
)";

scene::FrameState with(const std::vector<std::string>& overrides) {
    return Timeline::parse(kText, "t.yaml", ".", overrides).at(1);
}

std::string fault_of(const std::string& text) {
    try {
        with({text});
    } catch (const TimelineError& error) {
        return to_string(error.faults().front());
    }
    return "no fault";
}

TEST(Override, ReachesKeysElementsAndNames) {
    EXPECT_EQ(with({"clip.samples=9"}).clip.samples, 9);
    EXPECT_EQ(with({"water.surface.waves[1].amplitude=5 mm"}).water->surface.waves.waves[1].amplitude, 0.005);
    EXPECT_EQ(with({"lights.lamp.position=[1 m, 2 m, 30 cm]"}).lights[1].position, glm::dvec3(1, 2, 0.3));
    EXPECT_EQ(with({"lights[lamp].intensity=7"}).lights[1].intensity, glm::dvec3(7));
    EXPECT_EQ(with({"water.surface.waves=[]"}).water->surface.waves.waves.size(), 0U);
    EXPECT_EQ(with({"lights[0]={type: point}"}).lights[0].type, scene::LightType::point);
}

TEST(Override, MakesWhatIsNotThere) {
    EXPECT_EQ(with({"output.cdl.saturation=0.5"}).output.cdl.saturation, 0.5);
}

TEST(Override, TheLastOneCounts) {
    EXPECT_EQ(with({"clip.samples=9", "clip.samples=2"}).clip.samples, 2);
}

TEST(Override, SetsCurvesAndSingleKeys) {
    const std::string curve = "output.exposure={keys: [{frame: 1, value: 3}, {frame: 2, value: 5}]}";
    EXPECT_EQ(with({curve}).output.exposure, 3);
    EXPECT_EQ(with({curve, "output.exposure.keys[0].value=4"}).output.exposure, 4);
}

TEST(Override, RepairsAFaultOfTheFile) {
    const std::string text = "dapple: 1\nclip: {samples: 0}\n";
    EXPECT_THROW(Timeline::parse(text, "t.yaml", "."), TimelineError);
    EXPECT_EQ(Timeline::parse(text, "t.yaml", ".", {"clip.samples=1"}).clip().samples, 1);
}

TEST(Override, SaysWhatIsWrong) {
    EXPECT_EQ(fault_of("lights.sun.elevaton=30 deg"),
              "--set: lights[0].elevaton: unknown key; did you mean 'elevation'?\n"
              "    lights.sun.elevaton=30 deg\n"
              "               ^");
    EXPECT_EQ(fault_of("watr.refractive_index=1.3"),
              "--set: watr: unknown key; did you mean 'water'?\n"
              "    watr.refractive_index=1.3\n"
              "    ^");
    EXPECT_EQ(fault_of("lights.sun.elevation=30 cm"),
              "--set: lights[0].elevation: expected an angle such as '30 deg' (deg, rad, mrad); '30 cm' is a "
              "length\n"
              "    lights.sun.elevation=30 cm\n"
              "                         ^");
    EXPECT_EQ(fault_of("lights.moon.elevation=30 deg"),
              "--set: lights.moon.elevation: the list has no element 'moon'; its indices are 0 to 1; its "
              "names are: "
              "sun, lamp\n"
              "    lights.moon.elevation=30 deg\n"
              "           ^");
    EXPECT_EQ(fault_of("water.surface.waves[2].amplitude=1 mm"),
              "--set: water.surface.waves[2].amplitude: the list has no element '2'; its indices are 0 to 1\n"
              "    water.surface.waves[2].amplitude=1 mm\n"
              "                        ^");
    EXPECT_EQ(fault_of("clip.fps.x=1"),
              "--set: clip.fps.x: 'x' leads into a single value, '24'\n"
              "    clip.fps.x=1\n"
              "             ^");
    EXPECT_EQ(fault_of("clip.fps"),
              "--set: expected path=value, such as camera.field_of_view=40 deg\n"
              "    clip.fps\n"
              "    ^");
    EXPECT_EQ(fault_of("clip..fps=1"),
              "--set: a key is missing here\n"
              "    clip..fps=1\n"
              "         ^");
    EXPECT_EQ(fault_of("clip.samples="),
              "--set: clip.samples: has no value; expected a whole number\n"
              "    clip.samples=\n"
              "         ^");
    EXPECT_EQ(fault_of("clip.resolution=[1, 2"),
              "--set: clip.resolution: ']' is missing, or a ',' before this\n"
              "    clip.resolution=[1, 2\n"
              "                         ^");
}

}  // namespace
}  // namespace dapple::timeline
