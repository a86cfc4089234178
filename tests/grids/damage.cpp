#include "grids/damage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <iostream>
#include <map>
#include <random>

#include "base/error.h"
#include "grids/test_files.h"
#include "grids/vdb_file.h"
#include "source_dir.h"

namespace dapple::grids {
namespace {

void flip_bit(char& byte, std::size_t bit) {
    byte = static_cast<char>(byte ^ 1 << bit);
}

std::string damaged(std::string bytes, std::mt19937& random) {
    // The first part says where all others are, and of what type.
    const std::size_t reach = random() % 3 == 0 ? 1500 : bytes.size();
    switch (random() % 4) {
        case 0:
            flip_bit(bytes[random() % reach], random() % 8);
            break;
        case 1:
            for (int i = 0; i < 30; ++i) flip_bit(bytes[random() % reach], random() % 8);
            break;
        case 2:
            bytes.resize(random() % bytes.size());
            break;
        default: {
            const std::size_t begin = random() % reach;
            const std::size_t length = std::min<std::size_t>(bytes.size() - begin, 1 + random() % 64);
            for (std::size_t i = 0; i < length; ++i) bytes[begin + i] = static_cast<char>(random());
            break;
        }
    }
    return bytes;
}

}  // namespace

void expect_damage_is_survived(unsigned seed, int count) {
    const TestFolder folder("damage_" + std::to_string(seed));
    const std::string whole = read_bytes(DAPPLE_SOURCE_DIR "/sequences/assets/smoke/smoke.0001.vdb");
    ASSERT_GT(whole.size(), 60000U);
    const std::string path = folder.file("damaged.vdb");
    std::mt19937 random(seed);
    std::map<int, int> outcomes;
    for (int i = 0; i < count; ++i) {
        write_bytes(path, damaged(whole, random));
        try {
            const auto grid = read_vdb(path, "density", std::size_t{256} << 20);
            EXPECT_TRUE(std::isfinite(grid->maximum()));
            ++outcomes[0];
        } catch (const Error& error) {
            const bool told =
                error.code() == ExitCode::input_unreadable || error.code() == ExitCode::out_of_memory_budget;
            EXPECT_TRUE(told) << i << ": " << error.what();
            EXPECT_LE(std::strlen(error.what()), 1024U) << i;
            EXPECT_EQ(std::strchr(error.what(), '\n'), nullptr) << i;
            ++outcomes[static_cast<int>(error.code())];
        }
    }
    for (const auto& [outcome, times] : outcomes)
        std::cout << "exit code " << outcome << ": " << times << "\n";
    EXPECT_GT(outcomes[static_cast<int>(ExitCode::input_unreadable)], count / 4);
}

}  // namespace dapple::grids
