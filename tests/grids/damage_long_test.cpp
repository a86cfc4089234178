#include <gtest/gtest.h>

#include "grids/damage.h"

namespace dapple::grids {

TEST(DamagedVdb, EndsInAGridOrAnErrorManyTimes) {
    expect_damage_is_survived(2, 500);
}

}  // namespace dapple::grids
