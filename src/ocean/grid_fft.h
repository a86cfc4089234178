#pragma once
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace dapple::ocean {

/// Fourier series on a periodic grid of `rows` by `columns` points (both of the form 2^a 3^b 5^c), two real
/// fields at a time: f + i g = sum over (m, n) of Z(m, n) exp(2 pi i (m column / columns + n row / rows)).
/// Only the rows of Z that hold something are stored and transformed along x: with 25 points a shortest wave
/// these are a twelfth.
class GridFft {
public:
    /// `used_rows`: rows of Z that may be non-zero, each in [0, rows), ascending.
    GridFft(int rows, int columns, std::vector<int> used_rows);

    /// Room for Z: used rows * columns, zero; row-major.
    std::vector<std::complex<double>> spectrum() const;
    /// Writes f and g (g may be empty) into row-major arrays of (rows + 1) * (columns + 1), whose last row
    /// and column repeat the first. `z` is consumed. Rows in parallel, then columns in parallel; the bits do
    /// not depend on threads.
    void synthesise(std::vector<std::complex<double>>& z, std::span<double> f, std::span<double> g) const;

private:
    int rows_;
    int columns_;
    std::vector<int> used_rows_;
};

}  // namespace dapple::ocean
