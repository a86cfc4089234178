#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <optional>

#include "base/checked_file.h"
#include "base/error.h"
#include "color/grader.h"
#include "image/temporary_folder.h"
#include "source_dir.h"

namespace dapple::color {
namespace {

using test::run_program;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

const std::string kConfig = DAPPLE_SOURCE_DIR "/src/color/shipped_config.ocio";

/// Sets or clears $OCIO for a scope.
class OcioVariable {
public:
    explicit OcioVariable(const char* value) {
        if (const char* now = std::getenv("OCIO")) before_ = now;
        value != nullptr ? ::setenv("OCIO", value, 1) : ::unsetenv("OCIO");
    }
    ~OcioVariable() { before_ ? ::setenv("OCIO", before_->c_str(), 1) : ::unsetenv("OCIO"); }
    OcioVariable(const OcioVariable&) = delete;
    OcioVariable& operator=(const OcioVariable&) = delete;

private:
    std::optional<std::string> before_;
};

std::string failure_of(const ViewSettings& settings, ExitCode code, const Grade& grade = {}) {
    try {
        const Grader grader(settings);
        grader.prepare(grade);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), code);
        return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
}

/// The shipped config with a piece of its text replaced.
std::string changed_config(const TemporaryFolder& folder, const std::string& from, const std::string& to) {
    std::string text = shipped_config();
    const std::size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos);
    text.replace(place, from.size(), to);
    std::ofstream(folder / "config.ocio") << text;
    return folder / "config.ocio";
}

TEST(ShippedConfig, PassesOciocheck) {
    EXPECT_EQ(run_program("ociocheck --iconfig '" + kConfig + "'"), 0);
}

TEST(ShippedConfig, TheCheckFindsFaults) {
    const TemporaryFolder folder;
    const std::string broken =
        changed_config(folder, "display_colorspace: <USE_DISPLAY_NAME>", "colorspace: nowhere");
    EXPECT_NE(run_program("ociocheck --iconfig '" + broken + "'"), 0);
}

