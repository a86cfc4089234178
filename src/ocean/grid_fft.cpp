#include "ocean/grid_fft.h"

#include <algorithm>
#include <cassert>
#include <kissfft/kissfft.hh>
#include <utility>

#include "base/parallel.h"

namespace dapple::ocean {

using Complex = std::complex<double>;

GridFft::GridFft(int rows, int columns, std::vector<int> used_rows)
    : rows_(rows), columns_(columns), used_rows_(std::move(used_rows)) {}

std::vector<Complex> GridFft::spectrum() const {
    return std::vector<Complex>(used_rows_.size() * static_cast<std::size_t>(columns_));
}

void GridFft::synthesise(std::vector<Complex>& z, std::span<double> f, std::span<double> g) const {
    const auto rows = static_cast<std::size_t>(rows_);
    const auto columns = static_cast<std::size_t>(columns_);
    const std::size_t stride = columns + 1;
    assert(z.size() == used_rows_.size() * columns);
    assert(f.size() == (rows + 1) * stride && (g.empty() || g.size() == f.size()));
    const bool inverse = true;  // the sign of the exponent; kissfft does not scale

    // kissfft keeps scratch memory only for radices other than 2 to 5, so const transforms may run side by
    // side.
    const kissfft<double> along_x(columns, inverse);
    parallel_for(used_rows_.size(), 4, [&](std::size_t begin, std::size_t end) {
        std::vector<Complex> line(columns);
        for (std::size_t r = begin; r < end; ++r) {
            Complex* row = z.data() + r * columns;
            std::copy(row, row + columns, line.begin());
            along_x.transform(line.data(), row);
        }
    });

    // Eight columns a tile: each row of a tile is one cache line of the results.
    const kissfft<double> along_z(rows, inverse);
    constexpr std::size_t tile = 8;
    parallel_for(columns, tile, [&](std::size_t begin, std::size_t end) {
        const std::size_t width = end - begin;
        std::vector<Complex> line(rows);
        std::vector<Complex> lines(rows * width);
        for (std::size_t c = 0; c < width; ++c) {
            for (std::size_t r = 0; r < used_rows_.size(); ++r) {
                line[static_cast<std::size_t>(used_rows_[r])] = z[r * columns + begin + c];
            }
            along_z.transform(line.data(), lines.data() + c * rows);
        }
        for (std::size_t row = 0; row < rows; ++row) {
            for (std::size_t c = 0; c < width; ++c)
                f[row * stride + begin + c] = lines[c * rows + row].real();
            if (g.empty()) continue;
            for (std::size_t c = 0; c < width; ++c)
                g[row * stride + begin + c] = lines[c * rows + row].imag();
        }
    });

    for (const std::span<double> field : {f, g}) {
        if (field.empty()) continue;
        for (std::size_t row = 0; row < rows; ++row) field[row * stride + columns] = field[row * stride];
        std::copy_n(field.begin(), stride, field.begin() + static_cast<std::ptrdiff_t>(rows * stride));
    }
}

}  // namespace dapple::ocean
