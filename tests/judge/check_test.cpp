#include "judge/check.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/hash.h"
#include "base/stats.h"
#include "image/exr.h"
#include "image/png.h"
#include "image/temporary_folder.h"
#include "judge/check_report.h"
#include "judge/synthetic_clip.h"

namespace dapple::judge {
namespace {

using dapple::test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFrames = 18;

/// "kind frame", of every finding.
std::vector<std::string> found(const CheckResult& result) {
    std::vector<std::string> texts;
    for (const Finding& finding : result.findings) {
        texts.push_back(std::string(name_of(finding.kind)) + " " +
                        (finding.frame ? std::to_string(*finding.frame) : "clip"));
        EXPECT_LT(line_of(finding).size(), 1024U);
        EXPECT_EQ(line_of(finding).find('\n'), std::string::npos);
    }
    return texts;
}

class Check : public testing::Test {
protected:
    CheckResult check_clip(bool with_reference = false) {
        CheckOptions options;
        options.sequence = folder / "clip";
        if (with_reference) {
            test::write_clip(folder / "reference", kFrames);
            options.reference = folder / "reference";
        }
        return check(options);
    }
    std::string path(int frame) const { return test::frame_path(folder / "clip", frame); }
    /// Findings of a clip with an edit.
    std::vector<std::string> findings(const test::Edit& edit, bool with_reference = false) {
        test::write_clip(folder / "clip", kFrames, edit);
        return found(check_clip(with_reference));
    }
    TemporaryFolder folder;
};

TEST_F(Check, ACleanClipPasses) {
    test::write_clip(folder / "clip", kFrames);
    const CheckResult alone = check_clip();
    EXPECT_THAT(found(alone), IsEmpty());
    EXPECT_THAT(alone.notes, IsEmpty());
    EXPECT_GT(alone.flicker.mean, 0);
    const CheckResult against = check_clip(true);
    EXPECT_THAT(found(against), IsEmpty());
    EXPECT_EQ(against.clip.at("rmse").mean, 0);
    EXPECT_EQ(against.clip.at("flip").mean, 0);
    EXPECT_EQ(against.clip.at("ssim").mean, 1);
    EXPECT_TRUE(std::isinf(against.clip.at("psnr").mean));
    EXPECT_EQ(against.flicker.flicker, 0);
}

TEST_F(Check, MissingFramesAreFound) {
    test::write_clip(folder / "clip", kFrames);
    for (const int frame : {5, 9, 10}) std::filesystem::remove(path(frame));
    const CheckResult result = check_clip();
    EXPECT_THAT(found(result), ElementsAre("missing 5", "missing 9"));
    EXPECT_EQ(result.findings[1].last_frame, 10);
}

TEST_F(Check, ADuplicateIsFoundAndItsConsequencesAreNot) {
    const auto repeat = [](int number, image::Image& frame) {
        if (number == 6) frame = test::clean_frame(5);
    };
    EXPECT_THAT(findings(repeat), ElementsAre("duplicate 6"));
    EXPECT_THAT(findings(repeat, true), ElementsAre("duplicate 6"));
    EXPECT_THAT(findings([](int number, image::Image& frame) {
                    if (number == 9) frame = test::clean_frame(3);
                }),
                ElementsAre("duplicate 9"));
}

TEST_F(Check, AStillOrHeldClipIsNoRowOfDuplicates) {
    test::write_clip(folder / "clip", kFrames, [](int number, image::Image& frame) {
        const int drawing = (number + 1) / 2;
        frame = test::clean_frame(drawing);
    });
    const CheckResult held = check_clip();
    EXPECT_THAT(found(held), IsEmpty());
    EXPECT_THAT(held.notes, ElementsAre(HasSubstr("9 of 17")));
    // An odd number of frames has as many repeats as changes; begun with a single frame one less.
    std::filesystem::remove(path(kFrames));
    const CheckResult odd = check_clip();
    EXPECT_THAT(found(odd), IsEmpty());
    EXPECT_THAT(odd.notes, ElementsAre(HasSubstr("8 of 16")));
    std::filesystem::remove(path(1));
    EXPECT_THAT(found(check_clip()), IsEmpty());
}

TEST_F(Check, ARepeatAmongFewFramesIsADuplicate) {
    test::write_clip(folder / "clip", 3, [](int number, image::Image& frame) {
        if (number == 2) frame = test::clean_frame(1);
    });
    EXPECT_THAT(found(check_clip()), ElementsAre("duplicate 2"));
    // Three in a row of 8 frames are no animation on twos, though as many of their pairs.
    std::filesystem::remove_all(folder / "clip");
    test::write_clip(folder / "clip", 8, [](int number, image::Image& frame) {
        if (number >= 4 && number <= 6) frame = test::clean_frame(3);
    });
    const CheckResult stuck = check_clip();
    EXPECT_THAT(found(stuck), ElementsAre("duplicate 4", "duplicate 5", "duplicate 6"));
}

TEST_F(Check, FramesThatAreLeftOutAreGaps) {
    // Alternating brightness: of every second frame nothing is known of its neighbours.
    test::write_clip(folder / "clip", kFrames,
                     [](int number, image::Image& frame) { test::scale(frame, number % 4 == 1 ? 1.5 : 1); });
    test::write_clip(folder / "reference", kFrames);
    CheckOptions options;
    options.sequence = folder / "clip";
    options.reference = folder / "reference";
    options.frames = FrameSet::parse("1-17x2");
    options.limits.max_flicker = 0;
    const CheckResult apart = check(options);
    EXPECT_EQ(apart.frames.size(), 9U);
    for (const FrameFigures& figures : apart.frames) {
        EXPECT_TRUE(figures.errors);
        EXPECT_FALSE(figures.temporal) << figures.frame;
        EXPECT_FALSE(figures.difference) << figures.frame;
    }
    EXPECT_THAT(apart.bands, IsEmpty());
    EXPECT_THAT(found(apart), IsEmpty());
    EXPECT_THAT(apart.notes, ElementsAre(HasSubstr("--max-flicker: no frame has both neighbours")));

    // Two runs that differ: none knows the other.
    test::write_clip(folder / "clip", kFrames, [](int number, image::Image& frame) {
        if (number > 8) test::scale(frame, 2);
    });
    options.limits = {};
    options.reference = "";
    options.frames = FrameSet::parse("1-7,11-18");
    const CheckResult runs = check(options);
    EXPECT_THAT(found(runs), IsEmpty());
    EXPECT_FALSE(runs.frames[6].temporal);
    EXPECT_FALSE(runs.frames[7].temporal);
    EXPECT_TRUE(runs.frames[8].temporal);
    options.frames = FrameSet::parse("1-7");
    const CheckResult first = check(options);
    options.frames = FrameSet::parse("11-18");
    const CheckResult second = check(options);
    for (std::size_t band = 0; band < runs.bands.size(); ++band) {
        EXPECT_NEAR(runs.bands[band].energy,
                    (7 * first.bands[band].energy + 8 * second.bands[band].energy) / 15, 1e-9);
    }
    EXPECT_GT(runs.bands.size(), 0U);
}

TEST_F(Check, AClipThatFadesInAndOutHasNoJumps) {
    const auto fade = [](int number, image::Image& frame) {
        // Black at both ends; nearly so the frames beside them.
        const double ease = std::sin(3.14159265358979 * (number - 1) / (kFrames - 1));
        test::scale(frame, number == 1 || number == kFrames ? 0 : ease * ease);
    };
    EXPECT_THAT(findings(fade), IsEmpty());
    const CheckResult clean = check_clip();
    EXPECT_GT(clean.level, 0.5 * clean.flicker.mean);
    EXPECT_THAT(findings([&](int number, image::Image& frame) {
                    fade(number, frame);
                    if (number == 9) test::scale(frame, 4, 60, 20, 20, 20);
                }),
                ElementsAre("pop 9"));
}

TEST_F(Check, ABlackClipIsCleanAndHasNoFlicker) {
    EXPECT_THAT(findings([](int number, image::Image& frame) {
                    test::scale(frame, 0);
                    frame.channels[0].values[static_cast<std::size_t>(number)] = 0.25f;
                }),
                IsEmpty());
}

TEST_F(Check, WhatIsOddAboutTheFirstOrLastFrameIsFoundThere) {
    EXPECT_THAT(findings([](int number, image::Image& frame) {
                    if (number == 1) test::scale(frame, 1.5);
                }),
                ElementsAre("jump 1"));
    EXPECT_THAT(findings([](int number, image::Image& frame) {
                    if (number == 1) test::scale(frame, 0, 40, 16, 40, 40);
                }),
                ElementsAre("jump 1"));
    EXPECT_THAT(findings([](int number, image::Image& frame) {
                    if (number == kFrames) test::scale(frame, 1.5);
                }),
                ElementsAre("jump " + std::to_string(kFrames)));
}

TEST_F(Check, AFrameWithoutANumberIsNoPartOfTheMean) {
    const auto blank = [](int number, image::Image& frame) {
        if (number != 7) return;
        for (image::Channel& channel : frame.channels) {
            std::ranges::fill(channel.values, std::numeric_limits<float>::quiet_NaN());
        }
    };
    test::write_clip(folder / "clip", kFrames, blank);
    const CheckResult result = check_clip();
    EXPECT_THAT(found(result), ElementsAre("not_finite 7"));
    double mean = 0;
    for (const FrameFigures& figures : result.frames) {
        if (figures.frame != 7) mean += figures.mean / (kFrames - 1);
    }
    EXPECT_NEAR(result.flicker.mean, mean, 1e-12 * mean);
    EXPECT_TRUE(std::isnan(result.frames[6].mean));
    EXPECT_FALSE(result.frames[5].temporal);  // it has no neighbour
    EXPECT_TRUE(result.frames[4].temporal);
    EXPECT_THAT(found(check_clip(true)), ElementsAre("not_finite 7"));
}

TEST_F(Check, MeansOfFrameAndReferenceAreOfTheSamePixels) {
    test::write_clip(folder / "clip", 3);
    test::write_clip(folder / "reference", 3, [](int number, image::Image& frame) {
        if (number != 2) return;
        for (std::size_t i = 0; i < 4000; ++i) {
            frame.channels[0].values[i] = std::numeric_limits<float>::infinity();
        }
    });
    CheckOptions options;
    options.sequence = folder / "clip";
    options.reference = folder / "reference";
    const CheckResult result = check(options);
    EXPECT_EQ(result.frames[1].mean, *result.frames[1].reference_mean);
    EXPECT_EQ(result.frames[1].errors->largest, 0);
}

TEST_F(Check, DeltaFlipIsThatOfTheMapsOneByOne) {
    test::write_clip(folder / "clip", 3, [](int number, image::Image& frame) {
        test::scale(frame, number == 2 ? 1.3 : 1);
        // Excluded in one frame alone.
        if (number == 3) frame.channels[1].values[500] = std::numeric_limits<float>::infinity();
    });
    test::write_clip(folder / "reference", 3);
    CheckOptions options;
    options.sequence = folder / "clip";
    options.reference = folder / "reference";
    for (const FlipKind kind : {FlipKind::hdr, FlipKind::ldr}) {
        options.flip = kind;
        options.delta_flip = false;
        const CheckResult without = check(options);
        options.delta_flip = true;
        const CheckResult with = check(options);
        EXPECT_FALSE(with.frames[0].delta_flip);
        const auto picture = [](int number, double factor) {
            image::Image frame = test::clean_frame(number);
            test::scale(frame, factor);
            return metrics::picture_of(frame, "", "test");
        };
        const auto map = [&](const metrics::Picture& a, const metrics::Picture& b) {
            return kind == FlipKind::ldr ? metrics::flip_ldr(a, b).map
                                         : metrics::flip_hdr(a, b, *with.exposures).map;
        };
        metrics::Picture frames[] = {picture(1, 1), picture(2, 1.3), picture(3, 1)};
        metrics::Picture references[] = {picture(1, 1), picture(2, 1), picture(3, 1)};
        for (int i = 1; i < 3; ++i) {
            const auto& flip = with.frames[static_cast<std::size_t>(i)].flip;
            // What is asked for besides must not change the figure to the reference.
            EXPECT_EQ(flip->mean, without.frames[static_cast<std::size_t>(i)].flip->mean);
            if (i == 2) {
                for (auto* pictures : {frames, references}) {
                    for (int k : {1, 2}) {
                        pictures[k].excluded = {500};
                        for (auto& plane : pictures[k].rgb) plane[500] = 0;
                    }
                }
            }
            const auto expected = metrics::delta_flip(
                map(frames[i], frames[i - 1]), map(references[i], references[i - 1]), frames[i].excluded);
            const auto& delta = with.frames[static_cast<std::size_t>(i)].delta_flip;
            ASSERT_TRUE(delta);
            EXPECT_NEAR(delta->mean, expected.mean, 1e-9);
            EXPECT_NEAR(delta->mean_absolute, expected.mean_absolute, 1e-9);
        }
    }
}

TEST_F(Check, LdrFlipTakesTheValuesAsTheyAre) {
    // Of wide primaries, said to be code values: FLIP and delta-FLIP must both leave them alone, as the same
    // values without primaries show.
    const auto write = [&](const std::string& name, const image::Chromaticities& chromaticities,
                           double gain) {
        std::filesystem::create_directories(folder / name);
        for (int number = 1; number <= 2; ++number) {
            image::Image frame = test::clean_frame(number);
            test::scale(frame, number == 2 ? gain : 1);
            image::ExrOptions options;
            options.chromaticities = chromaticities;
            image::write_exr_verified(test::frame_path(folder / name, number), frame, options);
        }
    };
    const auto figures = [&](const image::Chromaticities& chromaticities) {
        write("a", chromaticities, 1.3);
        write("b", chromaticities, 1);
        CheckOptions options;
        options.sequence = folder / "a";
        options.reference = folder / "b";
        options.flip = FlipKind::ldr;
        options.delta_flip = true;
        return check(options).frames[1];
    };
    const FrameFigures wide = figures(image::kAcesCgChromaticities);
    const FrameFigures narrow = figures(metrics::kRec709);
    EXPECT_GT(wide.flip->mean, 0.01);
    EXPECT_EQ(wide.flip->mean, narrow.flip->mean);
    EXPECT_EQ(wide.delta_flip->mean, narrow.delta_flip->mean);
}

TEST_F(Check, TruncatedAndForeignFilesAreDamaged) {
    test::write_clip(folder / "clip", kFrames);
    std::vector<char> bytes = test::bytes_of(path(4));
    bytes.resize(bytes.size() - 100);
    test::write_bytes(path(4), bytes);
    test::write_bytes(path(11), {'n', 'o'});
    EXPECT_THAT(found(check_clip()), ElementsAre("damaged 4", "damaged 11"));
}

TEST_F(Check, PixelsThatAreNotFiniteAreFoundAndNothingElse) {
    test::write_clip(folder / "clip", kFrames, [](int number, image::Image& frame) {
        if (number != 7) return;
        for (int y = 20; y < 44; ++y) {
            for (int x = 30; x < 54; ++x) {
                frame.channels[1].values[static_cast<std::size_t>(y * test::kWidth + x)] =
                    x % 2 == 0 ? std::numeric_limits<float>::quiet_NaN()
                               : -std::numeric_limits<float>::infinity();
            }
        }
    });
    const CheckResult result = check_clip();
    EXPECT_THAT(found(result), ElementsAre("not_finite 7"));
    EXPECT_THAT(result.findings[0].text, HasSubstr("576 pixels"));
    EXPECT_THAT(result.findings[0].text, HasSubstr("(30, 20)"));
    EXPECT_EQ(result.findings[0].region->width, 24);
    EXPECT_THAT(found(check_clip(true)), ElementsAre("not_finite 7"));
}

TEST_F(Check, FlashesAndPopsAreFoundWithoutAReference) {
    EXPECT_THAT(findings([](int number, image::Image& frame) {
                    if (number == 8) test::scale(frame, 1.2);
                }),
                ElementsAre("flash 8"));
    EXPECT_THAT(findings([](int number, image::Image& frame) {
                    if (number == 5) test::scale(frame, 2, 60, 20, 20, 20);
                }),
                ElementsAre("pop 5"));
}

TEST_F(Check, ShiftAndDriftAreFoundWithAReference) {
    EXPECT_THAT(findings(
                    [](int number, image::Image& frame) {
                        if (number == 10) frame = test::clean_frame(number, 1, 0);
                    },
                    true),
                ElementsAre("shift 10"));
    EXPECT_THAT(
        findings([](int number, image::Image& frame) { test::scale(frame, 1 + 0.002 * number); }, true),
        ElementsAre("drift clip"));
    // All frames shifted alike are one finding.
    test::write_clip(folder / "clip", kFrames,
                     [](int number, image::Image& frame) { frame = test::clean_frame(number, 0, -1); });
    const CheckResult all = check_clip(true);
    EXPECT_THAT(found(all), ElementsAre("shift 1"));
    EXPECT_EQ(all.findings[0].last_frame, kFrames);
    EXPECT_NEAR(all.frames[3].shift->dy, -1, 0.1);
}

TEST_F(Check, AShiftHidesNoJumpsButItsOwn) {
    const auto shifted = [](int number, image::Image& frame) { frame = test::clean_frame(number, 1, 0); };
    const auto with = [&](const test::Edit& edit) {
        return findings(
            [&](int number, image::Image& frame) {
                shifted(number, frame);
                edit(number, frame);
            },
            true);
    };
    EXPECT_THAT(with([](int number, image::Image& frame) {
                    if (number == 8) test::scale(frame, 0.2, 60, 20, 20, 20);
                }),
                ElementsAre("pop 8", "shift 1", "shift 9"));
    // What is too strong for its frame's shift to be told makes two runs of shifted frames.
    EXPECT_THAT(with([](int number, image::Image& frame) {
                    if (number == 8) test::scale(frame, 3);
                }),
                ElementsAre("flash 8", "shift 1", "shift 9"));
    EXPECT_THAT(with([](int number, image::Image& frame) {
                    if (number == kFrames) test::scale(frame, 3);
                }),
                ElementsAre("jump " + std::to_string(kFrames), "shift 1"));
    // Where the shift begins and ends it is the cause.
    EXPECT_THAT(findings(
                    [&](int number, image::Image& frame) {
                        if (number >= 6 && number <= 12) shifted(number, frame);
                    },
                    true),
                ElementsAre("shift 6"));
    for (const int at : {1, 2, 9, kFrames}) {
        EXPECT_THAT(findings(
                        [&](int number, image::Image& frame) {
                            if (number == at) frame = test::clean_frame(number, 2, 0);
                        },
                        true),
                    ElementsAre("shift " + std::to_string(at)));
    }
}

TEST_F(Check, LimitsAreFindingsThatNameTheWorst) {
    test::write_clip(folder / "clip", kFrames, [](int, image::Image& frame) { test::scale(frame, 1.1); });
    test::write_clip(folder / "reference", kFrames);
    CheckOptions options;
    options.sequence = folder / "clip";
    options.reference = folder / "reference";
    EXPECT_THAT(found(check(options)), IsEmpty());
    options.limits.max_error = 0.2;
    options.limits.max_flicker = 1;
    options.limits.max_flip = 1;
    options.limits.min_psnr = 1;
    options.limits.min_ssim = 0.1;
    EXPECT_THAT(found(check(options)), IsEmpty());
    // A gain of 1.1 makes a relative RMSE of 0.1 sqrt(mean I^2) / mean I, a little above 0.1.
    options.limits.max_error = 0.1;
    options.limits.max_flip = 1e-3;
    options.limits.min_psnr = 80;
    options.limits.min_ssim = 0.99999;
    const CheckResult beyond = check(options);
    EXPECT_EQ(beyond.findings.size(), 4U);
    for (const Finding& finding : beyond.findings) EXPECT_EQ(finding.kind, FindingKind::limit);
}

TEST_F(Check, TheReferenceMustFit) {
    test::write_clip(folder / "clip", kFrames);
    test::write_clip(folder / "reference", kFrames);
    std::filesystem::remove(test::frame_path(folder / "reference", 3));
    CheckOptions options;
    options.sequence = folder / "clip";
    options.reference = folder / "reference";
    EXPECT_THAT(found(check(options)), ElementsAre("reference 3"));
    image::Image small;
    small.width = 16;
    small.height = 8;
    for (const char* name : {"R", "G", "B"}) small.add(name);
    test::write_raw(folder / "small.0001.exr", small);
    options.reference = folder / "small.0001.exr";
    EXPECT_THROW(check(options), Error);
}

TEST_F(Check, SinglePicturesAreComparedWhateverTheirNumbers) {
    // Two constant pictures 16/255 apart: PSNR is 20 log10(255 / 16).
    image::write_png(folder / "a.0003.png", 32, 32, std::vector<std::uint8_t>(32 * 32 * 3, 100));
    image::write_png(folder / "b.0008.png", 32, 32, std::vector<std::uint8_t>(32 * 32 * 3, 116));
    CheckOptions options;
    options.sequence = folder / "a.0003.png";
    options.reference = folder / "b.0008.png";
    const CheckResult result = check(options);
    EXPECT_EQ(result.flip_kind, FlipKind::ldr);
    EXPECT_NEAR(result.clip.at("psnr").mean, 20 * std::log10(255.0 / 16), 1e-4);
    EXPECT_GT(result.clip.at("flip").mean, 0.05);
    const auto json = nlohmann::json::parse(check_json(result));
    EXPECT_EQ(json.at("clip").at("flip").get<double>(), result.clip.at("flip").mean);
    EXPECT_EQ(json.at("frames").at(0).at("flip").at("mean").get<double>(), result.frames[0].flip->mean);
    EXPECT_EQ(json.at("clip").at("flip_kind"), "ldr");
    // The page shows both, the reference below: two crops of 192 px, 64 pixels enlarged three times.
    options.maps = true;
    options.limits.max_error = 0.01;  // a place to be shown
    EXPECT_THAT(check_html(check(options)), HasSubstr("(below: the reference)"));
}

TEST_F(Check, TextJsonAndPageSayTheSame) {
    test::write_clip(folder / "clip", kFrames, [](int number, image::Image& frame) {
        if (number == 8) test::scale(frame, 1.5);
    });
    test::write_clip(folder / "reference", kFrames);
    CheckOptions options;
    options.sequence = folder / "clip";
    options.reference = folder / "reference";
    options.maps = true;
    const CheckResult result = check(options);
    const auto json = nlohmann::json::parse(check_json(result));
    EXPECT_EQ(json.at("clean"), false);
    EXPECT_EQ(json.at("findings").at(0).at("kind"), "flash");
    EXPECT_EQ(json.at("findings").at(0).at("frame"), 8);
    EXPECT_EQ(json.at("frames").size(), static_cast<std::size_t>(kFrames));
    EXPECT_EQ(json.at("clip").at("psnr").is_number(), true);
    EXPECT_EQ(json.at("frames").at(0).at("psnr"), "inf");  // equal pictures
    const std::string text = check_text(result);
    EXPECT_THAT(text, HasSubstr("frame 8 (flash"));
    EXPECT_THAT(text, HasSubstr("FLIP, mean [0 to 1]"));
    EXPECT_THAT(text, HasSubstr("HDR"));
    const std::string page = check_html(result);
    EXPECT_NE(page.find(">RMSE of 4x4 means [pixel value]</td>"), std::string::npos);
    for (const auto& [key, figure] : result.clip) {
        EXPECT_NE(figure_name(key), key) << "a figure without a name that can be read";
        EXPECT_THAT(text, HasSubstr(figure_name(key)));
        EXPECT_EQ(page.find(">" + key + "</td>"), std::string::npos) << key;
    }
    EXPECT_THAT(page, HasSubstr("frame 8 (flash"));
    EXPECT_THAT(page, HasSubstr("<svg"));
    EXPECT_THAT(page, HasSubstr("data:image/png"));
}

TEST_F(Check, BadCallsAndInputsHaveTheirCodes) {
    const auto code_of = [](const CheckOptions& options) {
        try {
            check(options);
        } catch (const Error& error) {
            return error.code();
        }
        return ExitCode::done;
    };
    CheckOptions options;
    options.sequence = folder / "nothing";
    EXPECT_EQ(code_of(options), ExitCode::input_unreadable);
    test::write_clip(folder / "clip", 2);
    options.sequence = folder / "clip";
    options.limits.max_error = 1;
    EXPECT_EQ(code_of(options), ExitCode::usage);  // without a reference
    options.limits = {};
    options.layer = "caustics";
    EXPECT_EQ(code_of(options), ExitCode::input_unreadable);
    test::write_bytes(path(1), {'x'});
    test::write_bytes(path(2), {});
    options.layer = "";
    EXPECT_EQ(code_of(options), ExitCode::input_unreadable);
}

TEST(Finding, IsALineBelowOneKilobyteWhateverItHolds) {
    const Finding finding{FindingKind::damaged, 7, std::nullopt, std::nullopt, std::string(5000, 'a') + "\n"};
    const std::string line = line_of(finding);
    EXPECT_LT(line.size(), 1024U);
    EXPECT_THAT(line, testing::StartsWith("frame 7 (damaged): aaa"));
    EXPECT_THAT(line, testing::EndsWith("a ..."));
}

/// Random flips and cuts, in the header as well: a finding, an unreadable input, or no harm done; never
/// anything else.
TEST_F(Check, FiveHundredDamagedFilesAreFindings) {
    test::write_clip(folder / "clip", 4);
    const std::vector<char> whole = test::bytes_of(path(2));
    int unnoticed = 0;
    for (std::uint64_t i = 0; i < 500; ++i) {
        std::vector<char> bytes = whole;
        if (i % 5 == 0) {
            bytes.resize(hash_bits(11, 0, i, 0) % whole.size());
        } else {
            // Every second one within the header, which decides most.
            const std::size_t range = i % 2 == 0 ? 400 : whole.size();
            for (std::uint32_t flip = 0; flip < 1 + i % 4; ++flip) {
                const std::size_t place = hash_bits(11, i, flip, 1) % range;
                bytes[place] = static_cast<char>(bytes[place] ^ (1 << (hash_bits(11, i, flip, 2) % 8)));
            }
        }
        test::write_bytes(path(2), bytes);
        CheckOptions options;
        options.sequence = i % 10 == 9 ? path(2) : folder / "clip";
        try {
            const CheckResult result = check(options);
            for (const Finding& finding : result.findings) {
                ASSERT_LT(line_of(finding).size(), 1024U) << i;
                ASSERT_EQ(finding.frame, 2) << i << " " << line_of(finding);
            }
            unnoticed += result.findings.empty() ? 1 : 0;
        } catch (const Error& error) {
            ASSERT_EQ(error.code(), ExitCode::input_unreadable) << i;
            ASSERT_LT(std::string(error.what()).size(), 1024U) << i;
        }
    }
    // What no pixel depends on: names of attributes, the display window, the table of blocks.
    EXPECT_LT(unnoticed, 150);
}

TEST_F(Check, MemoryDoesNotGrowWithTheClip) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "AddressSanitizer keeps what was freed: the peak says nothing of what is in use";
#endif
    test::write_clip(folder / "clip", 8);
    test::write_clip(folder / "reference", 8);
    // Long clips of the same few files.
    const auto link = [&](const std::string& name, int count) {
        std::filesystem::create_directories(folder / name);
        for (int frame = 1; frame <= count; ++frame) {
            // To and fro, so that no frame equals the one before.
            const int at = (frame - 1) % 14;
            std::filesystem::create_hard_link(test::frame_path(folder / "clip", at < 8 ? at + 1 : 15 - at),
                                              test::frame_path(folder / name, frame));
        }
    };
    link("short", 60);
    link("long", 360);
    const auto peak = [&](const std::string& name) {
        CheckOptions options;
        options.sequence = folder / name;
        options.reference = folder / name;
        options.flip = FlipKind::none;
        check(options);
        return peak_memory_bytes();
    };
    const std::uint64_t before = peak("short");
    // 300 frames of 120 x 72 are 41 MB of planes; what is kept of a frame are 2 KiB, and its histogram.
    EXPECT_LT(peak("long"), before + (std::uint64_t{8} << 20));
}

}  // namespace
}  // namespace dapple::judge
