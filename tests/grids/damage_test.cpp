#include "grids/damage.h"

#include <gtest/gtest.h>

namespace dapple::grids {

TEST(DamagedVdb, EndsInAGridOrAnError) {
    expect_damage_is_survived(1, 30);
}

}  // namespace dapple::grids
