#include "judge/compare_sheet.h"

#include <algorithm>
#include <cassert>

#include "judge/compare_drawing.h"
#include "report/heat_map.h"

namespace dapple::judge {
namespace {

constexpr int kGap = 10;
constexpr int kHeader = 34;   // view
constexpr int kFrames = 24;   // number of every frame
constexpr int kCaption = 30;  // over every row
constexpr int kCell = 480;    // px that a picture has at most, each way, unless that cuts it in halves
constexpr int kNarrowest = 120;
constexpr int kScaleWidth = 320;

std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most) {
    const std::size_t columns = std::min(count, most);
    if (columns == 1) return {count / 2};
    std::vector<std::size_t> picked;
    for (std::size_t i = 0; i < columns; ++i) {
        picked.push_back((2 * i * (count - 1) + columns - 1) / (2 * (columns - 1)));  // rounded
    }
    return picked;
}

}  // namespace

std::vector<std::uint8_t> reduced(const std::vector<std::uint8_t>& rgb, int width, int height, int divisor) {
    const auto step = static_cast<std::size_t>(divisor), row_bytes = 3 * static_cast<std::size_t>(width);
    const std::size_t across = static_cast<std::size_t>(width) / step,
                      down = static_cast<std::size_t>(height) / step;
    std::vector<std::uint8_t> out;
    out.reserve(3 * across * down);
    for (std::size_t y = 0; y < down; ++y) {
        for (std::size_t x = 0; x < 3 * across; ++x) {
            std::size_t sum = 0;
            for (std::size_t i = 0; i < step * step; ++i) {
                sum += rgb[(y * step + i / step) * row_bytes + 3 * (x / 3 * step + i % step) + x % 3];
            }
            out.push_back(static_cast<std::uint8_t>((sum + step * step / 2) / (step * step)));
        }
    }
    return out;
}

Sheet::Sheet(const Comparison& comparison, const Survey& survey, int most_columns, const std::string& view)
    : comparison_(comparison),
      survey_(survey),
      picked_(evenly_spaced(comparison.frames.size(), static_cast<std::size_t>(most_columns))),
      canvas_(1, 1) {
    const int longest = std::max(comparison.width, comparison.height);
    factor_ = std::max(1, kCell / 2 / longest);
    // Long, narrow pictures keep at least a pixel.
    divisor_ = std::min({(longest + kCell - 1) / kCell, comparison.width, comparison.height});
    cell_width_ = comparison.width * factor_ / divisor_;
    cell_height_ = comparison.height * factor_ / divisor_;
    const std::size_t sequences = comparison.sequences.size();
    const Box last = cell(picked_.size() - 1, 2 * sequences - 2);
    const int width = last.x + std::max(cell_width_, kNarrowest) + kGap;
    canvas_ = report::Canvas(std::max(width, 640), last.y + cell_height_ + kGap, kGround);

    draw_line(canvas_, {kGap, 0, canvas_.width() / 2, kHeader},
              std::to_string(comparison.frames.size()) + " frames");
    const std::string shown = report::shortened(16, view, canvas_.width() / 2 - 2 * kGap);
    canvas_.text(canvas_.width() - kGap - report::text_width(16, shown), (kHeader - 16) / 2, 16, kQuiet,
                 shown);
    for (std::size_t i = 0; i < picked_.size(); ++i) {
        const Box box = cell(i, 0);
        const std::string frame = "frame " + std::to_string(comparison.frames[picked_[i]]);
        canvas_.text(box.x, kHeader, 16, kQuiet,
                     report::shortened(16, frame, std::max(cell_width_, kNarrowest)));
    }
    for (std::size_t row = 0; row < 2 * sequences - 1; ++row) {
        const Box line{kGap, cell(0, row).y - kCaption, canvas_.width() - 2 * kGap, kCaption};
        if (row < sequences) {
            draw_caption(canvas_, line, row, comparison.labels[row]);
            continue;
        }
        draw_line(canvas_, line,
                  comparison.displayed ? "difference of graded luma" : "difference of luminance");
        report::draw_scale(canvas_, line.x + line.width - kScaleWidth, line.y + 4, kScaleWidth,
                           line.height - 6, survey.difference_full,
                           difference_name(survey, row - sequences + 1));
    }
}

Box Sheet::cell(std::size_t column, std::size_t row) const {
    return {kGap + static_cast<int>(column) * (std::max(cell_width_, kNarrowest) + kGap),
            kHeader + kFrames + kCaption + static_cast<int>(row) * (cell_height_ + kCaption + kGap),
            cell_width_, cell_height_};
}

std::vector<std::uint8_t> Sheet::fitted(const std::vector<std::uint8_t>& rgb) const {
    return divisor_ > 1 ? reduced(rgb, comparison_.width, comparison_.height, divisor_)
                        : report::enlarged(rgb, comparison_.width, comparison_.height, factor_);
}

void Sheet::add(std::size_t column, const std::vector<ComparedPicture>& pictures) {
    assert(column < picked_.size() && pictures.size() == comparison_.sequences.size());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const Box box = cell(column, i);
        if (pictures[i].rgb.empty()) {
            draw_blank(canvas_, box, pictures[i].blank);
        } else {
            canvas_.blit(box.x, box.y, fitted(pictures[i].rgb), box.width, box.height);
        }
    }
    for (std::size_t i = 1; i < pictures.size(); ++i) {
        const Box box = cell(column, pictures.size() + i - 1);
        if (const std::string why = difference_blank(pictures[0], pictures[i], i); !why.empty()) {
            draw_blank(canvas_, box, why);
            continue;
        }
        const std::vector<std::uint8_t> map = report::heat_map(
            difference(pictures[0].light, pictures[i].light, survey_.unit), survey_.difference_full);
        canvas_.blit(box.x, box.y, fitted(map), box.width, box.height);
    }
}

}  // namespace dapple::judge
