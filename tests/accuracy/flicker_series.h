#pragma once
#include <cstdio>

/// How much of a pixel's change from frame to frame a reference does not show.
namespace dapple::test {

/// What is known of a pixel's channel so far; Welford's sums.
struct Series {
    double mean = 0, squares = 0, reference_variance = 0, reference = 0;
    int frames = 0;
    void add(double difference, double reference_value, double variance) {
        ++frames;
        const double before = difference - mean;
        mean += before / frames;
        squares += before * (difference - mean);
        reference += reference_value;
        reference_variance += variance;
    }
};

/// Mean over series of Var_t of the difference, less the reference's own variance, over the squared mean.
struct FlickerSums {
    double variance = 0, reference_variance = 0, reference = 0, count = 0;
    void add(const Series& s) {
        variance += s.squares / (s.frames - 1);
        reference_variance += s.reference_variance / s.frames;
        reference += s.reference / s.frames;
        ++count;
    }
    /// Of `series` of the picture these are a part. `of`: E or S.
    void print(const char* what, const char* of, double series) const {
        const double scale = count / (reference * reference);
        std::printf("%-28s %5.1f %% of pixels: Var_t(%s - %s_ref) %.3e, %s_ref's own %.3e, flicker %.3e\n",
                    what, 100 * count / series, of, of, variance * scale, of, reference_variance * scale,
                    (variance - reference_variance) * scale);
    }
};

}  // namespace dapple::test
