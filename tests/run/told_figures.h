#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace dapple::testing_tools {

/// What stats.jsonl says about time: the text of each frame's figures, and of the clip's.
struct Told {
    std::map<std::int64_t, std::string> frames;
    std::string clip;
    bool operator==(const Told&) const = default;
};

inline Told told(const std::string& folder) {
    Told told;
    std::ifstream stream(folder + "/stats.jsonl");
    for (std::string line; std::getline(stream, line);) {
        EXPECT_EQ(told.clip, "") << "the clip's line is the last";
        const auto json = nlohmann::ordered_json::parse(line);
        if (json.contains("clip")) {
            told.clip = json.at("clip").dump();
        } else if (json.contains("temporal")) {
            const auto frame = json.at("frame").get<std::int64_t>();
            EXPECT_TRUE(told.frames.emplace(frame, json.at("temporal").dump()).second) << frame;
        }
    }
    return told;
}

}  // namespace dapple::testing_tools
