#include "judge/compare_composer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "judge/compare_drawing.h"
#include "report/heat_map.h"

namespace dapple::judge {
namespace {

constexpr int kMark = 8;  // px: ticks beside panels
constexpr report::Color kDivider{255, 255, 255};

std::vector<report::Color> colors(std::size_t count) {
    std::vector<report::Color> all;
    for (std::size_t i = 0; i < count; ++i) all.push_back(color_of(i));
    return all;
}

/// One point for every frame that is shown: frames without a value are gaps.
template <class Value>
report::Plot curves(const Comparison& comparison, const Survey& survey, const Value& value) {
    report::Plot plot;
    for (const SurveyedSequence& sequence : survey.sequences) {
        report::Series series;
        for (const std::int64_t frame : comparison.frames) {
            series.points.emplace_back(static_cast<double>(frame), value(sequence, frame));
        }
        plot.series.push_back(std::move(series));
    }
    return plot;
}

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

double mean_of(const SurveyedSequence& sequence, std::int64_t frame) {
    const auto found = sequence.frames.find(frame);
    return found == sequence.frames.end() ? kGap : found->second.mean;
}

double flicker_of(const SurveyedSequence& sequence, std::int64_t frame) {
    const auto found = sequence.clip.frames.find(frame);
    return found == sequence.clip.frames.end() ? kGap : found->second.flicker;
}

/// "name      A 0.0012  B 0.0034", values in the colours of the sequences. The longest of the names that has
/// room is written.
void draw_values(report::Canvas& canvas, const Box& line, const std::vector<std::string>& names,
                 const std::vector<double>& values) {
    const int size = line.height * 4 / 7;
    int right = line.x + line.width;
    for (std::size_t i = values.size(); i-- > 0;) {
        const std::string text = letter(i) + " " + report::short_number(values[i]);
        right -= report::text_width(size, text);
        canvas.text(right, line.y + (line.height - size) / 2, size, color_of(i), text);
        right -= size;
    }
    for (const std::string& name : names) {
        if (line.x + report::text_width(line.height * 9 / 14, name) > right && &name != &names.back())
            continue;
        draw_line(canvas, {line.x, line.y, right - line.x, line.height}, name);
        return;
    }
}

/// Bright ticks left and right of a box, at a row of it.
void draw_marks(report::Canvas& canvas, const Box& box, int y, int height) {
    canvas.fill(box.x - kMark - 2, y, kMark, height, kInk);
    canvas.fill(box.x + box.width + 2, y, kMark, height, kInk);
}

}  // namespace

Composer::Composer(const Comparison& comparison, const Survey& survey, const Layout& layout,
                   const std::string& view)
    : comparison_(comparison),
      survey_(survey),
      layout_(layout),
      still_(layout.width, layout.height, kGround) {
    const std::vector<report::Color> all = colors(comparison.sequences.size());
    if (const Box& box = layout.mean_plot.box; box.width > 0) {
        mean_plot_.emplace(curves(comparison, survey, mean_of), all, box.x, box.y, box.width, box.height,
                           layout.mean_plot.caption.height / 2);
    }
    if (const Box& box = layout.flicker_plot.box; box.width > 0) {
        report::Plot plot = curves(comparison, survey, flicker_of);
        // Methods differ by powers of ten; a clip that stands still has 0, which no logarithm shows.
        plot.log_y = std::ranges::all_of(survey.sequences, [](const SurveyedSequence& sequence) {
            return std::ranges::none_of(sequence.clip.frames,
                                        [](const auto& frame) { return frame.second.flicker <= 0; });
        });
        flicker_plot_.emplace(std::move(plot), all, box.x, box.y, box.width, box.height,
                              layout.flicker_plot.caption.height / 2);
    }
    draw_still_parts(view);
}

void Composer::draw_still_parts(const std::string& view) {
    const Box& header = layout_.header;
    // The left half of the header is for frame and time.
    const int size = header.height / 2;
    const std::string shown = report::shortened(size, view, header.width / 2);
    still_.text(header.x + header.width - report::text_width(size, shown),
                header.y + (header.height - size) / 2, size, kQuiet, shown);
    for (std::size_t i = 0; i < layout_.sides.size(); ++i) {
        draw_caption(still_, layout_.sides[i].caption, i, comparison_.labels[i]);
        if (layout_.slices.empty()) continue;
        const Box& box = layout_.sides[i].box;
        draw_marks(still_, box, box.y + comparison_.slice_row * layout_.factor, layout_.factor);
    }
    for (std::size_t i = 0; i < layout_.differences.size(); ++i) {
        const Panel& panel = layout_.differences[i];
        const std::string name = difference_name(survey_, i + 1);
        draw_line(still_, panel.caption,
                  comparison_.displayed ? "difference of graded luma" : "difference of luminance");
        report::draw_scale(still_, panel.footer.x, panel.footer.y + 4, panel.footer.width,
                           panel.footer.height - 4, survey_.difference_full, name);
    }
    for (std::size_t i = 0; i < layout_.slices.size(); ++i) {
        draw_caption(still_, layout_.slices[i].caption, i,
                     "row " + std::to_string(comparison_.slice_row) + ", time down");
    }
    if (mean_plot_) {
        std::vector<double> means;
        for (const SurveyedSequence& sequence : survey_.sequences) means.push_back(sequence.clip.mean);
        draw_values(still_, layout_.mean_plot.caption,
                    {comparison_.displayed ? "mean graded luma" : "mean luminance", "mean"}, means);
        mean_plot_->draw(still_);
    }
    if (flicker_plot_) {
        std::vector<double> flicker;
        for (const SurveyedSequence& sequence : survey_.sequences) {
            flicker.push_back(sequence.clip.frames.empty() ? kGap : sequence.clip.flicker);
        }
        draw_values(still_, layout_.flicker_plot.caption, {"flicker: high-pass energy / mean²", "flicker"},
                    flicker);
        flicker_plot_->draw(still_);
    }
}

report::Canvas Composer::compose(std::size_t index, const std::vector<ComparedPicture>& pictures) const {
    assert(pictures.size() == comparison_.sequences.size());
    report::Canvas canvas = still_;
    const std::string text = frame_text(comparison_, comparison_.frames[index]) + ", " +
                             std::to_string(index + 1) + " of " + std::to_string(comparison_.frames.size());
    const Box& header = layout_.header;
    const int size = header.height * 11 / 15;
    canvas.text(header.x, header.y + (header.height - size) / 2, size, kInk,
                report::shortened(size, text, header.width / 2));
    draw_sides(canvas, pictures);
    if (layout_.wipe.box.width > 0) draw_wipe(canvas, index, pictures);
    draw_differences(canvas, pictures);
    draw_slices(canvas, index);
    const auto frame = static_cast<double>(comparison_.frames[index]);
    if (mean_plot_) mean_plot_->draw_cursor(canvas, frame);
    if (flicker_plot_) flicker_plot_->draw_cursor(canvas, frame);
    return canvas;
}

void Composer::draw_sides(report::Canvas& canvas, const std::vector<ComparedPicture>& pictures) const {
    for (std::size_t i = 0; i < layout_.sides.size(); ++i) {
        const Box& box = layout_.sides[i].box;
        if (pictures[i].rgb.empty()) {
            draw_blank(canvas, box, pictures[i].blank);
        } else {
            canvas.blit(
                box.x, box.y,
                report::enlarged(pictures[i].rgb, comparison_.width, comparison_.height, layout_.factor),
                box.width, box.height);
        }
    }
}

Composer::Wipe Composer::wipe_at(std::size_t index) const {
    const std::size_t partners = comparison_.sequences.size() - 1;
    const double place =
        static_cast<double>(index * partners) / static_cast<double>(comparison_.frames.size());
    const double part = std::floor(place), phase = place - part;
    const double share = phase < 0.25 ? 0.5 + 2 * phase : phase < 0.75 ? 1.5 - 2 * phase : 2 * phase - 1.5;
    return {1 + static_cast<std::size_t>(part),
            static_cast<int>(std::lround(share * layout_.wipe.box.width))};
}

void Composer::draw_wipe(report::Canvas& canvas, std::size_t index,
                         const std::vector<ComparedPicture>& pictures) const {
    const Wipe wipe = wipe_at(index);
    const Panel& panel = layout_.wipe;
    const Box& box = panel.box;
    draw_line(canvas, panel.caption, "wipe");
    const int half = panel.footer.width / 2 - 8;
    draw_caption(canvas, {panel.footer.x, panel.footer.y, half, panel.footer.height}, 0,
                 comparison_.labels[0]);
    draw_caption(canvas,
                 {panel.footer.x + panel.footer.width / 2 + 8, panel.footer.y, half, panel.footer.height},
                 wipe.sequence, comparison_.labels[wipe.sequence]);
    const ComparedPicture &a = pictures[0], &b = pictures[wipe.sequence];
    if (const std::string why = difference_blank(a, b, wipe.sequence); !why.empty()) {
        draw_blank(canvas, box, why);
        return;
    }
    std::vector<std::uint8_t> left =
        report::enlarged(a.rgb, comparison_.width, comparison_.height, layout_.factor);
    const std::vector<std::uint8_t> right =
        report::enlarged(b.rgb, comparison_.width, comparison_.height, layout_.factor);
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(box.width);
    for (std::size_t row = 0; row < left.size(); row += row_bytes) {
        const std::size_t from = row + 3 * static_cast<std::size_t>(wipe.divider);
        std::copy(right.begin() + static_cast<std::ptrdiff_t>(from),
                  right.begin() + static_cast<std::ptrdiff_t>(row + row_bytes),
                  left.begin() + static_cast<std::ptrdiff_t>(from));
    }
    canvas.blit(box.x, box.y, left, box.width, box.height);
    const int begin = std::max(wipe.divider - kDividerWidth / 2, 0);
    const int end = std::min(wipe.divider + kDividerWidth / 2, box.width);
    canvas.fill(box.x + begin, box.y, end - begin, box.height, kDivider);
}

void Composer::draw_differences(report::Canvas& canvas, const std::vector<ComparedPicture>& pictures) const {
    for (std::size_t i = 0; i < layout_.differences.size(); ++i) {
        const Box& box = layout_.differences[i].box;
        const ComparedPicture &a = pictures[0], &b = pictures[i + 1];
        if (const std::string why = difference_blank(a, b, i + 1); !why.empty()) {
            draw_blank(canvas, box, why);
            continue;
        }
        const std::vector<std::uint8_t> map =
            report::heat_map(difference(a.light, b.light, survey_.unit), survey_.difference_full);
        canvas.blit(box.x, box.y,
                    report::enlarged(map, comparison_.width, comparison_.height, layout_.factor), box.width,
                    box.height);
    }
}

void Composer::draw_slices(report::Canvas& canvas, std::size_t index) const {
    if (layout_.slices.empty()) return;
    const auto shown = static_cast<std::size_t>(layout_.slice_frames);
    // Of a long clip: the part around the frame.
    const std::size_t first = std::min(index - std::min(index, shown / 2), comparison_.frames.size() - shown);
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(comparison_.width);
    for (std::size_t i = 0; i < layout_.slices.size(); ++i) {
        const Box& box = layout_.slices[i].box;
        const SurveyedSequence& sequence = survey_.sequences[i];
        for (std::size_t k = 0; k < shown; ++k) {
            const int y = box.y + static_cast<int>(k) * layout_.slice_rows;
            if (!sequence.frames.contains(comparison_.frames[first + k])) {
                canvas.fill(box.x, y, box.width, layout_.slice_rows, kBlank);
                continue;
            }
            const std::vector<std::uint8_t> row =
                report::enlarged(std::span(sequence.slice).subspan((first + k) * row_bytes, row_bytes),
                                 comparison_.width, 1, layout_.factor);
            // Enlarged in width; in height each frame has its own number of rows.
            const auto line = std::span(row).first(row_bytes * static_cast<std::size_t>(layout_.factor));
            for (int copy = 0; copy < layout_.slice_rows; ++copy)
                canvas.blit(box.x, y + copy, line, box.width, 1);
        }
        const int now = box.y + static_cast<int>(index - first) * layout_.slice_rows;
        draw_marks(canvas, box, now, std::max(layout_.slice_rows, 2));
    }
}

}  // namespace dapple::judge
