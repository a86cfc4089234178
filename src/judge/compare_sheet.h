#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "judge/compare_layout.h"
#include "judge/compare_look.h"
#include "judge/compare_plan.h"
#include "judge/compare_survey.h"
#include "report/canvas.h"

namespace dapple::judge {

/// A contact sheet: a column for every picked frame; a row for every sequence and one for every difference.
/// Tiny pictures are enlarged and large ones reduced, by whole factors, a reduced pixel being the mean of its
/// code values.
class Sheet {
public:
    Sheet(const Comparison& comparison, const Survey& survey, int most_columns, const std::string& view);

    /// Indices into Comparison::frames, evenly spaced from the first to the last.
    const std::vector<std::size_t>& picked() const { return picked_; }
    /// The pictures of the frame that stands in a column.
    void add(std::size_t column, const std::vector<ComparedPicture>& pictures);
    const report::Canvas& canvas() const { return canvas_; }

    /// Where a picture stands; rows: A, B, ..., differences of B, ...
    Box cell(std::size_t column, std::size_t row) const;

private:
    /// Enlarged or reduced to a cell.
    std::vector<std::uint8_t> fitted(const std::vector<std::uint8_t>& rgb) const;

    const Comparison& comparison_;
    const Survey& survey_;
    std::vector<std::size_t> picked_;
    int factor_ = 1, divisor_ = 1;
    int cell_width_ = 0, cell_height_ = 0;
    report::Canvas canvas_;
};

/// Means of squares of divisor x divisor; what is left over at the right and below is cut off.
std::vector<std::uint8_t> reduced(const std::vector<std::uint8_t>& rgb, int width, int height, int divisor);

}  // namespace dapple::judge
