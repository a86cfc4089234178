#include "judge/bench_error_times.h"

#include <algorithm>
#include <cmath>

#include "judge/text.h"

namespace dapple::judge {
namespace {

constexpr const ErrorKind* kColumns[] = {&kL1Inside, &kRmse};

const ReferenceNoise* noise_of(const BenchResult& result, Judged what) {
    if (!result.reference) return nullptr;
    if (what == Judged::layer) return &result.reference->noise;
    return result.reference->scattered ? &*result.reference->scattered : nullptr;
}

/// The reference's time and noise; 0 where it has none.
std::pair<double, double> reference_point(const BenchResult& result, Judged what, Clock clock,
                                          const ErrorKind& kind) {
    const ReferenceNoise* noise = noise_of(result, what);
    if (noise == nullptr) return {0, 0};
    return {clock == Clock::wall ? result.reference->wall_s : result.reference->cpu_s,
            (noise->*kind.noise).value_or(0)};
}

}  // namespace

TimesAndErrors times_and_errors(const BenchResult& result, std::size_t ladder, Judged what, Clock clock,
                                const ErrorKind& kind) {
    TimesAndErrors points;
    for (const RungResult& rung : result.rungs) {
        if (rung.rung.ladder != ladder || !rung.failure.empty()) continue;
        if (what == Judged::scattered && !rung.scattered) continue;
        const ClipErrors& errors = what == Judged::scattered ? *rung.scattered : rung.judged.errors;
        const Spread& time = clock == Clock::wall ? rung.timing.wall_s : rung.timing.cpu_s;
        points.emplace_back(time.median, errors.*kind.error);
    }
    std::sort(points.begin(), points.end());
    return points;
}

TimesAndErrors reference_times_and_errors(const BenchResult& result, Judged what, Clock clock,
                                          const ErrorKind& kind) {
    auto [seconds, noise] = reference_point(result, what, clock, kind);
    TimesAndErrors points;
    if (!(seconds > 0 && noise > 0)) return points;
    for (const double least = 1e-3 * seconds; seconds > least && (points.empty() || noise < 1);
         seconds /= 4, noise *= 2)
        points.emplace_back(seconds, noise);
    std::reverse(points.begin(), points.end());
    return points;
}

TimeToError time_to(const BenchResult& result, std::size_t ladder, Judged what, Clock clock,
                    const ErrorKind& kind, double error) {
    return time_to_error(times_and_errors(result, ladder, what, clock, kind), error);
}

TimeToError reference_time_to(const BenchResult& result, Judged what, Clock clock, const ErrorKind& kind,
                              double error) {
    const auto [seconds, noise] = reference_point(result, what, clock, kind);
    if (!(seconds > 0 && noise > 0)) return {TimeToError::State::not_known, 0};
    return {TimeToError::State::reached, seconds * noise * noise / (error * error)};
}

std::vector<std::vector<std::string>> times_to_errors(const BenchResult& result) {
    std::vector<std::vector<std::string>> rows;
    const bool scatters = noise_of(result, Judged::scattered) != nullptr;
    const auto add = [&](const std::string& name, Clock clock, const auto& text) {
        rows.push_back({name + (clock == Clock::wall ? ": wall" : ": CPU")});
        for (const ErrorKind* kind : kColumns)
            for (const double error : kErrorsOfInterest)
                rows.back().push_back(text(Judged::layer, clock, *kind, error));
        if (!scatters) return;
        for (const double error : kErrorsOfInterest)
            rows.back().push_back(text(Judged::scattered, clock, kL1, error));
    };
    for (std::size_t i = 0; i < result.ladders.size(); ++i)
        for (const Clock clock : {Clock::wall, Clock::cpu})
            add(result.ladders[i].name(), clock,
                [&](Judged what, Clock by, const ErrorKind& kind, double error) {
                    return to_string(time_to(result, i, what, by, kind, error));
                });
    for (const Clock clock : {Clock::wall, Clock::cpu})
        add("reference", clock, [&](Judged what, Clock by, const ErrorKind& kind, double error) {
            return to_string(reference_time_to(result, what, by, kind, error));
        });
    return rows;
}

std::string to_string(const TimeToError& time) {
    if (time.state == TimeToError::State::not_reached) return "not reached";
    if (time.state == TimeToError::State::not_known) return "not known";
    return (time.state == TimeToError::State::at_most ? "<= " : "") + formatted("%.3f s", time.seconds);
}

}  // namespace dapple::judge
