// What judging a frame of 1920 by 1080 costs in CPU time, all threads summed, beside the least that any
// metric must do: read the planes from memory.
//
// Least of several runs on cores of 2.6 GHz (Zen 4), in ms: reading 3, errors 5, SSIM 37 (boxes 11), FLIP 80,
// HDR-FLIP 62 an exposure and 20 for the map's figures; HDR-FLIP at 6 exposures of a frame to its reference
// and of both to the frames before them, 910. Half of an exposure is filters, 30 ms: eight pixels of a pair
// take 370 loads, 120 of which lie across two cache lines; at two lines a cycle that is 24 ms. The rest is
// colours and powers.
#include <benchmark/benchmark.h>

#include <cmath>

#include "base/hash.h"
#include "base/parallel.h"
#include "metrics/errors.h"
#include "metrics/flip.h"
#include "metrics/lanes.h"
#include "metrics/ssim.h"

namespace {

using namespace dapple;
using metrics::Picture;

constexpr int kWidth = 1920, kHeight = 1080;

/// Waves with noise: no part is flat, so that nothing is skipped.
Picture scene(std::uint64_t seed) {
    Picture picture;
    picture.width = kWidth;
    picture.height = kHeight;
    for (std::vector<float>& plane : picture.rgb) plane.resize(picture.pixels());
    picture.luminance.resize(picture.pixels());
    for (std::size_t i = 0; i < picture.pixels(); ++i) {
        const double wave = 0.5 + 0.3 * std::sin(0.01 * static_cast<double>(i % kWidth));
        for (std::uint32_t c = 0; c < 3; ++c) {
            picture.rgb[c][i] = static_cast<float>(wave + 0.1 * hash_uniform(seed, 0, i, c));
        }
        picture.luminance[i] = picture.rgb[1][i];
    }
    return picture;
}

const Picture& picture() {
    static const Picture made = scene(1);
    return made;
}

const Picture& reference() {
    static const Picture made = scene(2);
    return made;
}

void errors(benchmark::State& state) {
    const Picture &a = picture(), &b = reference();
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(metrics::errors_of(a, b, 1, 0.5));
}

void ssim(benchmark::State& state, metrics::SsimWindow window) {
    const Picture &a = picture(), &b = reference();
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(metrics::ssim(a, b, {.window = window}));
}

void flip_ldr(benchmark::State& state) {
    const Picture &a = picture(), &b = reference();
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(metrics::flip_ldr(a, b));
}

void flip_hdr(benchmark::State& state) {
    const Picture &a = picture(), &b = reference();
    const metrics::Exposures exposures{-3, 3, static_cast<int>(state.range(0))};
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(metrics::flip_hdr(a, b, exposures));
}

/// A frame with its reference, and each with the frame before it.
void flip_hdr_and_delta(benchmark::State& state) {
    const Picture &a = picture(), &b = reference(), before = scene(3), reference_before = scene(4);
    const std::vector<metrics::FlipPair> pairs{{&a, &b}, {&a, &before}, {&b, &reference_before}};
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(metrics::flips_hdr(pairs, {-3, 3, 6}));
}

void exposures(benchmark::State& state) {
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(metrics::exposures_of({&reference()}));
}

/// The least that any metric of both pictures must do: read their six planes once.
void read_planes(benchmark::State& state) {
    const Picture &a = picture(), &b = reference();
    std::vector<float> sums(kHeight);
    for ([[maybe_unused]] auto _ : state) {
        parallel_for(kHeight, 16, [&](std::size_t begin, std::size_t end) {
            metrics::Floats sum = metrics::all(0);
            for (const Picture* source : {&a, &b}) {
                for (const std::vector<float>& plane : source->rgb) {
                    for (std::size_t i = begin * kWidth; i < end * kWidth; i += metrics::kFloatLanes) {
                        sum += metrics::load(plane.data() + i);
                    }
                }
            }
            sums[begin] = sum[0];
        });
        benchmark::DoNotOptimize(sums.data());
    }
    state.SetBytesProcessed(state.iterations() * std::int64_t{6} * kWidth * kHeight * 4);
}

BENCHMARK(errors)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(ssim, gaussian, metrics::SsimWindow::gaussian)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(ssim, boxes, metrics::SsimWindow::boxes)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK(flip_ldr)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(flip_hdr)->Arg(2)->Arg(6)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(flip_hdr_and_delta)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(exposures)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(read_planes)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
