#include "methods/sliced_beams/column_spans.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace dapple::methods::sliced_beams {
namespace {

/// Reads a component's column at ascending places.
class ColumnReader {
public:
    ColumnReader(const media::DensityProfile& profile, std::size_t component)
        : profile_(profile), component_(component) {}

    double operator()(double place) {
        while (piece_ + 2 < profile_.place.size() && profile_.place[piece_ + 1] <= place) ++piece_;
        return profile_.column_to(piece_, component_, std::min(place, profile_.place.back()));
    }

private:
    const media::DensityProfile& profile_;
    std::size_t component_, piece_ = 0;
};

}  // namespace

ColumnSpan column_span(const media::DensityProfile& profile, std::size_t component, double densest,
                       double clearest, double stretch) {
    ColumnSpan span;
    const std::size_t places = profile.place.size();
    const auto column = [&](std::size_t place) {
        return profile.column[place * profile.components + component];
    };
    const double cut = 0.1 * kColumnTolerance / std::max(densest, 1e-300), all = column(places - 1);
    std::size_t low = 0, high = places - 1;
    while (low < high && column(low + 1) <= cut) ++low;
    while (high > low && (all - column(high - 1) <= cut || column(high - 1) * clearest > media::kOpaque))
        --high;
    const double begin = profile.place[low], length = profile.place[high] - begin;
    if (!(all > cut) || !(length > 0)) return span;
    span.begin = static_cast<float>(begin / stretch);
    const auto set_level = [&](int level) {
        span.level = static_cast<std::uint8_t>(level);
        span.last = ColumnSpan::points(level) - 1;
        span.inverse_step = static_cast<float>(span.last * stretch / length);
    };
    for (int level = 0; level < ColumnSpan::kLevels; ++level) {
        set_level(level);
        const std::uint32_t steps = span.last;
        // Where the density changes between two points, in their middle, or where it has a kink.
        ColumnReader at_points(profile, component), between(profile, component);
        std::size_t kink = low + 1;
        double worst = 0, before = at_points(begin);
        for (std::uint32_t i = 0; i < steps; ++i) {
            const double from = begin + length * i / steps, to = begin + length * (i + 1) / steps;
            const double after = at_points(to);
            const auto look_at = [&](double place) {
                const double t = (place - from) / (to - from);
                worst = std::max(worst, std::abs(between(place) - before - t * (after - before)));
            };
            const double middle = 0.5 * (from + to);
            for (; kink < high && profile.place[kink] < middle; ++kink) look_at(profile.place[kink]);
            look_at(middle);
            for (; kink < high && profile.place[kink] < to; ++kink) look_at(profile.place[kink]);
            before = after;
        }
        span.coarse = worst * densest > kColumnTolerance;
        if (!span.coarse) return span;
    }
    set_level(0);
    return span;
}

void fill_columns(const media::DensityProfile& profile, std::size_t component, double stretch,
                  const ColumnSpan& span, std::span<float> columns) {
    ColumnReader read(profile, component);
    const double begin = static_cast<double>(span.begin) * stretch;
    const double step = stretch / static_cast<double>(span.inverse_step);
    for (std::size_t i = 0; i < columns.size(); ++i)
        columns[i] = static_cast<float>(read(begin + step * static_cast<double>(i)));
}

}  // namespace dapple::methods::sliced_beams
