// What the figures in time cost for one frame of 1920 x 1080. BandFlicker's is that of 16 frames, after which
// a window is due.
#include <benchmark/benchmark.h>

#include "base/hash.h"
#include "metrics/band_flicker.h"
#include "metrics/bias_flicker.h"
#include "metrics/differences.h"
#include "metrics/flicker.h"
#include "metrics/warping.h"

namespace {

using namespace dapple;
using namespace dapple::metrics;

constexpr int kWidth = 1920, kHeight = 1080;

const std::vector<Picture>& frames() {
    static const std::vector<Picture> frames = [] {
        std::vector<Picture> all(3);
        for (std::size_t t = 0; t < all.size(); ++t) {
            Picture& picture = all[t];
            picture.width = kWidth;
            picture.height = kHeight;
            for (std::vector<float>* plane :
                 {&picture.rgb[0], &picture.rgb[1], &picture.rgb[2], &picture.luminance}) {
                plane->resize(picture.pixels());
                for (std::size_t i = 0; i < plane->size(); ++i) {
                    (*plane)[i] = static_cast<float>(hash_uniform(1, t, i, 0));
                }
            }
        }
        return all;
    }();
    return frames;
}

void frame_flicker(benchmark::State& state) {
    for ([[maybe_unused]] auto _ : state) {
        benchmark::DoNotOptimize(metrics::frame_flicker(frames()[0], frames()[1], frames()[2]).mean);
    }
}

void bias_flicker(benchmark::State& state) {
    BiasFlicker split;
    for ([[maybe_unused]] auto _ : state) split.add(frames()[0], frames()[1]);
    benchmark::DoNotOptimize(split.split().flicker_energy);
}

void band_flicker(benchmark::State& state) {
    BandFlicker bands(24);
    for ([[maybe_unused]] auto _ : state) {
        for (std::size_t t = 0; t < BandFlicker::kWindow / 2; ++t) bands.add(frames()[t % 3].luminance);
    }
    benchmark::DoNotOptimize(bands.bands());
    state.SetItemsProcessed(state.iterations() * BandFlicker::kWindow / 2);
}

void temporal_difference(benchmark::State& state) {
    for ([[maybe_unused]] auto _ : state) {
        benchmark::DoNotOptimize(
            metrics::temporal_difference(frames()[0], frames()[1], frames()[2], frames()[0]).mae);
    }
}

void warping_error(benchmark::State& state) {
    Motion motion{kWidth, kHeight, std::vector<float>(frames()[0].pixels(), 0.3f),
                  std::vector<float>(frames()[0].pixels(), -1.6f)};
    for ([[maybe_unused]] auto _ : state) {
        benchmark::DoNotOptimize(metrics::warping_error(frames()[0], frames()[1], motion).mean_square);
    }
}

BENCHMARK(frame_flicker)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(bias_flicker)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(band_flicker)
    ->Name("band_flicker/16_frames")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK(temporal_difference)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(warping_error)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