TEST(ShippedConfig, IsTheOneThatIsBuiltIn) {
    const auto bytes = read_whole_file(kConfig);
    EXPECT_EQ(shipped_config(), std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

TEST(Config, ShippedWithoutPathAndVariable) {
    const OcioVariable none(nullptr);
    const ViewDescription description = Grader({}).description();
    EXPECT_EQ(description.config, "shipped");
    EXPECT_EQ(description.config_name, "dapple-aces-1.0-sdr");
    EXPECT_EQ(description.display, "sRGB");
    EXPECT_EQ(description.view, "ACES 1.0 - SDR Video");
    EXPECT_EQ(description.look, "");
    EXPECT_NE(description.config_id, "");
    const OcioVariable empty("");
    EXPECT_EQ(Grader({}).description().config, "shipped");
}

TEST(Config, PathBeatsVariableBeatsShipped) {
    const TemporaryFolder folder;
    const std::string other = changed_config(folder, "dapple-aces-1.0-sdr", "other");
    const OcioVariable variable(other.c_str());
    EXPECT_EQ(Grader({}).description().config_name, "other");
    EXPECT_EQ(Grader({}).description().config, other);
    EXPECT_EQ(Grader({kConfig, "", "", ""}).description().config_name, "dapple-aces-1.0-sdr");
}

TEST(Config, UnknownNamesListTheKnown) {
    const ExitCode code = ExitCode::timeline_invalid;
    EXPECT_THAT(failure_of({kConfig, "P3", "", ""}, code),
                AllOf(HasSubstr("no display 'P3'"), HasSubstr("'sRGB', 'Rec.1886 Rec.709'")));
    EXPECT_THAT(
        failure_of({kConfig, "", "Filmic", ""}, code),
        AllOf(HasSubstr("no view 'Filmic'"), HasSubstr("'ACES 1.0 - SDR Video', 'Un-tone-mapped', 'Raw'")));
    EXPECT_THAT(failure_of({kConfig, "", "", "Sepia"}, code),
                AllOf(HasSubstr("no look 'Sepia'"), HasSubstr("'Lagoon'")));
}

TEST(Config, VersionsThatAreTooNewSaySo) {
    const TemporaryFolder folder;
    const ExitCode code = ExitCode::input_unreadable;
    const std::string newer =
        changed_config(folder, "ocio_profile_version: 2.1", "ocio_profile_version: 2.3");
    EXPECT_THAT(failure_of({newer, "", "", ""}, code),
                AllOf(HasSubstr("version 2.3"), HasSubstr("up to version 2.1")));
    EXPECT_THAT(failure_of({"ocio://default", "", "", ""}, code), HasSubstr("OpenColorIO 2.2"));
    const OcioVariable variable("ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1");
    EXPECT_THAT(failure_of({}, code), HasSubstr("OpenColorIO 2.2"));
}

TEST(Config, BrokenFilesAreNamed) {
    const TemporaryFolder folder;
    const ExitCode code = ExitCode::input_unreadable;
    EXPECT_THAT(failure_of({folder / "none.ocio", "", "", ""}, code), HasSubstr(folder / "none.ocio"));
    std::ofstream(folder / "text.ocio") << "no config";
    EXPECT_THAT(failure_of({folder / "text.ocio", "", "", ""}, code),
                AllOf(HasSubstr(folder / "text.ocio"), HasSubstr("ocio_profile_version")));
    std::ofstream(folder / "cut.ocio") << shipped_config().substr(0, 500) << "\n  - [";
    EXPECT_THAT(failure_of({folder / "cut.ocio", "", "", ""}, code), HasSubstr(folder / "cut.ocio"));
}

TEST(Config, MissingRolesAreNamed) {
    const TemporaryFolder folder;
    const ExitCode code = ExitCode::input_unreadable;
    const std::string no_scene = changed_config(folder, "  scene_linear: ACEScg\n", "");
    EXPECT_THAT(failure_of({no_scene, "", "", ""}, code),
                AllOf(HasSubstr("scene_linear"), HasSubstr("'color_timing'")));
    const std::string no_timing = changed_config(folder, "  color_timing: ACEScct\n", "");
    Grade cdl;
    cdl.cdl.saturation = 0.5;
    EXPECT_THAT(failure_of({no_timing, "", "", ""}, code, cdl), HasSubstr("color_timing"));
    EXPECT_NO_THROW(Grader({no_timing, "", "", ""}).prepare({1, {}}));  // exposure does without
    const std::string no_texture = changed_config(folder, "  texture_paint: sRGB - Texture\n", "");
    std::vector<float> rgb{1, 1, 1};
    EXPECT_THROW(Grader({no_texture, "", "", ""}).texture_to_linear(rgb), Error);
}

TEST(Config, PrimariesOfOtherWorkingSpacesAreNotInvented) {
    const TemporaryFolder folder;
    const std::string config =
        changed_config(folder, "scene_linear: ACEScg", "scene_linear: Linear Rec.709 (sRGB)");
    EXPECT_FALSE(Grader({config, "", "", ""}).working_chromaticities().has_value());
    EXPECT_TRUE(Grader({kConfig, "", "", ""}).working_chromaticities().has_value());
}

TEST(Config, MissingLutIsFoundBeforeFrames) {
    const TemporaryFolder folder;
    const std::string config =
        changed_config(folder, "!<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}",
                       "!<FileTransform> {src: none.cube}");
    EXPECT_THAT(failure_of({config, "sRGB", "", ""}, ExitCode::input_unreadable), HasSubstr("none.cube"));
}

TEST(Config, LutsAreFoundBesideTheConfig) {
    const TemporaryFolder folder;
    std::ofstream(folder / "same.spi1d")
        << "Version 1\nFrom 0.0 1.0\nLength 2\nComponents 1\n{\n0.0\n1.0\n}\n";
    const std::string config =
        changed_config(folder, "!<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}",
                       "!<FileTransform> {src: same.spi1d}");
    EXPECT_NO_THROW(Grader({config, "sRGB", "", ""}));
}

}  // namespace
}  // namespace dapple::color
