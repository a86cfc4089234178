#pragma once

namespace dapple::methods::sliced_beams {

struct Part {
    double from, to;
};

/// The parts of [from, to], two at most, in ascending order, where c0 + c1 t + c2 t^2 + c3 t^3 is positive.
/// Returns how many.
int positive_parts(const double (&c)[4], double from, double to, Part (&parts)[2]);

}  // namespace dapple::methods::sliced_beams
