#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "base/hash.h"
#include "timeline/timeline.h"

/// Texts that no one means: whatever stands in a file, it is a timeline or a TimelineError.
namespace dapple::timeline {
namespace {

constexpr const char* kText = R"(# a comment
dapple: 1
clip: {name: pool, fps: 24000/1001, frames: 1-48, resolution: [96, 54]}
camera:
  position: {keys: [{frame: 1, value: [0 m, 1 m, 5 m]}, {time: 1 s, value: [1 m, 1 m, 5 m]}], interpolation: bezier}
water:
  surface:
    type: waves
    waves:
    - {length: 1 m, heading: 30 deg, amplitude: 12 mm}
    - &w {wave_vector: [3 rad/m, 0 rad/m], amplitude: 1 cm, phase: 90 deg}
    - *w
lights:
  - {name: "S\u00fcd", type: sun, elevation: 40 deg}
objects:
  - {shape: box, size: [1 m, 1 m, 1 m], material: {color: 0.5, mirror: false}}
)";

/// The message, or nothing for a valid text. Any other exception fails the test.
std::string message_of(const std::string& text) {
    try {
        Timeline::parse(text, "t.yaml", ".").at(1);
    } catch (const TimelineError& error) {
        return to_string(error);
    }
    return {};
}

TEST(HostileText, TheTextItselfIsValid) {
    EXPECT_EQ(message_of(kText), "");
}

TEST(HostileText, EveryPrefixIsReadOrRefused) {
    const std::string text = kText;
    for (std::size_t length = 0; length < text.size(); ++length) message_of(text.substr(0, length));
}

TEST(HostileText, EveryDamageIsReadOrRefused) {
    const std::string text = kText;
    constexpr char kBytes[] = "\0\t\n :-[]{}#&*!|>'\"%@`,?0~.\xC3\xFF";
    for (std::uint64_t i = 0; i < 4000; ++i) {
        std::string damaged = text;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::size_t at = hash_bits(1, i, k, 0) % damaged.size();
            const char byte = kBytes[hash_bits(1, i, k, 1) % (sizeof kBytes - 1)];
            if (hash_bits(1, i, k, 2) % 2 == 0)
                damaged[at] = byte;
            else
                damaged.insert(at, 1, byte);
        }
        message_of(damaged);
    }
}

TEST(HostileText, CharactersAreCheckedFirst) {
    EXPECT_EQ(message_of(std::string("dapple: 1\nclip: {name: a\0b}\n", 28)),
              "t.yaml:2:15: the text holds a NUL byte; is this a YAML file?\n    clip: {name: a b}\n"
              "                  ^\n1 fault\n");
    EXPECT_NE(message_of("dapple: 1\n# \xFF\n").find("t.yaml:2:3: not valid UTF-8"), std::string::npos);
    EXPECT_NE(message_of("dapple: 1\n# \xED\xA0\x80\n").find("not valid UTF-8"),
              std::string::npos);  // a surrogate
    EXPECT_NE(message_of("dapple: 1\n# \xC0\xAF\n").find("not valid UTF-8"), std::string::npos);  // overlong
    EXPECT_NE(message_of("dapple: 1\n# \x1B[31m\n").find("control character 27"), std::string::npos);
    EXPECT_EQ(message_of("\xEF\xBB\xBF"
                         "dapple: 1\r\nclip: {fps: 25}\r\n"),
              "");  // byte order mark, CR LF
}

TEST(HostileText, SizeAndDepthAreBounded) {
    EXPECT_NE(message_of("dapple: 1\n#" + std::string(std::size_t{17} << 20, 'x')).find("larger than 16 MiB"),
              std::string::npos);
    EXPECT_NE(
        message_of("dapple: 1\nclip: " + std::string(100'000, '[')).find("nested deeper than 64 levels"),
        std::string::npos);
}

TEST(HostileText, FilesThatCannotBeReadAreNoFaults) {
    const auto code_of = [](const std::string& path) {
        try {
            Timeline::load(path);
        } catch (const Error& error) {
            return error.code();
        }
        return ExitCode::done;
    };
    EXPECT_EQ(code_of("no/such/timeline.yaml"), ExitCode::input_unreadable);
    EXPECT_EQ(code_of("."), ExitCode::input_unreadable);
}

}  // namespace
}  // namespace dapple::timeline
