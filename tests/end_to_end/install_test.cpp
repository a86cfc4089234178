// The program and its reader of grids side by side in one folder, as they are installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "end_to_end/program.h"
#include "source_dir.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing_tools::ScratchFolder;

class Installed : public testing::Test {
protected:
    Installed() { std::filesystem::copy_file(DAPPLE_PROGRAM, scratch / "dapple"); }

    void install_reader() {
        std::filesystem::copy_file(DAPPLE_READER, reader, std::filesystem::copy_options::overwrite_existing);
    }
    testing_tools::Outcome run(const std::vector<std::string>& arguments) {
        std::vector<std::string> command = {scratch / "dapple"};
        command.insert(command.end(), arguments.begin(), arguments.end());
        return testing_tools::run_program(command, scratch / "output.txt");
    }
    /// The line of `dapple info` that jobs are tied to.
    std::string identity() {
        const auto outcome = run({"info"});
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        return outcome.output.substr(0, outcome.output.find('\n'));
    }

    ScratchFolder scratch;
    const std::string reader = scratch / "dapple-read-vdb";
    const std::string smoke = std::string(DAPPLE_SOURCE_DIR) + "/sequences/assets/smoke/smoke.0001.vdb";
};

TEST_F(Installed, TheReaderBesideTheProgramIsTheOneThatReads) {
    install_reader();
    const auto whole = run({"info", smoke});
    EXPECT_EQ(whole.code, 0) << whole.output;
    EXPECT_THAT(whole.output, HasSubstr("density"));
    { std::ofstream(reader, std::ios::trunc) << "#!/bin/sh\nexit 9\n"; }
    const auto other = run({"info", smoke});
    EXPECT_EQ(other.code, 4);
    EXPECT_THAT(other.output, HasSubstr("ended with code 9"));
    // Without one beside it the build's is found.
    std::filesystem::remove(reader);
    EXPECT_EQ(run({"info", smoke}).output, whole.output);
}

/// Frames of a clip fit together only where the same program has read their grids.
TEST_F(Installed, AnotherReaderIsAnotherProgram) {
    install_reader();
    const std::string before = identity();
    EXPECT_THAT(before, HasSubstr("dapple "));
    EXPECT_EQ(identity(), before);
    { std::ofstream(reader, std::ios::app) << '\0'; }
    EXPECT_NE(identity(), before);
    install_reader();
    EXPECT_EQ(identity(), before);
}

}  // namespace
}  // namespace dapple::end_to_end
