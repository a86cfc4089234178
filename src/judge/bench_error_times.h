#pragma once
#include <string>
#include <utility>
#include <vector>

#include "judge/bench_report.h"

namespace dapple::judge {

enum class Clock { wall, cpu };

/// Whose errors are looked at: of the bench's layer, or of S.
enum class Judged { layer, scattered };

/// Which of them: a member of ClipErrors, and of ReferenceNoise.
struct ErrorKind {
    double ClipErrors::*error;
    std::optional<double> ReferenceNoise::*noise;
};
inline constexpr ErrorKind kL1Inside{&ClipErrors::l1_inside, &ReferenceNoise::l1};
inline constexpr ErrorKind kL1{&ClipErrors::l1, &ReferenceNoise::l1};
inline constexpr ErrorKind kRmse{&ClipErrors::rmse_less_noise, &ReferenceNoise::rmse};

/// Seconds a frame and error, in the order of time: (s, share of the mean) of a ladder's rungs that did not
/// fail.
using TimesAndErrors = std::vector<std::pair<double, double>>;
TimesAndErrors times_and_errors(const BenchResult& result, std::size_t ladder, Judged what, Clock clock,
                                const ErrorKind& kind);

/// The same of the reference itself: its noise at the time that it took, and before, when it was larger as
/// 1 / sqrt(time), back to an error of 1 or a thousandth of that time. Empty where its noise is not known.
TimesAndErrors reference_times_and_errors(const BenchResult& result, Judged what, Clock clock,
                                          const ErrorKind& kind);

/// The errors whose time is told.
inline constexpr double kErrorsOfInterest[] = {0.05, 0.02, 0.01};

/// Seconds a frame to an error, of the rungs of a ladder; of the reference by 1 / sqrt(time), also beyond the
/// time that it took; not_known where its noise is not.
TimeToError time_to(const BenchResult& result, std::size_t ladder, Judged what, Clock clock,
                    const ErrorKind& kind, double error);
TimeToError reference_time_to(const BenchResult& result, Judged what, Clock clock, const ErrorKind& kind,
                              double error);

/// The table of these times: a row a ladder and clock, then the reference's, its name first, then those of L1
/// inside surfaces and of RMSE, and of L1 of S where the timeline scatters light.
std::vector<std::vector<std::string>> times_to_errors(const BenchResult& result);

/// "0.21 s", "<= 0.2 s", "not reached", "not known".
std::string to_string(const TimeToError& time);

}  // namespace dapple::judge
