#include "judge/compare.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <utility>

#include "base/error.h"
#include "image/png.h"
#include "judge/compare_composer.h"
#include "judge/compare_layout.h"
#include "judge/compare_look.h"
#include "judge/compare_plan.h"
#include "judge/compare_sheet.h"
#include "judge/compare_survey.h"
#include "judge/sequence_reader.h"
#include "judge/text.h"
#include "report/heat_map.h"
#include "video/video_writer.h"

namespace dapple::judge {
namespace {

/// Known before hours of reading rather than after.
void check_output(const std::string& path) {
    if (path.empty()) return;
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code unknown;
    if (!folder.empty() && !std::filesystem::is_directory(folder, unknown)) {
        throw Error(ExitCode::output_unwritable, path + ": there is no folder " + folder.string());
    }
    if (std::filesystem::is_directory(path, unknown)) {
        throw Error(ExitCode::output_unwritable, path + ": is a folder");
    }
}

std::string counted(std::size_t count, const std::string& what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

void tell_beginning(const Comparison& comparison, const CompareListener& listener) {
    std::string names;
    for (std::size_t i = 0; i < comparison.labels.size(); ++i) {
        names += (i > 0 ? ", " : "") + letter(i) + " " + comparison.labels[i];
    }
    listener.note("comparing " + counted(comparison.frames.size(), "frame") + " (" +
                  frames_text(comparison.frames) + ") of " + std::to_string(comparison.width) + " x " +
                  std::to_string(comparison.height) + ": " + names);
}

void tell_survey(const Comparison& comparison, const Survey& survey, const CompareListener& listener) {
    listener.note("differences: full scale " + report::short_number(survey.difference_full) +
                  (survey.relative ? " of the mean luminance of A, " + report::short_number(survey.unit)
                   : comparison.displayed ? " of code values"
                                          : " of luminance"));
    for (std::size_t i = 0; i < survey.sequences.size(); ++i) {
        const SurveyedSequence& found = survey.sequences[i];
        listener.note(letter(i) + ": mean " + report::short_number(found.clip.mean) + ", flicker " +
                      (found.clip.frames.empty() ? "unknown" : report::short_number(found.clip.flicker)));
    }
}

void tell_blanks(const Survey& survey, const CompareListener& listener) {
    for (std::size_t i = 0; i < survey.sequences.size(); ++i) {
        const SurveyedSequence& found = survey.sequences[i];
        if (!found.missing.empty()) {
            listener.note(letter(i) + ": " + counted(found.missing.size(), "frame") +
                          " missing, drawn as blanks: " + frames_text(found.missing));
        }
        if (!found.unreadable.empty()) {
            std::vector<std::int64_t> frames;
            for (const auto& [frame, fault] : found.unreadable) frames.push_back(frame);
            listener.note(letter(i) + ": " + counted(frames.size(), "frame") +
                          " unreadable, drawn as blanks: " + frames_text(frames) +
                          "; the first: " + found.unreadable.begin()->second);
        }
        if (found.excluded > 0) {
            listener.note(letter(i) + ": " + counted(found.excluded, "pixel") +
                          " not finite: shown black, left out of all figures");
        }
    }
}

/// The second reading: composes the video and the sheet, or the sheet alone. False where it was stopped.
bool compose_all(const CompareOptions& options, const Comparison& comparison, const Look& look,
                 const Survey& survey, const Layout& layout, const CompareListener& listener) {
    const std::string view = comparison.graded ? look.description() : "code values as they are";
    std::optional<Composer> composer;
    std::optional<video::VideoWriter> writer;
    std::optional<Sheet> sheet;
    if (!options.sheet.empty()) sheet.emplace(comparison, survey, options.sheet_frames, view);
    std::vector<std::size_t> indices;
    if (!options.video.empty()) {
        composer.emplace(comparison, survey, layout, view);
        writer.emplace(options.video,
                       video::VideoFormat{layout.width, layout.height, comparison.fps.numerator,
                                          comparison.fps.denominator});
        for (std::size_t i = 0; i < comparison.frames.size(); ++i) indices.push_back(i);
    } else {
        indices = sheet->picked();
    }
    ReadOptions read;
    read.size = {comparison.width, comparison.height};
    for (const std::size_t index : indices) read.frames.push_back(comparison.frames[index]);
    SequenceReader reader(comparison.sequences, read);
    for (std::size_t done = 0; done < indices.size(); ++done) {
        if (listener.stop()) return false;
        std::vector<ComparedPicture> pictures;
        for (const ReadFrame& frame : reader.next()) pictures.push_back(look.show(frame));
        if (writer && !writer->add(composer->compose(indices[done], pictures).rgb()))
            break;  // finish() says why
        if (sheet) {
            const auto column = std::ranges::find(sheet->picked(), indices[done]);
            if (column != sheet->picked().end()) {
                sheet->add(static_cast<std::size_t>(column - sheet->picked().begin()), pictures);
            }
        }
        listener.progress("drawn", done + 1, indices.size());
    }
    if (writer) {
        const WrittenFile file = writer->finish();
        listener.note(options.video + ": " + counted(comparison.frames.size(), "frame") + ", " +
                      report::short_number(comparison.fps.value()) + " a second, " +
                      std::to_string(layout.width) + " x " + std::to_string(layout.height) + ", " +
                      report::short_number(static_cast<double>(file.bytes) / 1e6) + " MB");
    }
    if (sheet) {
        const report::Canvas& canvas = sheet->canvas();
        image::write_png(options.sheet, canvas.width(), canvas.height(), canvas.rgb());
        listener.note(options.sheet + ": " + counted(sheet->picked().size(), "frame") + ", " +
                      std::to_string(canvas.width()) + " x " + std::to_string(canvas.height()));
    }
    return true;
}

}  // namespace

CompareEnd compare(const CompareOptions& options, const CompareListener& listener) {
    if (options.video.empty() && options.sheet.empty()) {
        throw Error(ExitCode::usage, "nothing is asked for: give -o VIDEO.mp4, --sheet SHEET.png or both");
    }
    if (options.video == options.sheet) throw Error(ExitCode::usage, "video and sheet need a file each");
    check_output(options.video);
    check_output(options.sheet);
    const Comparison comparison = plan_comparison(options);
    const Look look(options.view, options.exposure, comparison.displayed);
    Layout layout;
    if (!options.video.empty()) {
        layout = plan_layout(comparison.width, comparison.height, comparison.sequences.size(),
                             comparison.frames.size(), options.parts);
    }
    tell_beginning(comparison, listener);
    const std::optional<Survey> found = survey(comparison, look, options.difference_scale, listener);
    if (!found) return CompareEnd::stopped;
    tell_survey(comparison, *found, listener);
    if (!compose_all(options, comparison, look, *found, layout, listener)) return CompareEnd::stopped;
    tell_blanks(*found, listener);
    return CompareEnd::done;
}

}  // namespace dapple::judge
