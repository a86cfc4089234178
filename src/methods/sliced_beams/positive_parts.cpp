#include "methods/sliced_beams/positive_parts.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods::sliced_beams {

int positive_parts(const double (&c)[4], double from, double to, Part (&parts)[2]) {
    const auto value = [&](double t) { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); };
    // Monotone between the places where the slope is 0.
    double ends[4] = {from, to, to, to};
    const double discriminant = c[2] * c[2] - 3 * c[3] * c[1];
    if (discriminant > 0) {
        const double q = -(c[2] + std::copysign(std::sqrt(discriminant), c[2]));
        const double r1 = q / (3 * c[3]), r2 = c[1] / q;
        if (r1 > from && r1 < to) ends[2] = r1;
        if (r2 > from && r2 < to) ends[3] = r2;
    }
    std::sort(ends, ends + 4);
    int count = 0;
    for (int i = 0; i < 3; ++i) {
        double low = ends[i], high = ends[i + 1];
        const bool starts = value(low) > 0, stops = value(high) > 0;
        if (low == high || (!starts && !stops)) continue;
        if (starts != stops) {
            double inside = starts ? low : high, outside = starts ? high : low;
            for (int step = 0; step < 60; ++step) {
                const double middle = 0.5 * (inside + outside);
                (value(middle) > 0 ? inside : outside) = middle;
            }
            (starts ? high : low) = inside;
            if (low == high) continue;
        }
        if (count > 0 && parts[count - 1].to == low)
            parts[count - 1].to = high;
        else if (count < 2)
            parts[count++] = {low, high};
    }
    return count;
}

}  // namespace dapple::methods::sliced_beams
