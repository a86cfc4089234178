#include "grids/grid_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "grids/test_files.h"

namespace dapple::grids {
namespace {

using testing::Eq;
using testing::Optional;

/// smoke.03.vdb to smoke.06.vdb, of which the fourth is not there.
class GridSequence : public testing::Test {
protected:
    GridSequence() {
        for (const char* number : {"03", "05", "06"}) {
            write_bytes(folder_.file(std::string("smoke.") + number + ".vdb"), "");
        }
        medium_.file = folder_.file("smoke.##.vdb");
        medium_.first_file = 3;
        medium_.last_file = 6;
    }
    std::string file(const std::string& number) const { return folder_.file("smoke." + number + ".vdb"); }

    TestFolder folder_{"sequence"};
    scene::Medium medium_;
};

TEST_F(GridSequence, MissingFileIsTheReadersError) {
    medium_.missing = scene::MissingGrid::error;
    EXPECT_THAT(shown_file(medium_, 0), Optional(file("03")));
    EXPECT_THAT(shown_file(medium_, 1), Optional(file("04")));
    EXPECT_THAT(shown_file(medium_, 99), Optional(file("06")));
}

TEST_F(GridSequence, FileBeforeHolds) {
    medium_.missing = scene::MissingGrid::hold;
    EXPECT_THAT(shown_file(medium_, 1), Optional(file("03")));
    EXPECT_THAT(shown_file(medium_, 2), Optional(file("05")));
    medium_.loop = true;
    EXPECT_THAT(shown_file(medium_, 5), Optional(file("03")));
    EXPECT_THAT(shown_file(medium_, -1), Optional(file("06")));
}

TEST_F(GridSequence, NothingHoldsBeforeTheFirst) {
    medium_.missing = scene::MissingGrid::hold;
    medium_.first_file = 1;
    EXPECT_THAT(shown_file(medium_, 3), Optional(file("03")));
    try {
        shown_file(medium_, 1);
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        EXPECT_THAT(error.what(), testing::HasSubstr("smoke.02.vdb"));
    }
}

TEST_F(GridSequence, NothingIsShownWhereFilesMayBeMissing) {
    medium_.missing = scene::MissingGrid::empty;
    EXPECT_THAT(shown_file(medium_, 0), Optional(file("03")));
    EXPECT_THAT(shown_file(medium_, 1), Eq(std::nullopt));
}

TEST_F(GridSequence, OneFileIsShownAlways) {
    medium_.file = file("05");
    medium_.first_file = medium_.last_file = 1;
    EXPECT_THAT(shown_file(medium_, 0), Optional(file("05")));
    EXPECT_THAT(shown_file(medium_, 77), Optional(file("05")));
}

}  // namespace
}  // namespace dapple::grids
